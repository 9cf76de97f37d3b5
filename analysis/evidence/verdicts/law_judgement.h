#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/evidence/sums/evidence.h"
#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/correlation/block_correlation.h"
#include "analysis/laws/correlation/error_modulation.h"
#include "analysis/laws/correlation/modulation.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student.h"
#include "analysis/laws/mean/zero_mean.h"
#include "analysis/laws/shape/covariance_shape.h"
#include "analysis/laws/shape/second_moments.h"

/// @file
/// What is known of the covariance beyond one factor and one law: every direction of it, whether it is
/// proved right within a margin, and whether errors that are not χ² are so because of P or of their law
/// (docs/statistics.md, "The covariance, and the law").

namespace credence::internal {

/// The shape of P: whether every direction of it is right.
struct ShapeJudgement {
  std::int64_t step = 0;   ///< that of the smallest p-value
  std::int64_t tests = 0;  ///< steps tested
  double p_value = kNaN;   ///< of the smallest, Bonferroni over the steps
  CovarianceShape shape{};
  /// At the last step tested: every direction of P is proved right within this; infinite if none is.
  double proved_within = kNaN;
  std::int64_t proved_at = 0;
  std::string_view reason = {};
};

/// E[e eᵀ] against P on average over the runs, whatever the law of e.
struct SecondMomentJudgement {
  std::string of;             ///< the block, "" for the state
  SecondMomentTest test;      ///< of one component: the same as the mean of NEES, and not made
  bool of_stretches = false;  ///< of few runs, whose stretches are its `runs`
  std::string worst;          ///< the direction of the smallest p-value in words
  std::string most_optimistic, most_pessimistic;  ///< those of the smallest of each side
};

/// What that is the test of.
SecondMoments moments_tested(const Evidence& evidence, const SecondMomentJudgement& judged);

/// Whether the errors have a mean, as they have with a bias of the sensor or of the model, which the
/// innovations of a filter that takes it into its state do not show.
struct ErrorMeanJudgement {
  ZeroMeanTest test;    ///< of e_i/√P_ii averaged over each run
  std::string largest;  ///< the state whose mean is the largest
};

/// Whether the covariance is right where the law of χ² is not.
struct GaussianityJudgement {
  double nees_tail_p_value = kNaN;  ///< of "tails no heavier than Gaussian" (tail_weight.h), of errors
  double nis_tail_p_value = kNaN;
  double far_nis_p_value = kNaN;  ///< of "no more NIS far out than a wrong scale makes", of all sensors
  double tail_p_value = kNaN;     ///< of all, Bonferroni
  /// Of "the second moments are right", by what needs no law: NEES and NIS on average, second moments and P
  /// by the σ that it claims, each component of the innovations and every two of them, of 20 runs and more
  /// also the blocks, and NEES and NIS at every step, of fewer NEES and NIS by place and over time;
  /// Bonferroni. NaN: of fewer runs, where their stretches tell no more than they do.
  double moments_p_value = kNaN;
  /// The larger of the standard errors of mean NEES and mean NIS over the runs, each over the mean.
  double relative_error = 0.0;

  /// The errors have heavy tails, clearly.
  bool heavy_tailed(double level) const {
    constexpr double kClearly = 0.2;
    return tail_p_value <= kClearly * level;
  }
  /// And nothing that needs no law speaks against P, and it would have: a mean that a run or two decide
  /// agrees with any P.
  bool right_but_heavy_tailed(double level) const {
    constexpr double kKnown = 0.25;
    return heavy_tailed(level) && moments_p_value > level && relative_error <= kKnown;
  }
};

/// Proved, and not only not refuted: mean NEES, mean NIS and the mean NEES of every block lie within the
/// margin of their expected values.
struct EquivalenceJudgement {
  double margin = 0.1;           ///< δ: between 1/(1 + δ) and 1 + δ
  double p_value = kNaN;         ///< the largest of all: small, and all of it is proved
  double proved_within = kNaN;   ///< the least δ that is proved of all of them; infinite if none is
  std::string_view reason = {};  ///< why nothing can be proved
};

/// A proper score, with its interval over the runs and what it would be if P were right.
struct ScoreJudgement {
  MeanInterval value;
  double expected = kNaN;
  std::string_view reason = {};
};

/// Two sensors.
struct SensorPairJudgement {
  std::string first, second;
  BlockCorrelationTest correlation;
};

/// All of it.
struct LawJudgement {
  ShapeJudgement shape;
  SecondMomentJudgement second_moments;
  ErrorMeanJudgement error_mean;
  GaussianityJudgement gaussianity;
  EquivalenceJudgement equivalence;
  ScoreJudgement log_score, energy_score;
  bool energy_of_position = false;
  std::vector<SensorPairJudgement> sensor_pairs;
};

/// The dof of NEES, where it is the same in all rows; else NaN.
double constant_dof(const StudyStatistics& statistics);

/// NIS / dof of this sensor at each step where there is one, its mean over the runs.
std::vector<double> normalised_nis(const SensorSums& sensor);

/// Whether the NIS of this sensor go up and down in time (modulation.h), if they are white, by the steps that
/// as many runs have as any. NaNs of 20 runs and more, whose steps tell it, and of more than one dimension.
Modulation nis_over_time(const SensorSums& sensor);

/// Whether errors go up and down in time over their σ (error_modulation.h): of the run that speaks most,
/// Bonferroni over the runs; `wave` in its rows.
struct NeesOverTime : Modulation {
  std::string of{};  ///< the block; "": the state

  /// What the word calls it.
  std::string part() const { return of.empty() ? "NEES" : of; }
};

/// Of the state, of at most RunSamples::kLargest, and of its blocks, or else of the block that leads alone:
/// of what all rows have, and can be tested. None of 20 runs and more.
std::vector<NeesOverTime> nees_over_time(const Evidence& evidence);

/// Of fewer than 20 runs.
struct FewRuns {
  double memory = kNaN;                 ///< memory_in_rows of the evidence
  StretchAverages state{};              ///< none where stretches are not independent
  std::vector<SkewedMoments> blocks{};  ///< the same, in the order of the evidence; empty where none has any
  double nees_over_time = kNaN;         ///< the smallest p-value of its parts, Bonferroni
  std::vector<double> nis_over_time{};  ///< of each sensor

  SkewedMoments block(std::size_t i) const { return i < blocks.size() ? blocks[i] : SkewedMoments{}; }
};

/// all_runs: the sums of the whole study, of which the evidence may be of the first runs. claimed_sigma: the
/// p-value of P by the σ that it claims; NaN: not tested. few: of fewer than 20 runs.
LawJudgement judge_law(const Evidence& evidence, const StudyStatistics& all_runs, double confidence,
                       double margin, double claimed_sigma = kNaN, const FewRuns& few = {});

}  // namespace credence::internal
