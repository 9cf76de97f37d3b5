#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/evidence/sequential/sequential.h"
#include "analysis/studies/selftest_filter.h"

/// @file
/// The parts of the selftest that need more than one study of one filter: a study that is looked at while it
/// grows, a sweep of filters, and single long runs.

namespace credence::internal {

/// A study that grows by a chunk of kRuns runs and is looked at after each.
struct SequentialOutcome {
  Verdict verdict = Verdict::undecided;
  std::int64_t runs = 0;  ///< when it stopped
  MeanInterval mean_nees;
};
inline constexpr int kSequentialChunks = 20;

/// One outcome for each rule, all on the same runs: those of the blocks from index · kSequentialChunks on.
std::vector<SequentialOutcome> sequential_outcomes(const SyntheticFilter& filter,
                                                   std::span<const StopRule> rules, const NoiseSource& noise,
                                                   std::int64_t index);

/// Whether a fixed-sample NIS verdict at this confidence, taken after every chunk, ever rejects.
bool naive_looks_reject(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t index,
                        double confidence);

/// A sweep of twelve filters in the same noise, with the words of their studies adjusted as those of a sweep
/// are.
class SyntheticSweep {
 public:
  SyntheticSweep();

  /// For one level: whether any of twelve exact filters is discovered, and whether a discovery drawn at
  /// random among those of eight exact and four wrong filters is false; its mean is the false discovery rate.
  struct Discoveries {
    bool any_false = false, drawn_is_false = false;
  };
  std::vector<Discoveries> discoveries(const NoiseSource& noise, std::int64_t index,
                                       std::span<const double> levels) const;

  static constexpr int kExact = 8, kWrong = 4;

 private:
  std::vector<SyntheticFilter> exact_;  // kExact + kWrong
  std::vector<SyntheticFilter> wrong_;
};

/// p-values of test_single_run on kRuns runs of a squared autoregression (φ = 0.8, 2000 steps); NaN where it
/// is undecided.
std::array<double, SyntheticFilter::kRuns> single_run_p_values(const NoiseSource& noise, std::int64_t block);
/// Of error_modulation on that autoregression.
std::array<double, SyntheticFilter::kRuns> nees_over_time_p_values(const NoiseSource& noise,
                                                                   std::int64_t block);
/// Of modulation on squares of white noise.
std::array<double, SyntheticFilter::kRuns> nis_over_time_p_values(const NoiseSource& noise,
                                                                  std::int64_t block);

/// p-values that four logs have one time offset (InfluenceInterval::p_agreement), of scores that are as
/// autoregressions (φ = 0.8, 2000 rows), of kRuns / 4 studies.
std::array<double, SyntheticFilter::kRuns / 4> agreement_p_values(const NoiseSource& noise,
                                                                  std::int64_t block);

}  // namespace credence::internal
