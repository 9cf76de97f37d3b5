#include "reports/document/study/step_csv.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "reports/document/study/state_places.h"
#include "reports/render/csv.h"

namespace credence::internal {
namespace {

CsvField field(double value) { return std::isfinite(value) ? CsvField(value) : CsvField(""); }

double value_at(const std::vector<double>& values, std::size_t k) {
  return k < values.size() ? values[k] : std::nan("");
}

void add_test(std::vector<CsvField>& row, const StepTest& test) {
  row.insert(row.end(), {field(test.mean), field(test.expected), field(test.lower), field(test.upper),
                         field(test.p_value), test.count});
}

/// times: null where not known.
std::vector<CsvField> step_fields(const StepTimes* times, std::int64_t step) {
  if (times == nullptr) return {step};
  return {step, field(times->at(step))};
}

std::vector<std::string> test_columns(const StepTimes* times) {
  std::vector<std::string> columns = {"step"};
  if (times != nullptr) columns.emplace_back("time");
  for (const char* name : {"nees", "nis"}) {
    for (const char* what : {"mean", "expected", "lower", "upper", "p_value", "runs"}) {
      columns.push_back(fmt::format("{}_{}", name, what));
    }
  }
  return columns;
}

}  // namespace

void write_study_csv(const std::filesystem::path& target, const StudyAnalysis& a) {
  const StepTimes* const times = a.nees.times.get();
  std::vector<std::string> columns = test_columns(times);
  for (const char* name : {"exact_nees", "exact_nis", "trace_prior", "trace", "vehicle", "landmarks"}) {
    columns.emplace_back(name);
  }
  CsvWriter csv(target, columns);
  for (std::size_t k = 0; k < a.statistics.steps.size(); ++k) {
    std::vector<CsvField> row = step_fields(times, static_cast<std::int64_t>(k) + 1);
    add_test(row, a.nees.steps[k]);
    add_test(row, a.nis.steps[k]);
    const bool exact = k < a.exact.size();
    row.push_back(exact ? field(a.exact[k].nees) : CsvField(""));
    row.push_back(exact ? field(a.exact[k].nis) : CsvField(""));
    for (const auto* curve :
         {&a.covariance.trace_prior, &a.covariance.trace, &a.covariance.vehicle, &a.covariance.landmarks}) {
      row.push_back(field(value_at(*curve, k)));
    }
    csv.add(row);
  }
  csv.commit();
}

void write_log_csv(const std::filesystem::path& target, const LogAnalysis& a) {
  const StepTimes* const times = a.judgement.nees.times.get();
  const std::vector<std::string> columns = test_columns(times);
  CsvWriter csv(target, columns);
  for (std::size_t k = 0; k < a.evidence.study.steps.size(); ++k) {
    const std::int64_t step = 1 + static_cast<std::int64_t>(k) * a.evidence.step_stride;
    std::vector<CsvField> row = step_fields(times, step);
    add_test(row, a.judgement.nees.steps[k]);
    add_test(row, a.judgement.nis.steps[k]);
    csv.add(row);
  }
  csv.commit();
}

void write_trace_csv(const std::filesystem::path& target, const RunTrace& trace) {
  std::set<Index> seen;  // at any step
  for (const TraceStep& step : trace.steps) seen.insert(step.states.begin(), step.states.end());
  const std::vector<Index> states(seen.begin(), seen.end());
  std::vector<std::string> columns = {"step", "nees", "nees_dof", "nis", "nis_dof"};
  for (const char* what : {"truth", "estimate", "std"}) {
    for (const Index state : states) {
      columns.push_back(fmt::format("{}.{}", what, trace.layout.states[static_cast<std::size_t>(state)]));
    }
  }
  CsvWriter csv(target, columns);
  std::vector<Index> places;
  for (std::size_t k = 0; k < trace.steps.size(); ++k) {
    const TraceStep& s = trace.steps[k];
    std::vector<CsvField> row = {k, field(s.nees), s.nees_dof, field(s.nis), s.nis_dof};
    find_places(states, s.states, places);
    const auto add = [&](const auto& value_of) {
      for (const Index i : places) row.push_back(i >= 0 ? field(value_of(i)) : CsvField(""));
    };
    add([&](Index i) { return s.truth[i]; });
    add([&](Index i) { return s.estimate[i]; });
    add([&](Index i) { return std::sqrt(s.P(i, i)); });
    csv.add(row);
  }
  csv.commit();
}

}  // namespace credence::internal
