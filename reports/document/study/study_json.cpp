#include "reports/document/study/study_json.h"

#include <cmath>

#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/study/judgement_json.h"

namespace credence::internal {
namespace {

Json exact_json(const StudyAnalysis& a) {
  std::vector<double> nees, nis;
  for (const ExactMoments& e : a.exact) {
    nees.push_back(e.nees);
    nis.push_back(e.nis);
  }
  return {{"nees", nees}, {"nis", nis}};
}

/// By step, as roots.
Json bound_json(const PosteriorBound& bound) {
  const auto roots = [](std::vector<double> squares) {
    for (double& value : squares) value = std::sqrt(value);
    return squares;
  };
  Json blocks = json_list(bound.blocks, [&](const BoundCurve& curve) -> Json {
    return {{"of", curve.block}, {"bound", roots(curve.bound)}, {"at_truth", roots(curve.at_truth)}};
  });
  return with_reason({{"runs", bound.runs}, {"blocks", std::move(blocks)}}, bound.reason);
}

Json stop_json(const StudyAnalysis& a) {
  const StopDecision& stop = *a.stop;
  return {{"reason", a.timed_out ? Json("max_seconds")
                     : stop.stop ? Json(stop.reason)
                                 : Json(nullptr)},
          {"verdict", to_string(stop.verdict)},
          {"p_value", stop.p_value},
          {"scale", {{"lower", stop.scale.lower}, {"upper", stop.scale.upper}}},
          {"mean_nees", json_interval(stop.mean_nees)}};
}

Json outcomes_json(const StudyAnalysis& a) {
  Json j = outcome_counts_json(a.statistics);
  j["failures"] = json_list(a.statistics.failures, [&](const RunFailure& f) {
    Json failure = {{"seed", a.scenario.study.seed}};
    failure.update(failure_json(f));
    return failure;
  });
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
  j["covariance"] = covariance_json(a.covariance);
  if (linear && misses) {
    j["gain"] = nullptr;
    j["gain_reason"] = "measurements are missed at random: every run has gains of its own";
  } else if (linear) {
    j["gain"] = json_matrix(a.gain);
  } else {
    j["rmse"] = errors_json(a.errors);
  }
  if (a.bound) j["bound"] = bound_json(*a.bound);
  if (a.judgement) j["battery"] = judgement_json(*a.judgement);
  j["outcomes"] = outcomes_json(a);
  j["null_reason"] = "null: no run contributes to this number";
  return j;
}

std::string studies_json(const std::vector<ReportedStudy>& reported) {
  if (reported.size() == 1) return text_of_json(study_json(reported.front().analysis));
  Json studies =
      json_list(reported, [](const ReportedStudy& each) -> Json { return study_json(each.analysis); });
  return text_of_json({{"schema", kSchema}, {"studies", std::move(studies)}});
}

}  // namespace credence::internal
