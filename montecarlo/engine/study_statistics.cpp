#include "montecarlo/engine/study_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/enum_words.h"
#include "montecarlo/engine/byte_stream.h"

namespace credence::internal {
namespace {

constexpr std::uint32_t kFormat = 4;
constexpr std::uint32_t kFormatNotConverged = 5;  // the same, and behind it the runs that are not_converged
// Without the variances of heading and landmarks.
constexpr std::uint32_t kFormatBefore = 2, kFormatBeforeNotConverged = 3;
constexpr std::size_t kStepSize = sizeof(StepStatistics);
constexpr auto kQuantitiesBefore = static_cast<std::size_t>(Quantity::heading_variance);
constexpr std::size_t kStepSizeBefore =
    kStepSize - (static_cast<std::size_t>(Quantity::count_) - kQuantitiesBefore) * sizeof(Moments);
constexpr std::size_t kFailureSize = 20;
constexpr std::size_t kNotConvergedSize = sizeof(RunNotConverged);

void put_averages(ByteWriter& w, const RunAverages& r) {
  w.put(r.moments);
  w.put(r.least_dof);
  w.put(r.first);
}

void get_averages(ByteReader& r, RunAverages& averages) {
  r.get(averages.moments);
  r.get(averages.least_dof);
  averages.first.resize(r.get_count(sizeof(double)));
  for (double& value : averages.first) r.get(value);
}

void get_step(ByteReader& r, bool before, StepStatistics& step) {
  if (!before) return r.get(step);
  for (Moments& quantity : std::span(step.quantities).first(kQuantitiesBefore)) r.get(quantity);
  r.get(step.nees_dof);
  r.get(step.nis_dof);
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

std::string_view to_string(Outcome outcome) {
  return word_of(outcome, {"ok", "diverged", "not_positive_definite", "threw"});
}

void StepStatistics::merge(const StepStatistics& other) {
  for (std::size_t i = 0; i < quantities.size(); ++i) quantities[i].merge(other.quantities[i]);
  nees_dof += other.nees_dof;
  nis_dof += other.nis_dof;
}

void StudyStatistics::merge(const StudyStatistics& other) {
  if (steps.size() != other.steps.size()) {
    throw std::invalid_argument("statistics of studies with different numbers of steps do not add up");
  }
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k].merge(other.steps[k]);
  nees_of_runs.merge(other.nees_of_runs);
  vehicle_nees_of_runs.merge(other.vehicle_nees_of_runs);
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
  not_converged.insert(not_converged.end(), other.not_converged.begin(), other.not_converged.end());
  runs += other.runs;
}

std::int64_t StudyStatistics::count(Outcome outcome) const {
  if (outcome == Outcome::ok) return runs - static_cast<std::int64_t>(failures.size());
  return std::count_if(failures.begin(), failures.end(),
                       [&](const RunFailure& f) { return f.outcome == outcome; });
}

std::vector<Moments> StudyStatistics::series(Quantity quantity) const {
  std::vector<Moments> result;
  result.reserve(steps.size());
  for (const StepStatistics& step : steps) result.push_back(step[quantity]);
  return result;
}

std::vector<double> StudyStatistics::dofs(Quantity quantity) const {
  if (quantity != Quantity::nees && quantity != Quantity::nis) {
    throw std::invalid_argument("only the dof of NEES and NIS are counted");
  }
  std::vector<double> result;
  result.reserve(steps.size());
  for (const StepStatistics& step : steps) {
    result.push_back(static_cast<double>(quantity == Quantity::nees ? step.nees_dof : step.nis_dof));
  }
  return result;
}

}  // namespace credence

namespace credence::internal {

std::string failed_text(std::int64_t failed, std::int64_t all) {
  return all == 1 ? "the only run failed" : fmt::format("{} of {} runs failed", failed, all);
}

std::string what_failed_count_in(std::int64_t failed, std::int64_t all) {
  std::string of_steps = failed == 1 ? "It counts up to the step before" : "They count up to the step before";
  if (failed >= all) return of_steps;
  return of_steps + " in what is told of single steps; means, factors, RMSE and scores are of the other runs";
}

std::optional<Outcome> outcome_named(std::string_view word) { return value_named(word, Outcome::threw); }

double most_stored_bytes(std::int64_t steps, std::int64_t runs) {
  constexpr double kHead = sizeof(kFormat) + sizeof(std::int64_t) + 3 * sizeof(std::uint64_t);
  constexpr double kAverages = 2 * (5 * sizeof(double) + sizeof(std::uint64_t));
  constexpr double kOfARun =
      std::max(kFailureSize, 2 * sizeof(double)) + kNotConvergedSize;  // it fails, or has averages
  return kHead + kAverages + static_cast<double>(steps) * kStepSize + static_cast<double>(runs) * kOfARun;
}

std::vector<std::byte> to_bytes(const StudyStatistics& statistics) {
  ByteWriter w;
  w.put(statistics.not_converged.empty() ? kFormat : kFormatNotConverged);
  w.put(statistics.runs);
  w.put(statistics.steps);
  put_averages(w, statistics.nees_of_runs);
  put_averages(w, statistics.vehicle_nees_of_runs);
  w.put(static_cast<std::uint64_t>(statistics.failures.size()));
  for (const RunFailure& f : statistics.failures) {
    w.put(f.run);
    w.put(f.step);
    w.put(f.outcome);
  }
  if (!statistics.not_converged.empty()) w.put(statistics.not_converged);
  return w.take();
}

StudyStatistics statistics_from_bytes(std::span<const std::byte> bytes) {
  ByteReader r(bytes, "a stored chunk");
  const auto format = r.get<std::uint32_t>();
  if (format < kFormatBefore || format > kFormatNotConverged) r.refuse("has another format");
  const bool before = format < kFormat;
  StudyStatistics s;
  r.get(s.runs);
  s.steps.resize(r.get_count(before ? kStepSizeBefore : kStepSize));
  for (StepStatistics& step : s.steps) get_step(r, before, step);
  get_averages(r, s.nees_of_runs);
  get_averages(r, s.vehicle_nees_of_runs);
  s.failures.resize(r.get_count(kFailureSize));
  for (RunFailure& f : s.failures) {
    r.get(f.run);
    r.get(f.step);
    r.get(f.outcome);
  }
  if (format == kFormatNotConverged || format == kFormatBeforeNotConverged) {
    s.not_converged.resize(r.get_count(kNotConvergedSize));
    for (RunNotConverged& run : s.not_converged) r.get(run);
  }
  r.require_end();
  return s;
}

}  // namespace credence::internal
