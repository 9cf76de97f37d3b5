#include "reports/document/judgement_json.h"

#include "analysis/evidence/settling_power.h"

namespace credence {
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

Json rmse_json(const RmseInterval& rmse) {
  Json j = {{"value", rmse.count > 0 ? json_number(rmse.rmse) : Json(nullptr)},
            {"lower", json_number(rmse.lower)},
            {"upper", json_number(rmse.upper)}};
  add_reason(j, rmse.count > 0 ? rmse.reason : "not a part of this state");
  return j;
}

Json blocks_json(const Judgement& battery) {
  Json blocks = Json::array();
  for (const BlockVerdict& block : battery.blocks) {
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

Json coverage_json(const Judgement& battery) {
  Json coverage = Json::array();
  for (std::size_t i = 0; i < battery.coverage.size(); ++i) {
    const CoverageVerdict& c = battery.coverage[i];
    coverage.push_back({{"k_sigma", CoverageSums::kSigmas[i]},
                        {"inside", c.pooled.inside},
                        {"total", c.pooled.total},
                        {"expected_share", json_number(c.expected)},
                        {"p_value", json_number(c.p_value)},
                        {"verdict", to_string(c.verdict)}});
  }
  return coverage;
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
  j["scale"] = {{"covariance", scale_json(b.scale_covariance)},
                {"innovation", scale_json(b.scale_innovation)},
                {"measurement_noise", scale_json(b.scale_measurement_noise)}};
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
  j["effective_steps"] = json_number(b.effective_steps);
  j["null_reason"] =
      "null: not tested, the reason stands beside it or in `measured`; effective_steps: fewer than "
      "50 whole runs";
  return j;
}

}  // namespace credence
