#pragma once

#include <vector>

#include "montecarlo/lanes/linear_kernel_plan.h"
#include "montecarlo/lanes/linear_kernel_units.h"

/// @file
/// A LinearErrorSystem in its units turned into the plain arrays that the kernels read. Internal.

namespace credence::internal {

/// Owns the arrays of a LinearPlan. The system has been checked.
class LinearPlanStorage {
 public:
  explicit LinearPlanStorage(const LinearSystemInUnits& in_units);
  LinearPlanStorage(const LinearPlanStorage&) = delete;
  LinearPlanStorage& operator=(const LinearPlanStorage&) = delete;

  const LinearPlan& plan() const { return plan_; }

  /// Turns the sums of one step over `runs` runs into moments in the original units.
  Moments nees_moments(std::size_t step, const double* sums, Index runs) const;
  Moments nis_moments(std::size_t step, const double* sums, Index runs) const;

 private:
  /// Rows with their zeros left out.
  struct Sparse {
    explicit Sparse(const Matrix& matrix);
    SparseRows rows() const { return {row_start.data(), column.data(), value.data()}; }

    std::vector<std::int32_t> row_start{0}, column;
    std::vector<double> value;
  };

  /// Where a dense matrix begins in ranges_ and values_; pointers are taken when nothing grows any more.
  struct Dense {
    std::int32_t rows, columns;
    std::size_t range, value;
  };
  Dense append(const Matrix& matrix);
  DenseRows rows_of(const Dense& dense) const;
  void append_small(const LinearErrorSystem& system);

  /// Those of one step of a period.
  struct Phase {
    Phase(const LinearErrorDynamics& dynamics, bool small);
    bool identity;
    Sparse F, noise_input, H, measurement_root;
    std::vector<double> dense_F{}, dense_H{}, noise_columns{};  ///< of a small system
  };

  std::vector<Phase> phases_;
  std::vector<LinearPlanPhase> plan_phases_;
  Sparse initial_root_;
  std::vector<std::int32_t> begin_, end_;
  std::vector<double> values_, nis_scale_, nees_scale_;
  std::vector<LinearPlanStep> steps_;
  std::vector<double> small_coefficients_, monobot_roots_;
  LinearPlan plan_;
};

}  // namespace credence::internal
