#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "analysis/tuning/black_box_score.h"
#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// The log score of the innovations of any experiment's filter, whose runs are played again with other
/// factors and the same noise. Every run is a unit; a run that fails leaves no score.
class FilterScore final : public BlackBoxScore {
 public:
  /// The experiment whose filter has these factors, in the order of `factors`. Called by one thread; its runs
  /// must meet the same noise whatever the factors.
  using Make = std::function<std::unique_ptr<Experiment>(const std::vector<double>& factors)>;

  /// Throws std::invalid_argument for no run, no factor, or one that is not positive.
  /// Once `stop` is set its scores throw Stopped (stop_point.h).
  FilterScore(std::vector<FilterFactor> factors, Make make, std::int64_t runs, int threads = 0,
              const std::atomic<bool>* stop = nullptr);

  Index units() const override { return runs_; }
  void forget_stop() { stop_ = nullptr; }

 protected:
  UnitScores play(const std::vector<double>& factors) const override;

 private:
  Make make_;
  Index runs_;
  int threads_;
  const std::atomic<bool>* stop_;
};

}  // namespace credence::internal
