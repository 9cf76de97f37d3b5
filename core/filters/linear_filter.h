#pragma once

#include <span>
#include <vector>

#include "core/filters/sequential_update.h"
#include "core/inflation/inflation_along_run.h"
#include "core/inflation/inflation_rule.h"
#include "core/models/linear_model.h"

namespace credence::internal {

/// One step of a linear filter's covariance: predict, inflate, update (the order of theory, section 6).
struct LinearFilterStep {
  Matrix P_prior;         ///< P_{k|k−1} after the inflation, n×n
  Matrix S;               ///< H P_prior Hᵀ + R, m×m
  Matrix K;               ///< filter gain P_prior Hᵀ S⁻¹ (not the predictor gain F K), n×m
  Matrix P;               ///< P_{k|k}, Joseph form, n×n
  Matrix inflation;       ///< ΔP of this step before the update, n×n; zero for a sequential rule
  bool converged = true;  ///< the exact minimal trace was reached to its tolerance
  bool ok = true;         ///< false: S was not positive definite or P not finite; K and P are not to be used
};

/// What a linear filter believes, step by step (paper eqs (3)-(10)), where it does not have every
/// measurement at every step.
class LinearFilter {
 public:
  /// `assumed` is the model with the noise that the filter assumes. A sequential rule needs a diagonal R,
  /// else std::invalid_argument.
  LinearFilter(LinearModel assumed, InflationRule rule);
  /// Of a periodic model: those of its steps 1 … p.
  LinearFilter(std::vector<LinearModel> period, InflationRule rule);

  /// Back to P0, or to another P of a state and time.
  void reset();
  void reset(Matrix P);

  /// One step; good until the next call. After a step that is not ok the filter must be reset.
  const LinearFilterStep& step();
  /// The same with the measurements `rows` (row numbers of H, ascending) alone; K has a column and S a row
  /// for each of them.
  const LinearFilterStep& step(std::span<const Index> rows);

  /// What `step` returned last; before the first one only P is good, which is P0.
  const LinearFilterStep& last() const { return step_; }

 private:
  std::vector<LinearModel> period_;
  LinearModel seen_;
  InflationRule rule_;
  std::vector<Matrix> GQG_;
  Index steps_ = 0;  ///< since the last reset
  InflationAlongRun inflation_;
  SequentialWorkspace workspace_;
  LinearFilterStep step_;
};

/// What a linear filter believes at steps 1 … `steps`: its covariances and gains depend on no data, so they
/// are computed once for all runs (paper eqs (3)-(10)).
///
/// `assumed` is the model with the noise that the filter assumes. After a step that is not ok no further step
/// is computed: the result is then shorter than `steps`. A sequential rule needs a diagonal R, else
/// std::invalid_argument.
std::vector<LinearFilterStep> linear_filter_steps(const LinearModel& assumed, const InflationRule& rule,
                                                  Index steps);

/// The same for a periodic model, of whose steps 1 … p `period` has the models; P0 is that of the first.
std::vector<LinearFilterStep> linear_filter_steps(std::span<const LinearModel> period,
                                                  const InflationRule& rule, Index steps);

}  // namespace credence::internal
