#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/record/run_layout.h"
#include "core/types.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// The posterior Cramér-Rao bound ([Tichavsky 1998]): what no filter's mean squared error is below.
///
///   J⁺ = D₂₂ − D₂₁ (J + D₁₁)⁻¹ D₁₂,   D₁₁ = E[Fᵀ Q⁻¹ F], D₁₂ = −E[Fᵀ Q⁻¹], D₂₂ = Q⁻¹ + E[Hᵀ R⁻¹ H],
///
/// with all Jacobians at the truth and the means over truths. With F̄ = E[F], P = J⁻¹ and C = E[(F − F̄)ᵀ Q⁻¹
/// (F − F̄)] it is P⁻ = F̄ (P⁻¹ + C)⁻¹ F̄ᵀ + Q, P⁺ = (P⁻⁻¹ + E[Hᵀ R⁻¹ H])⁻¹, which stands a singular Q and an
/// exact start where F is the same for all truths. Bias is not provided for, nor noise that is not white and
/// Gaussian.
///
/// Beside it, what a filter with its Jacobians at the truth claims: the mean over truths of (…)⁻¹, which is
/// not below the (mean)⁻¹ of the bound, and no bound of its own. They part where truths part: in SLAM a mean
/// of Jacobians over paths tells the turn of the world, which none of them tells alone.

namespace credence {

/// Both for one block of a layout.
struct BoundCurve {
  std::string block;
  /// Squared, summed over the states of the block, of a map for each landmark, at steps 1 … T; NaN until all
  /// of them are known along every truth, since errors are those of the states that a run knows.
  std::vector<double> bound, at_truth;

  double mean_bound() const;     ///< over the steps
  double mean_at_truth() const;  ///< over the steps
};

/// What the mean squared error of no filter is below, block by block, or why that is not known.
struct PosteriorBound {
  std::int64_t runs = 0;           ///< truths over which it is a mean
  std::vector<BoundCurve> blocks;  ///< of the layout, without poses, whose units differ, and single landmarks
  std::string reason;              ///< why there is none, else empty

  const BoundCurve* find(std::string_view block) const;  ///< null: there is none
  double mean_bound(std::string_view block) const;       ///< NaN: there is none
};

}  // namespace credence

namespace credence::internal {

/// Runs whose truths are looked at.
inline constexpr std::int64_t kBoundRuns = 64;

/// Why the scenario has no bound: what its noise is like, or a delay. Else empty.
std::string no_bound_reason(const Scenario& scenario);

/// The reason of a filter whose errors are stated in another chart.
inline constexpr const char* kBoundOfDifferences =
    "the bound is that of differences, in which this filter's errors are not";

/// The reason of measurements part of which is exact: R has no inverse, and what they tell no information
/// matrix.
inline constexpr const char* kBoundOfNoisyMeasurements = "the bound is that of measurements that have noise";

/// Gathers the curves of a layout.
class BoundRecorder {
 public:
  BoundRecorder(const RunLayout& layout, std::int64_t runs);

  /// The variances of all states of the layout at the next step, NaN of states of which nothing is known.
  void add(const VectorRef& bound, const VectorRef& at_truth);
  PosteriorBound take() { return std::move(result_); }

 private:
  struct Place {
    std::vector<Index> states;
    double shares;  ///< landmarks of a map
  };
  std::vector<Place> places_;
  PosteriorBound result_;
};

/// P ← (P⁻¹ + J)⁻¹ for psd P and J, which may be singular.
void learn(const Matrix& information, Matrix& P);

/// The recursion for a state of a few dimensions.
class PosteriorRecursion {
 public:
  /// What one truth is at one step: F and Q on the way there, Hᵀ R⁻¹ H of what is then measured.
  struct Truth {
    Matrix F, Q, information;
  };
  /// On what F depends: on the state, so that a filter cannot know it; or, all but, on inputs that a filter
  /// is given. Then the bound is that given the inputs, a mean over runs each with its own F and Q.
  enum class Motion { of_state, of_input };

  /// P0 of each truth.
  PosteriorRecursion(std::vector<Matrix> P0, Motion motion);

  /// The next step; false: Q is singular and F depends on the state, for which there is no such bound.
  bool step(const std::vector<Truth>& truths);

  const Matrix& bound(std::size_t truth) const { return bounds_[bounds_.size() > 1 ? truth : 0]; }
  const Matrix& at_truth(std::size_t truth) const { return at_truth_[truth]; }

 private:
  bool move_mean(const std::vector<Truth>& truths);

  std::vector<Matrix> bounds_, at_truth_;
};

}  // namespace credence::internal
