#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/tuning/score_model.h"
#include "montecarlo/engine/experiment.h"

namespace credence {

/// A factor on something of a filter that is known by its name alone.
struct FilterFactor {
  std::string name;
  double start = 1.0;  ///< > 0, the present value; φ = 0 is this
};

/// The log score of any filter's innovations, the filter being a black box: its runs are played again with
/// other factors and the same noise, so that the score is as smooth as the filter is. The gradient is one of
/// central differences. Every run is a unit; a run that fails leaves no score.
class FilterScore final : public ScoreModel {
 public:
  /// The experiment whose filter has these factors, in the order of `factors`. Called by one thread; its runs
  /// must meet the same noise whatever the factors.
  using Make = std::function<std::unique_ptr<Experiment>(const std::vector<double>& values)>;

  /// Throws std::invalid_argument for no run, no factor, or one that is not positive.
  /// Once `stop` is set its scores throw Stopped (stop_point.h).
  FilterScore(std::vector<FilterFactor> factors, Make make, std::int64_t runs, int threads = 0,
              const std::atomic<bool>* stop = nullptr);

  Index parameters() const override { return std::ssize(factors_); }
  std::vector<std::string> names() const override;
  std::vector<NoiseValue> values(const Vector& phi) const override;
  Index units() const override { return runs_; }
  bool has_gradient() const override { return false; }
  UnitScores scores(const Vector& phi, bool gradient) const override;
  /// Estimated: the covariance of the unit scores, which is the information where the filter is right. Empty
  /// of too few runs.
  Matrix expected_information(const Vector& phi) const override;

 private:
  UnitScores play(const Vector& phi) const;

  std::vector<FilterFactor> factors_;
  Make make_;
  Index runs_;
  int threads_;
  const std::atomic<bool>* stop_;
};

}  // namespace credence
