#include "reports/document/study_json.h"

#include <cmath>

#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/judgement_json.h"
#include "reports/document/verdict_json.h"

namespace credence::internal {
namespace {

Json exact_json(const StudyAnalysis& a) {
  std::vector<double> nees, nis;
  for (const ExactMoments& e : a.exact) {
    nees.push_back(e.nees);
    nis.push_back(e.nis);
  }
  return {{"nees", json_numbers(nees)}, {"nis", json_numbers(nis)}};
}

/// By step, as roots.
Json bound_json(const PosteriorBound& bound) {
  const auto roots = [](std::vector<double> squares) {
    for (double& value : squares) value = std::sqrt(value);
    return json_numbers(squares);
  };
  Json blocks = Json::array();
  for (const BoundCurve& curve : bound.blocks) {
    blocks.push_back(
        {{"of", curve.block}, {"bound", roots(curve.bound)}, {"at_truth", roots(curve.at_truth)}});
  }
  Json j = {{"runs", bound.runs}, {"blocks", std::move(blocks)}};
  if (!bound.reason.empty()) j["reason"] = bound.reason;
  return j;
}

Json stop_json(const StudyAnalysis& a) {
  const StopDecision& stop = *a.stop;
  return {{"reason", a.timed_out ? Json("max_seconds")
                     : stop.stop ? Json(stop.reason)
                                 : Json(nullptr)},
          {"verdict", to_string(stop.verdict)},
          {"p_value", json_number(stop.p_value)},
          {"scale", {{"lower", json_number(stop.scale.lower)}, {"upper", json_number(stop.scale.upper)}}},
          {"mean_nees",
           {{"value", json_number(stop.mean_nees.mean)},
            {"lower", json_number(stop.mean_nees.lower)},
            {"upper", json_number(stop.mean_nees.upper)}}}};
}

Json outcomes_json(const StudyAnalysis& a) {
  Json j = outcome_counts_json(a.statistics);
  Json failures = Json::array();
  for (const RunFailure& f : a.statistics.failures) {
    failures.push_back({{"seed", a.scenario.study.seed},
                        {"run", f.run},
                        {"step", f.step},
                        {"outcome", to_string(f.outcome)}});
  }
  j["failures"] = std::move(failures);
  j["not_converged"] = not_converged_json(a.statistics.not_converged);
  return j;
}

}  // namespace

Json study_json(const StudyAnalysis& a) {
  Json j;
  j["schema"] = kSchema;
  j["scenario"] = Json::parse(scenario_to_json(a.scenario));
  j["configuration"] = configuration_id(a.scenario);
  j["seed"] = a.scenario.study.seed;
  j["runs"] = a.statistics.runs;
  j["steps"] = a.scenario.study.steps;
  j["state_dim"] = a.state_dim;
  j["complete"] = a.complete;
  j["verdict"] = to_string(overall_verdict(a));
  j["word"] = word_json(a.word);
  if (a.stop) j["stop"] = stop_json(a);
  j["nees"] = verdict_json(a.nees);
  j["nis"] = verdict_json(a.nis);
  if (a.vehicle_nees) j["vehicle_nees"] = verdict_json(*a.vehicle_nees);
  const bool linear = a.linear;
  const bool misses = a.scenario.noise.detection_probability < 1.0;
  if (linear) j["exact"] = exact_json(a);
  if (linear && a.exact.empty() && misses) {
    j["exact_reason"] = "a filter that is not optimal and misses measurements: no exact mean is known";
  }
  j["covariance"] = {{"trace_prior", json_numbers(a.covariance.trace_prior)},
                     {"trace", json_numbers(a.covariance.trace)},
                     {"vehicle", json_numbers(a.covariance.vehicle)},
                     {"landmarks", json_numbers(a.covariance.landmarks)}};
  if (linear && misses) {
    j["gain"] = nullptr;
    j["gain_reason"] = "measurements are missed at random: every run has gains of its own";
  } else if (linear) {
    j["gain"] = json_matrix(a.gain);
  } else {
    j["rmse"] = {{"position_m", json_numbers(a.errors.position_m)},
                 {"heading_rad", json_numbers(a.errors.heading_rad)},
                 {"landmark_m", json_numbers(a.errors.landmark_m)}};
  }
  if (a.bound) j["bound"] = bound_json(*a.bound);
  if (a.judgement) j["battery"] = judgement_json(*a.judgement);
  j["outcomes"] = outcomes_json(a);
  j["null_reason"] = "null: no run contributes to this number";
  return j;
}

std::string studies_json(const std::vector<ReportedStudy>& reported) {
  if (reported.size() == 1) return text_of_json(study_json(reported.front().analysis));
  Json studies = Json::array();
  for (const ReportedStudy& each : reported) studies.push_back(study_json(each.analysis));
  return text_of_json({{"schema", kSchema}, {"studies", std::move(studies)}});
}

}  // namespace credence::internal
