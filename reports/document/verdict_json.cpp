#include "reports/document/verdict_json.h"

#include <cmath>

namespace credence::internal {
namespace {

Json span_json(const ConsistencyVerdict& v, const StepSpan& span) {
  if (span.count == 0) return nullptr;
  return {{"first", v.step_of(span.first)}, {"last", v.step_of(span.last)}, {"count", span.count}};
}

}  // namespace

Json word_json(const Word& word) {
  Json joined = Json::array();
  for (const JoinedVerdict& part : word.joined) {
    joined.push_back({{"name", part.name},
                      {"verdict", to_string(part.verdict)},
                      {"adjusted_p_value", json_number(part.p_value)}});
  }
  return {{"verdict", to_string(word.verdict)},
          {"p_value", json_number(word.p_value)},
          {"says", word.says},
          {"joined", std::move(joined)}};
}

Json verdict_json(const ConsistencyVerdict& v) {
  Json per_step = Json::array(), lower = Json::array(), upper = Json::array(), p_values = Json::array();
  ChiSquareBounds last{std::nan(""), std::nan("")};
  for (const StepTest& step : v.steps) {
    per_step.push_back(json_number(step.mean));
    lower.push_back(json_number(step.lower));
    upper.push_back(json_number(step.upper));
    p_values.push_back(json_number(step.p_value));
    if (step.count > 0 && step.total_dof > 0.0) last = {step.lower, step.upper};
  }
  Json j;
  j["mean"] = json_number(v.mean);
  j["expected"] = json_number(v.expected);
  j["verdict"] = to_string(v.verdict);
  if (!v.reason.empty()) j["reason"] = v.reason;
  j["p_value"] = json_number(v.p_value);
  j["confidence"] = v.confidence;
  j["optimistic_p_value"] = json_number(v.optimistic_p_value);
  j["pessimistic_p_value"] = json_number(v.pessimistic_p_value);
  j["decided_by"] = v.steps_tested == 0 ? Json(nullptr) : Json(v.decided_by_steps ? "step" : "mean");
  j["factor"] = {{"value", json_number(v.factor.mean)},
                 {"lower", json_number(v.factor.lower)},
                 {"upper", json_number(v.factor.upper)}};
  if (!v.factor.reason.empty()) j["factor"]["reason"] = v.factor.reason;
  j["optimistic_steps"] = span_json(v, v.optimistic_steps);
  j["pessimistic_steps"] = span_json(v, v.pessimistic_steps);
  // Bounds of the mean at a single step; of the last one where the dof varies.
  j["bounds"] = {{"lower", json_number(last.lower)}, {"upper", json_number(last.upper)}};
  j["share_outside"] = json_number(v.share_outside);
  j["expected_share_outside"] = json_number(v.expected_share_outside);
  j["overall"] = {{"lower", json_number(v.bounds.lower)},
                  {"upper", json_number(v.bounds.upper)},
                  {"p_value", json_number(v.overall_p_value)}};
  j["steps_p_value"] = json_number(v.steps_p_value);
  j["steps_rejected"] = v.steps_rejected;
  j["steps_without_data"] = v.steps_without_data;
  j["worst_step"] = v.worst_step < 0 ? Json(nullptr) : Json(v.step_of(v.worst_step + 1));
  j["dof"] = json_number(v.dof);
  j["values"] = v.count;
  j["tests"] = v.tests;
  j["method"] = v.method;
  j["per_step"] = std::move(per_step);
  j["per_step_bounds"] = {{"lower", std::move(lower)}, {"upper", std::move(upper)}};
  j["per_step_p_value"] = std::move(p_values);
  return j;
}

Json outcome_counts_json(const StudyStatistics& statistics) {
  Json j;
  for (const Outcome outcome : kOutcomes) j[std::string(to_string(outcome))] = statistics.count(outcome);
  return j;
}

Json not_converged_json(std::span<const RunNotConverged> runs) {
  Json list = Json::array();
  for (const RunNotConverged& of : runs) list.push_back({{"run", of.run}, {"steps", of.steps}});
  return list;
}

}  // namespace credence::internal
