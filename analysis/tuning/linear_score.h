#pragma once

#include <atomic>
#include <utility>
#include <vector>

#include "analysis/tuning/innovation_sensitivities.h"
#include "analysis/tuning/noise_parameters.h"
#include "analysis/tuning/play_count.h"
#include "analysis/tuning/score_model.h"

namespace credence::internal {

/// One run as a linear filter meets it.
struct MeasuredRun {
  Vector start;  ///< x̂_0, n
  Matrix z;      ///< a column for each step, m×T
};

/// The log score of measured runs under a linear filter, with its exact gradient.
///
/// Each run is a unit, or, where there are fewer than kFewestUnits runs, so many stretches of each that there
/// are as many units: scores of different stretches are uncorrelated if the filter is right.
class LinearScore final : public ScoreModel {
 public:
  static constexpr Index kFewestUnits = 30;

  /// Throws std::invalid_argument for no run, runs of different length or of none, or z and x̂_0 of another
  /// dimension than the model's. Once `stop` is set its scores throw Stopped (stop_point.h).
  LinearScore(NoiseParameters parameters, std::vector<MeasuredRun> runs, int threads = 0,
              const std::atomic<bool>* stop = nullptr);

  Index parameters() const override { return parameters_.size(); }
  std::vector<std::string> names() const override { return parameters_.names(); }
  std::vector<NoiseValue> values(const Vector& phi) const override { return parameters_.values(phi); }
  Index units() const override { return std::ssize(runs_) * stretches_; }
  bool has_gradient() const override { return true; }
  UnitScores scores(const Vector& phi, bool gradient) const override;
  Matrix expected_information(const Vector& phi) const override;
  Vector scaled(const Vector& phi, const Vector& t) const override { return parameters_.scaled(phi, t); }
  Matrix scale_directions(const Vector& phi) const override { return parameters_.scale_directions(phi); }

  void forget_stop() { stop_ = nullptr; }
  void watch(PlayCount::Watch watch) { played_.watch(std::move(watch)); }

  const NoiseParameters& noise() const { return parameters_; }
  Index runs() const { return std::ssize(runs_); }
  Index steps() const { return runs_.front().z.cols(); }

 private:
  /// Of sixteen runs side by side, or as many as there are.
  void score_runs(const InnovationSensitivities& filter, Index first, UnitScores& scores) const;

  NoiseParameters parameters_;
  std::vector<MeasuredRun> runs_;
  int threads_;
  const std::atomic<bool>* stop_;
  Index stretches_;
  PlayCount played_;
};

}  // namespace credence::internal
