#include "datasets/replay/replay_tuning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "analysis/tuning/maximise.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "datasets/replay/carpark_replay.h"
#include "datasets/replay/mrclam_replay.h"

namespace credence::internal {
namespace {

constexpr Index kFifths = 5;
// The path of an EKF on the car park jumps by as much as 8 of the score within 0.003 of φ.
constexpr double kReplayResolution = 0.1;
constexpr double kLeftOutReach = 10.0;  // of φ, from the noise of all data

void require_survey(const ReplaySettings& settings) {
  if (settings.filter.association == ReplayAssociation::survey) return;
  throw std::invalid_argument(
      "filter.association = compatibility: which landmark an observation is given would depend on the noise "
      "that is tuned; tune with filter.association = survey");
}

double number_of(const ReplaySettings& settings, const std::string& key) {
  const bool deviation =
      key.starts_with("noise.") || key == "initial.position_std" || key == "initial.heading_std_deg";
  std::vector<std::string> accepted;
  for (const ReplaySettingText& entry : replay_settings_text(settings)) {
    if (deviation && entry.key == key) return std::stod(entry.value);
    if (entry.key.starts_with("noise.")) accepted.push_back(entry.key);
  }
  throw std::invalid_argument(
      fmt::format("{} cannot be tuned here: accepted are {}, initial.position_std, initial.heading_std_deg",
                  key, fmt::join(accepted, ", ")));
}

std::vector<FilterFactor> factors_of(const std::vector<ReplayedLog>& logs,
                                     const std::vector<std::string>& keys) {
  if (logs.empty()) throw std::invalid_argument("there is no log to tune on");
  std::vector<FilterFactor> factors;
  for (const std::string& key : keys) {
    factors.push_back({key, number_of(logs.front().settings, key)});
    for (const ReplayedLog& log : logs) {
      if (number_of(log.settings, key) == factors.back().start) continue;
      throw std::invalid_argument(
          fmt::format("{} differs between {} and {}: set it to one value, from which to begin", key,
                      logs.front().name, log.name));
    }
  }
  return factors;
}

/// A score of some units only.
class SomeUnits final : public ScoreModel {
 public:
  SomeUnits(const ScoreModel& all, std::vector<Index> units) : all_(all), units_(std::move(units)) {}

  Index parameters() const override { return all_.parameters(); }
  std::vector<std::string> names() const override { return all_.names(); }
  std::vector<NoiseValue> values(const Vector& phi) const override { return all_.values(phi); }
  Index units() const override { return std::ssize(units_); }
  bool has_gradient() const override { return all_.has_gradient(); }
  Matrix expected_information(const Vector&) const override { return {}; }
  double resolution() const override { return all_.resolution(); }

  UnitScores scores(const Vector& phi, bool gradient) const override {
    UnitScores some = all_.scores(phi, gradient);
    const double share = static_cast<double>(units()) / static_cast<double>(some.value.size());
    some.value = Vector(some.value(units_));
    some.nis = Vector(some.nis(units_));
    some.lag_one = Vector(some.lag_one(units_));
    if (gradient) some.gradient = Matrix(some.gradient(Eigen::all, units_));
    some.steps *= share;  // equal but for one
    some.dof *= share;
    return some;
  }

 private:
  const ScoreModel& all_;
  std::vector<Index> units_;
};

/// Of equally long stretches of a log that which holds an observation; `number` is among those that corrected
/// the state.
Index stretch_of(Index number, const ReplayResult& result, Index stretches) {
  return number * stretches / result.updated;
}

/// Innovations of a part, with what they score.
struct PartInnovations {
  RecordedInnovations record;
  ScoreSum score;
};

/// Of part `index` of `parts`.
PartInnovations innovations_of(const ReplayResult& result, Index index, Index parts) {
  PartInnovations part;
  Index number = 0;
  for (const ReplayObservation& observation : result.records) {
    if (observation.outcome != ObservationOutcome::updated) continue;
    if (stretch_of(number++, result, parts) != index) continue;
    part.record.whitened.emplace_back(observation.whitened);
    part.record.nis.push_back(observation.whitened.squaredNorm());
    part.score.add_normalised(observation.whitened, observation.log_determinant());
  }
  return part;
}

/// Judges each part by the noise that the others ask for.
class LeaveOneOut {
 public:
  LeaveOneOut(const std::vector<ReplayedLog>& logs, const ReplayScore& score, ReplayTuning& all)
      : logs_(logs), score_(score), all_(all) {}

  void run() {
    const bool by_log = logs_.size() > 1;
    all_.parts_are_logs = by_log;
    const Index parts = by_log ? std::ssize(logs_) : kFifths;
    const Index units = score_.units() / parts;  // units of a log are next to each other
    std::vector<RecordedInnovations> before, after;
    ReplayResult present;
    for (Index i = 0; i < parts; ++i) {
      const Vector phi = tuned_without(i * units, (i + 1) * units);
      const Index index = by_log ? 0 : i, parts_of_log = by_log ? 1 : parts;
      const auto log = static_cast<std::size_t>(by_log ? i : 0);
      if (by_log || i == 0) present = logs_[log].replay(logs_[log].settings);
      const ReplayResult tuned = logs_[log].replay(score_.settings_at(log, phi));
      const PartInnovations then = innovations_of(present, index, parts_of_log),
                            now = innovations_of(tuned, index, parts_of_log);
      LeftOutPart& part = all_.left_out.emplace_back();
      part.name = by_log ? logs_[log].name : fmt::format("fifth {}", i + 1);
      part.observations = std::ssize(now.record.nis);
      part.nis_before = then.score.nis() / then.score.steps();
      part.nis_after = now.score.nis() / now.score.steps();
      part.score_before = then.score.value() / then.score.steps();
      part.score_after = now.score.value() / now.score.steps();
      part.tuned_apart = phi != all_.tuning.phi;
      const std::vector<NoiseValue> values = score_.values(phi);
      for (const Index free : all_.tuning.estimate.free) {
        part.values.push_back(values[static_cast<std::size_t>(free)].value);
      }
      before.push_back(then.record);
      after.push_back(now.record);
    }
    all_.before = test_recorded_innovations(before, all_.tuning.confidence);
    all_.after = test_recorded_innovations(after, all_.tuning.confidence);
  }

 private:
  /// φ by all units but [first, last).
  Vector tuned_without(Index first, Index last) const {
    const ScoreEstimate& e = all_.tuning.estimate;
    std::vector<Index> others;
    for (Index i = 0; i < score_.units(); ++i) {
      if (i < first || i >= last) others.push_back(i);
    }
    std::vector<bool> free(static_cast<std::size_t>(score_.parameters()), false);
    Vector scale = Vector::Ones(score_.parameters());
    for (std::size_t i = 0; i < e.free.size(); ++i) {
      const auto at = static_cast<Index>(i);
      free[static_cast<std::size_t>(e.free[i])] = true;
      scale[e.free[i]] = std::min(1.0, std::sqrt(e.covariance(at, at)));
    }
    const SearchBox box{all_.tuning.phi.array() - kLeftOutReach, all_.tuning.phi.array() + kLeftOutReach};
    return maximise(SomeUnits(score_, std::move(others)), all_.tuning.phi, box, free, scale).phi;
  }

  const std::vector<ReplayedLog>& logs_;
  const ReplayScore& score_;
  ReplayTuning& all_;
};

}  // namespace

ReplayedLog replayed_log(CarparkLog log, const ReplaySettings& settings) {
  require_survey(settings);
  if (settings.filter.gate > 0.0) {
    throw std::invalid_argument(fmt::format(
        "filter.gate = {}: which observations it lets through would depend on the noise that is tuned; "
        "tune with filter.gate = 0",
        settings.filter.gate));
  }
  auto scans = std::make_shared<const std::vector<ScanObservations>>(carpark_scans(log));
  return {"carpark", settings,
          [log = std::make_shared<const CarparkLog>(std::move(log)),
           scans = std::move(scans)](const ReplaySettings& s) { return replay_carpark(*log, *scans, s); }};
}

ReplayedLog replayed_log(MrclamLog log, const ReplaySettings& settings) {
  require_survey(settings);
  const ReplayResult present = replay_mrclam(log, settings);
  std::vector<MrclamMeasurement> kept;
  for (std::size_t i = 0; i < log.measurements.size(); ++i) {
    const auto observation = static_cast<Index>(i) - present.rows_before_start;
    const bool rejected =
        observation >= 0 &&
        present.records[static_cast<std::size_t>(observation)].outcome == ObservationOutcome::rejected;
    if (!rejected) kept.push_back(log.measurements[i]);
  }
  ReplayedLog replayed{.name = fmt::format("robot {}", log.robot),
                       .settings = settings,
                       .replay = {},
                       .left_out = std::ssize(log.measurements) - std::ssize(kept)};
  replayed.settings.filter.gate = 0.0;
  log.measurements = std::move(kept);
  replayed.replay = [log = std::make_shared<const MrclamLog>(std::move(log))](const ReplaySettings& s) {
    return replay_mrclam(*log, s);
  };
  return replayed;
}

ReplayScore::ReplayScore(const std::vector<ReplayedLog>& logs, std::vector<std::string> keys, int threads,
                         const std::atomic<bool>* stop)
    : BlackBoxScore(factors_of(logs, keys), kReplayResolution),
      logs_(logs),
      keys_(std::move(keys)),
      threads_(threads),
      stop_(stop),
      // Of one log a multiple of the parts that are left out in turn.
      stretches_(logs.size() == 1 ? kFewestUnits
                                  : std::max<Index>(kFifths, kFewestUnits / std::ssize(logs))) {}

ReplaySettings ReplayScore::with(const ReplaySettings& settings, const std::vector<double>& factors) const {
  ReplaySettings changed = settings;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    set_replay_setting(changed, keys_[i], fmt::format("{}", factors[i]));
  }
  return changed;
}

ReplaySettings ReplayScore::settings_at(std::size_t log, const Vector& phi) const {
  std::vector<double> factors;
  for (const NoiseValue& value : values(phi)) factors.push_back(value.value);
  return with(logs_.at(log).settings, factors);
}

UnitScores ReplayScore::play(const std::vector<double>& factors) const {
  std::vector<ScoreSum> units(static_cast<std::size_t>(this->units()));
  for_each_task(std::ssize(logs_), threads_, stop_, [&](std::int64_t i) {
    const auto log = static_cast<std::size_t>(i);
    const ReplayResult result = logs_[log].replay(with(logs_[log].settings, factors));
    Index number = 0;
    for (const ReplayObservation& observation : result.records) {
      if (observation.outcome != ObservationOutcome::updated) continue;
      const Index unit = i * stretches_ + stretch_of(number++, result, stretches_);
      units[static_cast<std::size_t>(unit)].add_normalised(observation.whitened,
                                                           observation.log_determinant());
    }
    // Of other observations than those of other noise there is no score.
    if (result.failed > 0) units[static_cast<std::size_t>(i * stretches_)].spoil();
    played_.add_part_of(std::ssize(logs_));
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  return unit_scores(units);
}

std::vector<std::string> replay_noise_keys(const ReplaySettings& settings) {
  std::vector<std::string> keys;
  for (const ReplaySettingText& entry : replay_settings_text(settings)) {
    if (entry.key.starts_with("noise.")) keys.push_back(entry.key);
  }
  return keys;
}

ReplayTuning tune_replays(const std::vector<ReplayedLog>& logs, const ReplayScore& score, double confidence) {
  ReplayTuning all{.name = logs.size() == 1 ? logs.front().name : fmt::format("{} logs", logs.size()),
                   .tuning = tune(score, Vector::Zero(score.parameters()), confidence),
                   .left_out = {},
                   .before = {},
                   .after = {}};
  for (const ReplayedLog& log : logs) all.left_out_by_gate += log.left_out;
  if (all.tuning.anything_known()) LeaveOneOut(logs, score, all).run();
  return all;
}

}  // namespace credence::internal
