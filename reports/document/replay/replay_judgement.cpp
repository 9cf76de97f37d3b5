#include "reports/document/replay/replay_judgement.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
#include "core/number_text.h"
#include "datasets/logs/alignment.h"
#include "datasets/logs/judge_logs.h"
#include "datasets/replay/replay_log.h"

namespace credence::internal {
namespace {

constexpr double kReplayConfidence = 0.95;

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

/// The gate of all. Throws std::invalid_argument where they differ.
double common_gate(std::span<const ReportedReplay> replays) {
  const double gate = gate_of(replays.front().result);
  for (const ReportedReplay& replay : replays) {
    if (gate_of(replay.result) == gate) continue;
    throw std::invalid_argument(
        fmt::format("replays judged together must have one filter.gate, not {} and {}",
                    replays.front().result.settings.filter.gate, replay.result.settings.filter.gate));
  }
  return gate;
}

/// Keeps the NIS of every run that passes.
class NisSink final : public ForwardingSink {
 public:
  NisSink(LogSink& next, std::vector<double>& nis) : ForwardingSink(next), nis_(nis) {}

  void add(const Step& step) override {
    for (const Innovation& innovation : step.innovations) {
      if (innovation.nu.size() == 0) continue;
      nis_.push_back(normalised_error(innovation.nu, innovation.S).value);
    }
    ForwardingSink::add(step);
  }

 private:
  std::vector<double>& nis_;
};

std::string about_reference(const ReplayResult& result) {
  if (!has_true_heading(result))
    return "GPS gives no heading: the NEES is that of the position, 2 dof, and nothing is said of the "
           "heading or of the pose.";
  return fmt::format(
      "Motion capture gives the whole pose; its own heading is known to {}° only, which is added to P.",
      number_text(result.settings.truth.heading_std_deg, 2));
}

/// What the scale that suits the innovations would do to the map's shape; empty unless it contradicts it.
std::string contradiction(const NormalisedError& shape, double scale) {
  if (!shape.ok || !(scale > 0.0)) return "";
  const double scaled = shape.value / scale;
  if (two_sided_p_value(scaled, static_cast<double>(shape.dof)) > 1.0 - kReplayConfidence) return "";
  return fmt::format(
      "With all variances × {} the mean NIS would be the expected one, and the NEES of the map's shape {} "
      "with {} dof: no single scale suits both.",
      number_text(scale, 3), number_text(scaled, 4), shape.dof);
}

/// The mean NEES of the vehicle beside that with Jacobians at the truth.
struct LinearisationNees {
  double own = 0.0, ideal = 0.0, expected = 0.0;
  bool known = false;

  /// Of what is too much; 0 where nothing is.
  double share() const { return own > expected ? (own - ideal) / (own - expected) : 0.0; }
  bool is_most() const { return known && share() >= 0.5; }
};

/// Not known where no run has its Jacobians at the truth.
LinearisationNees linearisation_of(std::span<const ReportedReplay> replays) {
  LinearisationNees nees;
  std::int64_t count = 0;
  for (const ReportedReplay& replay : replays) {
    if (!replay.ideal) continue;
    nees.own += replay.result.vehicle_nees.sum;
    nees.ideal += replay.ideal->vehicle_nees.sum;
    count += replay.result.vehicle_nees.count;
  }
  if (count == 0) return nees;
  nees.own /= static_cast<double>(count);
  nees.ideal /= static_cast<double>(count);
  nees.expected = replays.front().result.vehicle_nees.expected;
  nees.known = true;
  return nees;
}

/// How much of the NEES is that of the linearisation; empty where that is not known.
std::string about_linearisation(const LinearisationNees& nees) {
  if (!nees.known) return {};
  std::string words = fmt::format(
      "With Jacobians at the truth the mean NEES of the vehicle is {} instead of {}, where {} is expected",
      number_text(nees.ideal, 4), number_text(nees.own, 4), number_text(nees.expected, 4));
  if (nees.own > nees.expected) {
    words += fmt::format(": the EKF's linearisation at its own estimates is {} of what is too much",
                         nees.is_most()        ? "most"
                         : nees.share() >= 0.1 ? "a part"
                                               : "no part");
  }
  return words + ". No such filter could be built; it tells this as long as estimates are near the truth.";
}

/// What Jacobians at the truth tell comes before what is read from innovations, which does not show it.
void name_linearisation(const LinearisationNees& nees, Judgement& j) {
  if (!nees.is_most() || !is_unsafe(j.word.verdict) || !is_unsafe(j.nees.verdict)) return;
  std::erase_if(j.causes, [](const CauseFound& found) { return found.cause == Cause::linearisation; });
  const CauseFound linearisation = {
      Cause::linearisation,
      fmt::format(
          "with Jacobians at the truth mean NEES of the vehicle is {} instead of {}, where {} is "
          "expected; a filter that linearises otherwise may mend it (--set filter.estimator=invariant), "
          "and no noise does",
          number_text(nees.ideal, 4), number_text(nees.own, 4), number_text(nees.expected, 4))};
  j.causes.insert(j.causes.begin(), linearisation);
}

/// What is not judged, and what the tests assume.
std::vector<std::string> limits_of(const ReplayJudgement& judgement, std::span<const ReportedReplay> replays,
                                   const LinearisationNees& linearisation) {
  const ReplayResult& first = replays.front().result;
  const double gate = first.settings.filter.gate;
  std::vector<std::string> limits{about_reference(first)};
  for (const SensorJudgement& sensor : judgement.logs.analysis.judgement.sensors) {
    if (sensor.whiteness.white || !sensor.whiteness.reason.empty()) continue;
    limits.emplace_back(
        "The verdict on NIS and its law assume white innovations, which these are not; the interval of the "
        "factor on S assumes nothing of the kind.");
  }
  if (gate > 0.0)
    limits.push_back(
        fmt::format("Innovations had to pass a gate of {} %: NIS and its law are those of the first "
                    "observation of each time, cut at the gate.",
                    number_text(100.0 * gate, 4)));
  if (first.settings.filter.inflation != Inflation::none)
    limits.emplace_back("P is inflated to decorrelate it: pessimistic is what inflation is meant to be.");
  if (replays.size() == 1 && gate <= 0.0) {
    std::string words = contradiction(judgement.maps.front().shape, judgement.noise_scale.scale);
    if (!words.empty()) limits.push_back(std::move(words));
  }
  limits.emplace_back(
      "The map as it lies carries the error of the start, which the innovations cannot see; its shape does "
      "not. The survey is taken as exact.");
  if (std::string words = about_linearisation(linearisation); !words.empty())
    limits.push_back(std::move(words));
  return limits;
}

}  // namespace

std::string replay_name(const ReplayResult& result) {
  return result.run.empty() ? result.dataset : result.dataset + ", " + result.run;
}

ReplayJudgement judge_replays(std::span<const ReportedReplay> replays) {
  const double gate = common_gate(replays);
  ReplayJudgement judgement;
  std::vector<std::filesystem::path> names;
  for (const ReportedReplay& replay : replays) {
    names.emplace_back(replay_name(replay.result));
    judgement.maps.push_back(map_of(replay.result));
  }
  std::vector<std::vector<double>> nis;
  // One thread reads them in their order.
  const auto read = [&](const std::filesystem::path& /*name*/, LogSink& sink) {
    const ReplayResult& replay = replays[nis.size()].result;
    NisSink keeping(sink, nis.emplace_back());
    read_replay(replay, keeping);
  };
  LogJudgeResult read_logs = judge_logs(names, read, {.threads = 1});
  judgement.noise_scale = noise_scale(nis, 2.0, gate, kReplayConfidence);
  const NoiseScale& noise = judgement.noise_scale;
  CheckedLogs& logs = judgement.logs;
  logs.name = fmt::format("EKF-SLAM on {}",
                          replays.size() == 1 ? names.front().string() : replays.front().result.dataset);
  logs.format = "replayed observations, and the filter beside its reference";
  judge_collected(
      std::move(read_logs.evidence), std::move(read_logs.calibration),
      {.confidence = kReplayConfidence,
       .gate = gate,
       .scale_innovation =
           noise.reason.empty()
               ? ScaleAdvice{.factor = noise.scale, .lower = noise.lower, .upper = noise.upper}
               : no_scale(noise.reason),
       .times =
           read_logs.times.known() ? std::make_shared<const StepTimes>(std::move(read_logs.times)) : nullptr,
       .run_names = std::move(read_logs.run_names)},
      {}, logs);
  const LinearisationNees linearisation = linearisation_of(replays);
  logs.remarks = limits_of(judgement, replays, linearisation);
  if (linearisation.is_most()) logs.explained = Verdict::optimistic;
  name_linearisation(linearisation, logs.analysis.judgement);
  return judgement;
}

}  // namespace credence::internal
