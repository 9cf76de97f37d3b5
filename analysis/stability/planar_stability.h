#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/stability/boundedness.h"
#include "analysis/stability/trace_growth.h"
#include "core/nan.h"
#include "montecarlo/scenario/scenario.h"

/// @file
/// Does EKF-SLAM in the plane with inflated covariance stay stable? Ranks and growth along the nominal path,
/// with Jacobians at the truth and at the filter's own estimates (theory, section 5, planar table).

namespace credence::internal {

/// Where the Jacobians of F_k and H_k are taken.
enum class Linearisation {
  truth,     ///< along the nominal path, without any noise
  estimate,  ///< at the estimates of one noisy run, as an EKF does
};

/// "truth", "estimate".
std::string_view to_string(Linearisation at);

/// What is seen of the state over one loop of the path, the last.
struct PlanarRanks {
  ObservabilityAnalysis observability;    ///< of the stack of H_k Φ_k
  std::vector<std::string> unobservable;  ///< names of what it leaves open
};

/// One filter followed for many loops.
struct PlanarFollowed {
  Linearisation at = Linearisation::truth;
  InflationSolution solution = InflationSolution::pairwise;

  TraceGrowth growth;          ///< of `traces`; resolution kPlanarResolution
  std::vector<double> traces;  ///< mean of tr P over each loop, m² and rad²
  Index not_converged = 0;     ///< steps whose exact minimal trace had a duality gap above 1e-9
  double pose_nees = 0.0;      ///< pose NEES over its dof 3, mean of the last half; NaN at the truth
  Index failed_at = 0;         ///< the step at which the filter fails; 0: it does not

  Index inflation_rank = 0;  ///< of ΔP before the last update of the loop analysed
  /// Of the noise accumulated over that loop against the unobservable directions; none for a sequential
  /// rule, which inflates within the update.
  std::optional<ExactBoundedness> exact;
  double spectral_radius = 0.0;              ///< of the error's transition over that loop
  Eigen::VectorXcd closed_loop_eigenvalues;  ///< of the same, by falling modulus
  /// At the truth: last trace from a P0 of 100 times the variance, over this one; NaN where either fails.
  double initial_effect = kNaN;
};

/// Everything that `credence stability` says of a planar scenario.
struct PlanarStability {
  Index state_dim = 0;
  Index loops = 0;
  Index steps_per_loop = 0;
  Index process_rank = 0;  ///< of the process noise accumulated over one loop, without inflation
  PlanarRanks truth, estimate;
  std::vector<PlanarFollowed> followed;  ///< at the truth and the estimate, with every solution

  /// The one of a solution; throws std::invalid_argument for one that was not followed.
  const PlanarFollowed& own(InflationSolution solution, Linearisation at = Linearisation::truth) const;
};

/// Growth of less than this share of tr P over the last half of the loops is below what the tolerance of the
/// exact minimal trace lets one see.
inline constexpr double kPlanarResolution = 2e-3;

/// Which solutions of its inflation a filter is followed with.
enum class FollowedSolutions { all, own };

/// Follows the filter of `scenario` for `loops` >= 4 loops: with its inflation by every solution there is
/// (pairwise and exact; for the map sequential, batch and drop as well), or by its own alone, with Jacobians
/// at the truth and in a noisy run.
///
/// Throws std::invalid_argument for fewer loops, a world that is not planar, and a constant inflation.
/// O(loops · steps · n³).
PlanarStability analyse_planar_stability(const Scenario& scenario, Index loops,
                                         FollowedSolutions which = FollowedSolutions::all);

}  // namespace credence::internal
