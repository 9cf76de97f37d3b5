#include "reports/document/judgement_json.h"

#include <cmath>

#include "analysis/evidence/settling_power.h"

namespace credence::internal {
namespace {

void add_reason(Json& j, std::string_view reason) {
  if (!reason.empty()) j["reason"] = reason;
}

Json scale_json(const ScaleAdvice& scale) {
  Json j = {{"factor", json_number(scale.factor)},
            {"lower", json_number(scale.lower)},
            {"upper", json_number(scale.upper)}};
  add_reason(j, scale.reason);
  return j;
}

Json accuracy_json(const std::vector<BlockAccuracy>& accuracy) {
  Json rows = Json::array();
  for (const BlockAccuracy& row : accuracy) {
    const MeanInterval& squared = row.squared_error;
    const MeanInterval efficiency = row.efficiency();
    Json j = {{"of", row.of},
              {"unit", row.unit},
              {"rmse",
               {{"value", json_number(std::sqrt(squared.mean))},
                {"lower", json_number(std::sqrt(squared.lower))},
                {"upper", json_number(std::sqrt(squared.upper))}}},
              {"claimed", json_number(std::sqrt(row.claimed))}};
    if (!std::isnan(row.bound)) {
      j["at_truth"] = json_number(std::sqrt(row.at_truth));
      j["bound"] = json_number(std::sqrt(row.bound));
      j["efficiency"] = {{"value", json_number(efficiency.mean)},
                         {"lower", json_number(efficiency.lower)},
                         {"upper", json_number(efficiency.upper)}};
    }
    rows.push_back(std::move(j));
  }
  return rows;
}

Json rmse_json(const RmseInterval& rmse) {
  Json j = {{"value", rmse.count > 0 ? json_number(rmse.rmse) : Json(nullptr)},
            {"lower", json_number(rmse.lower)},
            {"upper", json_number(rmse.upper)}};
  add_reason(j, rmse.count > 0 ? rmse.reason : "not a part of this state");
  return j;
}

Json blocks_json(const Judgement& judgement) {
  Json blocks = Json::array();
  for (const BlockVerdict& block : judgement.blocks) {
    Json j = {{"name", block.name},
              {"mean", json_number(block.verdict.mean)},
              {"expected", json_number(block.verdict.expected)},
              {"p_value", json_number(block.verdict.p_value)},
              {"verdict", to_string(block.verdict.verdict)}};
    add_reason(j, block.verdict.reason);
    blocks.push_back(std::move(j));
  }
  return blocks;
}

Json coverage_json(const Judgement& judgement) {
  Json coverage = Json::array();
  for (std::size_t i = 0; i < judgement.coverage.size(); ++i) {
    const CoverageVerdict& c = judgement.coverage[i];
    coverage.push_back({{"k_sigma", CoverageSums::kSigmas[i]},
                        {"inside", c.pooled.inside},
                        {"total", c.pooled.total},
                        {"expected_share", json_number(c.expected)},
                        {"p_value", json_number(c.p_value)},
                        {"verdict", to_string(c.verdict)}});
  }
  return coverage;
}

/// A number, or null with what it lacks.
Json reasoned(Json j, std::string_view reason) {
  add_reason(j, reason);
  return j;
}

Json score_json(const ScoreJudgement& score) {
  return reasoned({{"mean", json_number(score.value.mean)},
                   {"lower", json_number(score.value.lower)},
                   {"upper", json_number(score.value.upper)},
                   {"expected", json_number(score.expected)}},
                  score.reason);
}

/// Every direction of P, whether it is proved right, and the law of the errors.
void add_law(const LawJudgement& law, Json& j) {
  const SecondMomentTest& second = law.second_moments.test;
  j["second_moments"] = reasoned({{"of", law.second_moments.of.empty() ? "state" : law.second_moments.of},
                                  {"optimistic_p_value", json_number(second.p_value.optimistic)},
                                  {"pessimistic_p_value", json_number(second.p_value.pessimistic)},
                                  {"worst_direction", law.second_moments.worst},
                                  {"worst_factor", json_number(second.worst.mean)},
                                  {"worst_lower", json_number(second.worst.lower)},
                                  {"worst_upper", json_number(second.worst.upper)},
                                  {"least_factor", json_number(second.least_factor)},
                                  {"largest_factor", json_number(second.largest_factor)}},
                                 second.reason);
  const ShapeJudgement& shape = law.shape;
  std::vector<double> factors(shape.shape.factors.begin(), shape.shape.factors.end());
  j["shape"] = reasoned({{"step", shape.step},
                         {"p_value", json_number(shape.p_value)},
                         {"factors", json_numbers(factors)},
                         {"proved_within", json_number(shape.proved_within)},
                         {"proved_at_step", shape.proved_at}},
                        shape.reason);
  const GaussianityJudgement& g = law.gaussianity;
  j["gaussianity"] = {{"nees_tail_p_value", json_number(g.nees_tail_p_value)},
                      {"nis_tail_p_value", json_number(g.nis_tail_p_value)},
                      {"far_nis_p_value", json_number(g.far_nis_p_value)},
                      {"moments_p_value", json_number(g.moments_p_value)}};
  j["equivalence"] = reasoned({{"margin", law.equivalence.margin},
                               {"p_value", json_number(law.equivalence.p_value)},
                               {"proved_within", json_number(law.equivalence.proved_within)}},
                              law.equivalence.reason);
  j["scores"] = {{"log", score_json(law.log_score)},
                 {"energy", score_json(law.energy_score)},
                 {"energy_of", law.energy_of_position ? "position" : "whitened state"}};
  Json pairs = Json::array();
  for (const SensorPairJudgement& pair : law.sensor_pairs) {
    pairs.push_back(reasoned({{"first", pair.first},
                              {"second", pair.second},
                              {"largest_correlation", json_number(pair.correlation.largest)},
                              {"p_value", json_number(pair.correlation.p_value)}},
                             pair.correlation.reason));
  }
  j["sensor_pairs"] = std::move(pairs);
}

Json lost_runs_json(const LostRuns& lost) {
  Json j = Json::array();
  for (const LostRun& run : lost.runs)
    j.push_back({{"run", run.run}, {"row", run.row}, {"factor", json_number(run.factor)}});
  return j;
}

Json settle_json(const SettlingRuns& settle) {
  Json j = {{"observed_factor", json_number(settle.observed_factor)},
            {"runs", settle.runs == 0 ? Json(nullptr) : Json(settle.runs)},
            {"detectable_below", json_number(settle.detectable.below)},
            {"detectable_above", json_number(settle.detectable.above)}};
  add_reason(j, settle.reason);
  return j;
}

}  // namespace

Json judgement_json(const Judgement& b) {
  Json j;
  j["runs"] = b.runs;
  Json tests = Json::array();
  for (const NamedTest& test : b.tests) {
    tests.push_back({{"name", test.name},
                     {"p_value", json_number(test.p_value)},
                     {"adjusted_p_value", json_number(test.adjusted)},
                     {"law", to_string(test.exactness)},
                     {"measured", test.says}});
  }
  j["tests"] = std::move(tests);
  j["blocks"] = blocks_json(b);
  j["responsible_block"] = b.responsible.index < 0
                               ? Json(nullptr)
                               : Json(b.blocks[static_cast<std::size_t>(b.responsible.index)].name);
  j["joint_only"] = b.responsible.joint_only;
  Json causes = Json::array();
  for (const CauseFound& cause : b.causes)
    causes.push_back({{"cause", to_string(cause.cause)}, {"why", cause.why}});
  j["causes"] = std::move(causes);
  j["lost_runs"] = lost_runs_json(b.lost);
  j["scale"] = {{"covariance", scale_json(b.scale_covariance)},
                {"innovation", scale_json(b.scale_innovation)},
                {"measurement_noise", scale_json(b.scale_measurement_noise)}};
  j["scale"]["covariance"]["leaves"] = left_by_scale(b.nees, b.blocks);
  j["settle"] = {
      {"power", kSettlingPower}, {"nees", settle_json(b.settle_nees)}, {"nis", settle_json(b.settle_nis)}};
  j["coverage"] = coverage_json(b);
  j["autocorrelation"] =
      b.sensors.empty() ? Json::array() : json_numbers(b.sensors.front().whiteness.autocorrelation);
  j["credibility"] = {{"noncredibility_db", json_number(b.credibility.noncredibility)},
                      {"floor_db", json_number(b.credibility.noncredibility_floor)},
                      {"inclination_db", json_number(b.credibility.inclination)}};
  add_reason(j["credibility"], b.credibility.reason);
  j["rmse"] = {{"position_m", rmse_json(b.position)},
               {"heading_rad", rmse_json(b.heading)},
               {"landmark_m", rmse_json(b.landmark)}};
  j["accuracy"] = accuracy_json(b.accuracy);
  add_law(b.law, j);
  j["effective_steps"] = json_number(b.effective_steps);
  j["null_reason"] =
      "null: not tested, the reason stands beside it or in `measured`; effective_steps: fewer than "
      "50 whole runs";
  return j;
}

}  // namespace credence::internal
