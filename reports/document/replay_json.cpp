#include "reports/document/replay_json.h"

#include "reports/document/verdict_json.h"
#include "reports/render/json_numbers.h"

namespace credence {
namespace {

bool has_pose_truth(const ReplayResult& r) { return !r.references.empty() && r.references.front().dof == 3; }

Json mean_json(const ReplayMean& mean) {
  return {{"mean", mean.count > 0 ? json_number(mean.mean()) : Json(nullptr)},
          {"expected", json_number(mean.expected)},
          {"count", mean.count}};
}

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(std::string(text)); }

Json counts_json(const ReplayResult& r) {
  return {{"observations", r.observations},
          {"scans_with_observations", r.scans_with_observations},
          {"associated", r.associated},
          {"updated", r.updated},
          {"initialised", r.initialised},
          {"rejected", r.rejected},
          {"unassociated", r.unassociated},
          {"failed", r.failed},
          {"ambiguous", r.ambiguous},
          {"mismatched", r.mismatched},
          {"not_converged", r.not_converged},
          {"times_without_truth", r.times_without_truth},
          {"unused_rows",
           {{"of_robots", r.rows_of_robots},
            {"of_unknown_barcodes", r.rows_of_unknown_barcodes},
            {"before_start", r.rows_before_start}}}};
}

void add_errors(Json& j, const ReplayResult& r) {
  const bool pose = has_pose_truth(r);
  j["nis"] = mean_json(r.nis);
  j[pose ? "pose_nees" : "gps_nees"] = mean_json(r.vehicle_nees);
  j["landmark_nees"] = mean_json(r.landmark_nees);
  j["vehicle_rmse"] = json_number(r.vehicle_rmse);
  if (pose) j["heading_rmse_deg"] = json_number(r.heading_rmse_deg);
  j["landmark_rms"] = json_number(r.landmark_rms);
  j["landmark_rms_aligned"] = json_number(r.landmark_rms_aligned);
}

Json run_json(const ReportedReplay& replay) {
  const ReplayResult& r = replay.result;
  Json j, settings;
  for (const ReplaySettingText& s : replay_settings_text(r.settings)) settings[s.key] = s.value;
  j["dataset"] = r.dataset;
  if (!r.run.empty()) j["run"] = r.run;
  j["settings"] = std::move(settings);
  j["duration_s"] = json_number(r.duration_s);
  j.update(counts_json(r));
  add_errors(j, r);
  j["covariance"] = {{"vehicle_max", json_number(r.covariance.vehicle_max)},
                     {"vehicle_final", json_number(r.covariance.vehicle_final)},
                     {"landmarks_max", json_number(r.covariance.landmarks_max)},
                     {"landmarks_final", json_number(r.covariance.landmarks_final)}};
  if (replay.ideal) {
    Json ideal;
    ideal["rejected"] = replay.ideal->rejected;
    add_errors(ideal, *replay.ideal);
    j["jacobians_at_truth"] = std::move(ideal);
  }
  return j;
}

Json innovations_json(const InnovationTests& t) {
  Json j;
  j["nis"] = verdict_json(t.nis);
  j["goodness_of_fit"] = {{"kolmogorov", json_number(t.fit.kolmogorov)},
                          {"kolmogorov_p_value", json_number(t.fit.kolmogorov_p_value)},
                          {"anderson", json_number(t.fit.anderson)},
                          {"anderson_p_value", json_number(t.fit.anderson_p_value)},
                          {"reason", text_or_null(t.fit.reason)}};
  j["whiteness"] = {{"autocorrelation", json_numbers(t.whiteness.autocorrelation)},
                    {"band", json_numbers(t.whiteness.band)},
                    {"p_value", json_number(t.whiteness.p_value)},
                    {"white", t.whiteness.white},
                    {"reason", text_or_null(t.whiteness.reason)}};
  j["mean"] = {{"value", json_numbers({t.mean.data(), t.mean.data() + t.mean.size()})},
               {"p_value", json_number(t.mean_p_value)},
               {"reason", text_or_null(t.mean_reason)}};
  j["noise_scale"] = {{"value", json_number(t.noise_scale.scale)},
                      {"lower", json_number(t.noise_scale.lower)},
                      {"upper", json_number(t.noise_scale.upper)},
                      {"stretches", t.noise_scale.stretches},
                      {"reason", text_or_null(t.noise_scale.reason)}};
  j["adjusted_p_value"] = json_numbers(t.adjusted_p_value);
  return j;
}

Json error_json(const NormalisedError& error, double p_value) {
  return {{"nees", error.ok ? json_number(error.value) : Json(nullptr)},
          {"dof", error.dof},
          {"p_value", json_number(p_value)},
          {"reason", text_or_null(error.reason)}};
}

Json judgement_json(const ReplayJudgement& judgement) {
  Json j, maps = Json::array();
  j["nees"] = verdict_json(judgement.nees.verdict);
  j["nees"]["run_means"] = json_numbers(judgement.nees.run_mean);
  j["innovations"] = innovations_json(judgement.innovations);
  for (const MapConsistency& map : judgement.maps)
    maps.push_back({{"placed", error_json(map.placed, map.placed_p_value)},
                    {"shape", error_json(map.shape, map.shape_p_value)}});
  j["maps"] = std::move(maps);
  j["limits"] = judgement.limits;
  return j;
}

}  // namespace

std::string replay_json(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  Json j;
  j["schema"] = kSchema;
  if (replays.size() == 1) {
    j.update(run_json(replays.front()));
  } else {
    j["dataset"] = replays.front().result.dataset;
    j["runs"] = Json::array();
    for (const ReportedReplay& replay : replays) j["runs"].push_back(run_json(replay));
  }
  j["judgement"] = judgement_json(judgement);
  j["null_reason"] = "null: no value contributes to this number, or the reason beside it";
  return j.dump(1);
}

}  // namespace credence
