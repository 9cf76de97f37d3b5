#include "reports/document/study/judgement_json.h"

#include <cmath>
#include <vector>

#include "core/nan.h"

namespace credence::internal {
namespace {

Json span_json(const ConsistencyVerdict& v, const StepSpan& span) {
  if (span.count == 0) return nullptr;
  Json j = {{"first", v.step_of(span.first)}, {"last", v.step_of(span.last)}, {"count", span.count}};
  if (v.times != nullptr) {
    j["first_time_s"] = v.times->at(v.step_of(span.first));
    j["last_time_s"] = v.times->at(v.step_of(span.last));
  }
  return j;
}

/// NaN throughout where nothing was counted.
MeanInterval known_interval(const MeanInterval& interval) {
  return interval.count > 0 ? interval : MeanInterval{.mean = kNaN, .lower = kNaN, .upper = kNaN};
}

/// The number, or null where it is of nothing.
template <class Number>
Json number_if(bool known, Number number) {
  return known ? Json(number) : Json(nullptr);
}

Json scale_json(const ScaleAdvice& scale) {
  return with_reason({{"factor", scale.factor}, {"lower", scale.lower}, {"upper", scale.upper}},
                     scale.reason);
}

Json accuracy_json(const std::vector<BlockAccuracy>& accuracy) {
  return json_list(accuracy, [](const BlockAccuracy& row) {
    const MeanInterval& squared = row.squared_error;
    Json j = {
        {"of", row.of},
        {"unit", row.unit},
        {"rmse", json_interval(std::sqrt(squared.mean), std::sqrt(squared.lower), std::sqrt(squared.upper))},
        {"claimed", std::sqrt(row.claimed)}};
    if (!std::isnan(row.bound)) {
      j["at_truth"] = std::sqrt(row.at_truth);
      j["bound"] = std::sqrt(row.bound);
      j["efficiency"] = json_interval(row.efficiency());
    }
    return j;
  });
}

Json rmse_json(const RmseInterval& rmse, std::int64_t runs) {
  const bool known = rmse.count > 0;
  return with_reason(json_interval(known ? rmse.rmse : kNaN, rmse.lower, rmse.upper),
                     known      ? rmse.reason
                     : runs > 0 ? "not a part of this state"
                                : "no run ended well");
}

Json blocks_json(const Judgement& judgement) {
  return json_list(judgement.blocks, [](const BlockVerdict& block) {
    const ConsistencyVerdict& v = block.verdict;
    return with_reason({{"name", block.name},
                        {"mean", v.mean},
                        {"expected", v.expected},
                        {"p_value", v.p_value},
                        {"verdict", to_string(v.verdict)}},
                       v.reason);
  });
}

Json coverage_json(const Judgement& judgement) {
  Json coverage = Json::array();
  for (std::size_t i = 0; i < judgement.coverage.size(); ++i) {
    const CoverageVerdict& c = judgement.coverage[i];
    const bool known = c.pooled.total > 0;
    coverage.push_back(with_reason({{"k_sigma", CoverageSums::kSigmas[i]},
                                    {"inside", c.pooled.inside},
                                    {"total", c.pooled.total},
                                    {"expected_share", number_if(known, c.expected)},
                                    {"p_value", number_if(known, c.p_value)},
                                    {"verdict", to_string(c.verdict)}},
                                   known ? "" : "no data"));
  }
  return coverage;
}

Json score_json(const ScoreJudgement& score) {
  const MeanInterval value = known_interval(score.value);
  return with_reason(
      {{"mean", value.mean}, {"lower", value.lower}, {"upper", value.upper}, {"expected", score.expected}},
      score.reason);
}

/// Every direction of P, whether it is proved right, and the law of the errors.
void add_law(const LawJudgement& law, Json& j) {
  const SecondMomentTest& second = law.second_moments.test;
  const MeanInterval worst = known_interval(second.worst);
  j["second_moments"] = with_reason({{"of", law.second_moments.of.empty() ? "state" : law.second_moments.of},
                                     {"optimistic_p_value", second.p_value.optimistic},
                                     {"pessimistic_p_value", second.p_value.pessimistic},
                                     {"worst_direction", law.second_moments.worst},
                                     {"worst_factor", worst.mean},
                                     {"worst_lower", worst.lower},
                                     {"worst_upper", worst.upper},
                                     {"least_factor", second.least_factor},
                                     {"largest_factor", second.largest_factor}},
                                    second.reason);
  const ShapeJudgement& shape = law.shape;
  j["shape"] = with_reason({{"step", number_if(shape.tests > 0, shape.step)},
                            {"p_value", shape.p_value},
                            {"factors", json_vector(shape.shape.factors)},
                            {"proved_within", shape.proved_within},
                            {"proved_at_step", number_if(shape.tests > 0, shape.proved_at)}},
                           shape.reason);
  const GaussianityJudgement& g = law.gaussianity;
  j["gaussianity"] = {{"nees_tail_p_value", g.nees_tail_p_value},
                      {"nis_tail_p_value", g.nis_tail_p_value},
                      {"far_nis_p_value", g.far_nis_p_value},
                      {"moments_p_value", g.moments_p_value}};
  j["equivalence"] = with_reason({{"margin", law.equivalence.margin},
                                  {"p_value", law.equivalence.p_value},
                                  {"proved_within", law.equivalence.proved_within}},
                                 law.equivalence.reason);
  j["scores"] = {{"log", score_json(law.log_score)},
                 {"energy", score_json(law.energy_score)},
                 {"energy_of", law.energy_of_position ? "position" : "whitened state"}};
  j["sensor_pairs"] = json_list(law.sensor_pairs, [](const SensorPairJudgement& pair) -> Json {
    return with_reason({{"first", pair.first},
                        {"second", pair.second},
                        {"largest_correlation", pair.correlation.largest},
                        {"p_value", pair.correlation.p_value}},
                       pair.correlation.reason);
  });
}

Json lost_runs_json(const LostRuns& lost) {
  return json_list(lost.runs, [](const LostRun& run) -> Json {
    return {{"run", run.run}, {"name", name_of(run)}, {"row", run.row}, {"factor", run.factor}};
  });
}

/// The factors that can be detected are above 0 where they are known.
Json settle_json(const SettlingRuns& settle, const ConsistencyVerdict& of) {
  const DetectableFactors& detectable = settle.detectable;
  return with_reason({{"observed_factor", number_if(of.count > 0, settle.observed_factor)},
                      {"runs", number_if(settle.runs > 0, settle.runs)},
                      {"detectable_below", number_if(detectable.below > 0.0, detectable.below)},
                      {"detectable_above", number_if(detectable.above > 0.0, detectable.above)}},
                     settle.reason);
}

}  // namespace

Json word_json(const Word& word) {
  Json joined = json_list(word.joined, [](const JoinedVerdict& part) -> Json {
    return {{"name", part.name}, {"verdict", to_string(part.verdict)}, {"adjusted_p_value", part.p_value}};
  });
  return {{"verdict", to_string(word.verdict)},
          {"p_value", word.p_value},
          {"says", word.says},
          {"joined", std::move(joined)}};
}

Json verdict_json(const ConsistencyVerdict& v) {
  std::vector<double> per_step, lower, upper, p_values;
  ChiSquareBounds last{kNaN, kNaN};
  for (const StepTest& step : v.steps) {
    per_step.push_back(step.mean);
    lower.push_back(step.lower);
    upper.push_back(step.upper);
    p_values.push_back(step.p_value);
    if (step.has_data()) last = {step.lower, step.upper};
  }
  Json j;
  j["mean"] = v.mean;
  j["expected"] = v.expected;
  j["verdict"] = to_string(v.verdict);
  if (!v.reason.empty()) j["reason"] = v.reason;
  j["p_value"] = v.p_value;
  j["confidence"] = v.confidence;
  j["optimistic_p_value"] = v.optimistic_p_value;
  j["pessimistic_p_value"] = v.pessimistic_p_value;
  j["decided_by"] = v.steps_tested == 0 ? Json(nullptr) : Json(v.decided_by_steps ? "step" : "mean");
  j["factor"] = with_reason(json_interval(v.factor), v.factor.reason);
  j["optimistic_steps"] = span_json(v, v.optimistic_steps);
  j["pessimistic_steps"] = span_json(v, v.pessimistic_steps);
  // Bounds of the mean at a single step; of the last one where the dof varies.
  j["bounds"] = {{"lower", last.lower}, {"upper", last.upper}};
  j["share_outside"] = v.share_outside;
  j["expected_share_outside"] = v.expected_share_outside;
  j["overall"] = {{"lower", v.bounds.lower},
                  {"upper", v.bounds.upper},
                  {"p_value", std::isnan(v.bounds_p_value) ? v.overall_p_value : v.bounds_p_value}};
  j["steps_p_value"] = v.steps_p_value;
  j["steps_rejected"] = v.steps_rejected;
  j["steps_without_data"] = v.steps_without_data;
  j["worst_step"] = v.worst_step < 0 ? Json(nullptr) : Json(v.step_of(v.worst_step + 1));
  j["dof"] = v.dof;
  j["values"] = v.count;
  j["tests"] = v.tests;
  j["method"] = v.method;
  j["per_step"] = per_step;
  j["per_step_bounds"] = {{"lower", lower}, {"upper", upper}};
  j["per_step_p_value"] = p_values;
  return j;
}

Json outcome_counts_json(const StudyStatistics& statistics) {
  Json j;
  for (const Outcome outcome : kOutcomes) j[std::string(to_string(outcome))] = statistics.count(outcome);
  return j;
}

Json not_converged_json(std::span<const RunNotConverged> runs) {
  return json_list(runs, [](const RunNotConverged& of) -> Json {
    return {{"run", of.run}, {"steps", of.steps}};
  });
}

Json failure_json(const RunFailure& failure) {
  return {{"run", failure.run}, {"step", failure.step}, {"outcome", to_string(failure.outcome)}};
}

Json covariance_json(const CovarianceCurves& curves) {
  return {{"trace_prior", curves.trace_prior}, {"trace", curves.trace},     {"vehicle", curves.vehicle},
          {"landmarks", curves.landmarks},     {"heading", curves.heading}, {"landmark", curves.landmark}};
}

Json errors_json(const ErrorCurves& curves) {
  return {{"position_m", curves.position_m},
          {"heading_rad", curves.heading_rad},
          {"landmark_m", curves.landmark_m}};
}

Json responsible_block_json(const Judgement& b) {
  if (b.responsible.index < 0) return nullptr;
  return b.blocks[static_cast<std::size_t>(b.responsible.index)].name;
}

Json judgement_json(const Judgement& b) {
  Json j;
  j["runs"] = b.runs;
  j["tests"] = json_list(b.tests, [](const NamedTest& test) -> Json {
    return {{"name", test.name},
            {"p_value", test.p_value},
            {"adjusted_p_value", test.adjusted},
            {"law", to_string(test.exactness)},
            {"measured", test.says}};
  });
  j["blocks"] = blocks_json(b);
  j["responsible_block"] = responsible_block_json(b);
  j["joint_only"] = b.responsible.joint_only;
  j["causes"] = json_list(b.causes, [](const CauseFound& cause) -> Json {
    return {{"cause", to_string(cause.cause)}, {"why", cause.why}};
  });
  j["lost_runs"] = lost_runs_json(b.lost);
  j["scale"] = {{"covariance", scale_json(b.scale_covariance)},
                {"innovation", scale_json(b.scale_innovation)},
                {"measurement_noise", scale_json(b.scale_measurement_noise)}};
  j["scale"]["covariance"]["leaves"] = left_by_scale(b.nees, b.blocks);
  j["settle"] = {{"power", kSettlingPower},
                 {"nees", settle_json(b.settle_nees, b.nees)},
                 {"nis", settle_json(b.settle_nis, b.nis)}};
  j["coverage"] = coverage_json(b);
  j["autocorrelation"] =
      b.sensors.empty() ? Json::array() : Json(b.sensors.front().whiteness.autocorrelation);
  const CredibilityIndex& index = b.credibility;
  const bool has_index = index.runs > 0;
  j["credibility"] = with_reason({{"noncredibility_db", number_if(has_index, index.noncredibility)},
                                  {"floor_db", number_if(has_index, index.noncredibility_floor)},
                                  {"inclination_db", number_if(has_index, index.inclination)}},
                                 index.reason);
  j["rmse"] = {{"position_m", rmse_json(b.position, b.runs)},
               {"heading_rad", rmse_json(b.heading, b.runs)},
               {"landmark_m", rmse_json(b.landmark, b.runs)}};
  j["accuracy"] = accuracy_json(b.accuracy);
  add_law(b.law, j);
  j["effective_steps"] = b.effective_steps;
  j["null_reason"] =
      "null: not tested, the reason stands beside it or in `measured`; effective_steps: fewer than "
      "50 whole runs";
  return j;
}

}  // namespace credence::internal
