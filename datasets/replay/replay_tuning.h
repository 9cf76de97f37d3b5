#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "analysis/tuning/black_box_score.h"
#include "analysis/tuning/innovation_tests.h"
#include "analysis/tuning/tuning.h"
#include "datasets/replay/carpark.h"
#include "datasets/replay/mrclam.h"
#include "datasets/replay/replay_result.h"

/// @file
/// Which noise makes EKF-SLAM right on real data, and whether it does on data that it was not chosen by.

namespace credence::internal {

/// A log that can be replayed with other noise, the same observations being used whatever the noise.
struct ReplayedLog {
  std::string name;         ///< "carpark", "robot 1"
  ReplaySettings settings;  ///< the present ones, without a gate
  std::function<ReplayResult(const ReplaySettings&)> replay;
  Index left_out = 0;  ///< observations that the present gate rejects
};

/// The car park run. Throws std::invalid_argument for a gate, whose observations would depend on the noise,
/// and for association by compatibility.
ReplayedLog replayed_log(CarparkLog log, const ReplaySettings& settings);
/// A robot of MRCLAM. Observations that the present gate rejects are left out for good, and there is no gate
/// then. Throws std::invalid_argument for association by compatibility.
ReplayedLog replayed_log(MrclamLog log, const ReplaySettings& settings);

/// The log score of all logs together over some of the noise keys. Units are stretches of equally many
/// observations, at least kFewestUnits in all and as many of each log; an observation is a step.
class ReplayScore final : public BlackBoxScore {
 public:
  static constexpr Index kFewestUnits = 30;

  /// The logs must outlive it. Throws std::invalid_argument for no log, no observation, a key that is no
  /// standard deviation of noise or start, one that is 0, or one on which the logs differ.
  ReplayScore(const std::vector<ReplayedLog>& logs, std::vector<std::string> keys, int threads = 0,
              const std::atomic<bool>* stop = nullptr);

  Index units() const override { return stretches_ * std::ssize(logs_); }
  /// Of a log, with the noise at φ.
  ReplaySettings settings_at(std::size_t log, const Vector& phi) const;

 protected:
  UnitScores play(const std::vector<double>& factors) const override;

 private:
  ReplaySettings with(const ReplaySettings& settings, const std::vector<double>& factors) const;

  const std::vector<ReplayedLog>& logs_;
  std::vector<std::string> keys_;
  int threads_;
  const std::atomic<bool>* stop_;
  Index stretches_;
};

/// The four standard deviations of noise that a data set's filter has.
std::vector<std::string> replay_noise_keys(const ReplaySettings& settings);

/// A part of the data with the noise that the other parts ask for.
struct LeftOutPart {
  std::string name;            ///< "robot 1", "fifth 2"
  std::vector<double> values;  ///< of the keys that were found, in their order
  Index observations = 0;
  double nis_before = 0.0, nis_after = 0.0;      ///< mean of an observation, 2 expected
  double score_before = 0.0, score_after = 0.0;  ///< mean log score of an observation
  /// False: the search without it found nothing better than the noise of all data, which has seen it.
  bool tuned_apart = true;
};

/// Data sets, tuned.
struct ReplayTuning {
  std::string name;  ///< "carpark", "2 logs"
  Tuning tuning;
  bool parts_are_logs = false;        ///< else fifths of the one log
  Index left_out_by_gate = 0;         ///< observations
  std::vector<LeftOutPart> left_out;  ///< empty where nothing could be told
  InnovationTests before, after;      ///< of all parts left out
};

/// Tunes on all logs; then on all but each log (of a single one: all but each fifth) and judges the
/// innovations of that by the others' noise. Throws as ReplayScore and tune do, and Stopped.
ReplayTuning tune_replays(const std::vector<ReplayedLog>& logs, const ReplayScore& score, double confidence);

}  // namespace credence::internal
