#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/stability/noise_condition.h"
#include "analysis/stability/ranks.h"
#include "analysis/stability/riccati.h"
#include "analysis/stability/trace_growth.h"
#include "core/inflation/inflation_rule.h"
#include "core/models/linear_model.h"

/// @file
/// Does a linear filter with inflated covariance stay stable? All instruments on one model, side by side
/// (theory, sections 3 and 5).

namespace credence {

/// The filter's own covariance recursion, with its ΔP_k as they vary, far beyond the steps of a study.
struct LongHorizon {
  TraceGrowth growth;               ///< of trace_prior, step by step
  std::vector<double> trace_prior;  ///< at steps 1, 2, …; after the inflation, before the update
  std::vector<double> trace;        ///< after the update
  bool converged = true;            ///< every exact minimal trace reached its tolerance
  std::string failure;              ///< what ended it before the horizon, and why; else empty
};

/// Everything that `credence stability` says of a linear scenario. Q_t = G Q Gᵀ + ΔP with ΔP held at its
/// value of the last step of the study.
struct StabilityAnalysis {
  Index state_dim = 0;
  Index steps = 0;  ///< the step at which K and ΔP are taken: that asked for, or the last that succeeds
  bool sequential = false;       ///< inflation within the update: ΔP before it is zero
  bool in_metres = true;         ///< all states are, so that a trace of P is in m²
  bool inflation_varies = true;  ///< ΔP_k depends on P: verdicts with constant Q_t are about its last value

  RankDecision controllability, observability, inflation, noise_total;
  std::vector<std::string> unobservable;  ///< names of the unobservable directions

  Matrix K;  ///< filter gain of step `steps`, n×m, NaN without one; the predictor's is F K
  Eigen::VectorXcd closed_loop_eigenvalues;  ///< of F − F K H with that K, by falling modulus
  double spectral_radius = 0.0;              ///< NaN when the eigenvalues did not converge

  RiccatiSolution riccati;        ///< the limit from P0 of the model with constant Q_t, and its gains
  RiccatiSolution riccati_other;  ///< the same from a larger P0
  double initial_covariance_effect = 0.0;  ///< ‖P − P_other‖ / ‖P‖ of the two limits; NaN without both
  bool depends_on_initial = false;         ///< the effect is above kInitialEffectTolerance

  bool predicted_bounded = false;                 ///< by the exact condition
  std::string prediction_reason;                  ///< in words
  std::optional<NoiseCondition> noise_condition;  ///< where F = I: the same proved, with bound or rate
  std::string growth_direction;                   ///< name of its direction; empty where there is none
  bool paper_condition_holds = false;             ///< eq. (22), rank ΔP <= rank O
  LongHorizon long_horizon;
};

/// Analyses the filter that `assumed` and `rule` define: ranks, eigenvalues and Riccati limit with the K and
/// ΔP of step `steps`, and the covariance recursion over `horizon` steps.
///
/// `states` names the states of a model that is no SLAM, whose units are not known; empty: they have the
/// names of its layout, and are metres. A filter that fails, as S is not positive definite or P leaves the
/// range of double, ends the recursion there; where that is before `steps`, K and ΔP are those of the last
/// step that succeeds (of none: K is NaN, ΔP zero). Throws std::invalid_argument for steps < 1,
/// horizon < max(4, steps), and a model that `require_valid` refuses. O(horizon · n³).
StabilityAnalysis analyse_stability(const LinearModel& assumed, const InflationRule& rule, Index steps,
                                    Index horizon, const std::vector<std::string>& states = {});

}  // namespace credence

namespace credence::internal {

/// Limits nearer than this are the same.
inline constexpr double kInitialEffectTolerance = 1e-6;

}  // namespace credence::internal
