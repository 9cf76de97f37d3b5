#include "reports/document/replay/replay_judgement.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/laws/chi_square/chi_square.h"
#include "datasets/logs/alignment.h"
#include "reports/render/number_text.h"

namespace credence::internal {
namespace {

RecordedInnovations innovations_of(const ReplayResult& result) {
  RecordedInnovations run;
  const bool gated = result.settings.filter.gate > 0.0;
  if (gated) run.gate = gate_threshold(result.settings.filter.gate);
  for (const ReplayObservation& observation : result.records) {
    if (observation.outcome != ObservationOutcome::updated) continue;
    run.whitened.emplace_back(observation.whitened);
    if (!gated) run.nis.push_back(observation.whitened.squaredNorm());
    if (gated && observation.first_of_batch) run.nis.push_back(observation.nis);
  }
  return run;
}

RecordedNees nees_of(const ReplayResult& result) {
  RecordedNees run;
  for (const ReplayReference& reference : result.references) {
    if (reference.singular) continue;
    run.time_s.push_back(reference.time_s);
    run.nees.push_back(reference.nees);
  }
  return run;
}

MapConsistency map_of(const ReplayResult& result) {
  std::vector<Point> truth, estimate;
  for (const ReplayLandmark& landmark : result.map) {
    if (landmark.landmark < 0) {
      MapConsistency unknown = judge_map(Vector(), Vector(), Vector(), Matrix());
      unknown.placed.reason = unknown.shape.reason = "the survey does not know every landmark of the map";
      return unknown;
    }
    truth.push_back(result.survey_m[static_cast<std::size_t>(landmark.landmark)]);
    estimate.push_back(landmark.position);
  }
  const Eigen::Isometry2d motion = align_rigidly(truth, estimate);
  const Index n = 2 * static_cast<Index>(truth.size());
  Vector placed(n), aligned(n), mapped(n);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Index row = 2 * static_cast<Index>(i);
    placed.segment<2>(row) = truth[i];
    aligned.segment<2>(row) = motion * truth[i];
    mapped.segment<2>(row) = estimate[i];
  }
  return judge_map(mapped, placed, aligned, result.map_covariance);
}

std::string about_reference(const ReplayResult& result, std::size_t runs) {
  const bool heading = !result.references.empty() && result.references.front().dof == 3;
  std::string truth = heading ? fmt::format(
                                    "Motion capture gives the whole pose; its own heading is known to {}° "
                                    "only, which is added to P.",
                                    number_text(result.settings.truth.heading_std_deg, 2))
                              : "GPS gives no heading: the NEES is that of the position, 2 dof, and nothing "
                                "is said of the heading or of the pose.";
  if (runs > 1) return truth;
  return truth +
         " One run is no sample of runs: its NEES is tested by bounds that hold for any correlation in time, "
         "and those can show that P is too small, hardly that it is too large.";
}

/// What the scale that suits the innovations would do to the map's shape; empty unless it contradicts it.
std::string contradiction(const ReplayJudgement& judgement, double confidence) {
  const NormalisedError& shape = judgement.maps.front().shape;
  const double scale = judgement.innovations.noise_scale.scale;
  if (!shape.ok || !(scale > 0.0)) return "";
  const double scaled = shape.value / scale;
  if (two_sided_p_value(scaled, static_cast<double>(shape.dof)) > 1.0 - confidence) return "";
  return fmt::format(
      "With all variances × {} the mean NIS would be the expected one, and the NEES of the map's shape {} "
      "with {} dof: no single scale suits both.",
      number_text(scale, 3), number_text(scaled, 4), shape.dof);
}

void add_limits(ReplayJudgement& judgement, std::span<const ReportedReplay> replays, double confidence) {
  const ReplayResult& first = replays.front().result;
  std::vector<std::string>& limits = judgement.limits;
  limits.push_back(about_reference(first, replays.size()));
  if (judgement.innovations.whiteness.reason.empty() && !judgement.innovations.whiteness.white)
    limits.push_back(
        fmt::format("The sum of the NIS and its law assume white innovations, which these are not (p {}{}); "
                    "the interval of the noise scale assumes nothing of the kind.",
                    judgement.innovations.whiteness.p_value < 1e-12 ? "" : "= ",
                    p_value_text(judgement.innovations.whiteness.p_value)));
  if (first.settings.filter.gate > 0.0)
    limits.push_back(
        fmt::format("Innovations had to pass a gate of {} %: NIS and its law are those of the first "
                    "observation of each time, cut at the gate.",
                    number_text(100.0 * first.settings.filter.gate, 4)));
  if (first.settings.filter.inflation != Inflation::none)
    limits.push_back("P is inflated to decorrelate it: pessimistic is what inflation is meant to be.");
  if (replays.size() == 1 && first.settings.filter.gate <= 0.0)
    if (const std::string words = contradiction(judgement, confidence); !words.empty())
      limits.push_back(words);
  limits.push_back(
      "The map as it lies carries the error of the start, which the innovations cannot see; its shape does "
      "not. The survey is taken as exact.");
  const bool any_ideal = std::any_of(replays.begin(), replays.end(), [](const auto& r) { return r.ideal; });
  if (any_ideal)
    limits.push_back(
        "Jacobians at the truth are no filter that could be built: they show what of the NEES comes from the "
        "EKF's linearisation at its own estimates, as long as these are near the truth.");
  limits.push_back(fmt::format(
      "All verdicts at {} % confidence; the four tests of the innovations are adjusted for being four.",
      number_text(100.0 * confidence, 3)));
}

}  // namespace

std::string replay_name(const ReplayResult& result) {
  return result.run.empty() ? result.dataset : result.dataset + ", " + result.run;
}

ReplayJudgement judge_replays(std::span<const ReportedReplay> replays, double confidence) {
  constexpr double kIntervalS = 1.0;
  std::vector<RecordedInnovations> innovations;
  std::vector<RecordedNees> nees;
  ReplayJudgement judgement;
  double dof = 2.0;
  for (const ReportedReplay& replay : replays) {
    innovations.push_back(innovations_of(replay.result));
    nees.push_back(nees_of(replay.result));
    judgement.maps.push_back(map_of(replay.result));
    dof = replay.result.vehicle_nees.expected > 0.0 ? replay.result.vehicle_nees.expected : dof;
  }
  judgement.innovations = test_recorded_innovations(innovations, confidence);
  judgement.nees = judge_recorded_nees(nees, dof, kIntervalS, confidence);
  add_limits(judgement, replays, confidence);
  return judgement;
}

}  // namespace credence::internal
