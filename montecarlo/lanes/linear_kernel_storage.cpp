#include "montecarlo/lanes/linear_kernel_storage.h"

#include <algorithm>

namespace credence::internal {
namespace {

/// True if the last entry of a lower triangle is one.
bool ends_in_one(const Matrix& matrix) {
  return matrix.isLowerTriangular(0.0) && matrix(matrix.rows() - 1, matrix.cols() - 1) == 1.0;
}

/// True for the systems whose state stays in registers.
bool is_small(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows();
  if (n < 1 || m < 1 || n > kMostSmallStates || m > kMostSmallMeasurements) return false;
  return std::all_of(system.steps.begin(), system.steps.end(), [&](const LinearErrorSystem::Step& step) {
    return step.innovation_whitening.rows() == m && step.error_whitening.rows() == n &&
           ends_in_one(step.innovation_whitening) && ends_in_one(step.error_whitening);
  });
}

/// True for the monobots among them that have a kernel of their own: F = I, unit noise on the vehicle alone,
/// anchors first.
bool is_small_monobot(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows(), anchors = m - (n - 1);
  if (system.period() > 1 || (n != 2 && n != 3) || anchors < 0 || anchors > 1 || !system.F.isIdentity(0.0))
    return false;
  if (system.noise_input.cols() != 1 || system.noise_input(0, 0) != 1.0 ||
      !(system.noise_input.bottomRows(n - 1).array() == 0.0).all())
    return false;
  Matrix H = Matrix::Zero(m, n);
  H.col(0).setConstant(-1.0);
  H.bottomRightCorner(n - 1, n - 1).setIdentity();
  return H == system.H && system.measurement_root.isDiagonal(0.0);
}

void append_rows(const Matrix& matrix, bool lower, std::vector<double>& out) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < (lower ? row + 1 : matrix.cols()); ++column)
      out.push_back(matrix(row, column));
  }
}

double sum_of(const double* s) { return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7])); }

/// Moments of scale x from the sums of x − dof/scale and of its square.
Moments moments_of(const double* sums, std::int32_t dof, double scale, Index runs) {
  const double first = sum_of(sums), second = sum_of(sums + kAccumulators);
  const double shift = first / static_cast<double>(runs);
  // rounding may leave less than nothing of a sum of squares; a NaN stays one
  const double m2 = second - first * shift;
  return {.count = runs, .mean = dof + scale * shift, .m2 = m2 < 0.0 ? 0.0 : scale * scale * m2};
}

}  // namespace

LinearPlanStorage::Sparse::Sparse(const Matrix& matrix) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index j = 0; j < matrix.cols(); ++j) {
      if (matrix(row, j) == 0.0) continue;
      column.push_back(static_cast<std::int32_t>(j));
      value.push_back(matrix(row, j));
    }
    row_start.push_back(static_cast<std::int32_t>(value.size()));
  }
}

LinearPlanStorage::Phase::Phase(const LinearErrorDynamics& dynamics, bool small)
    : identity(dynamics.F.isIdentity(0.0)),
      F(dynamics.F),
      noise_input(dynamics.noise_input),
      H(dynamics.H),
      measurement_root(dynamics.measurement_root) {
  if (!small) return;
  append_rows(dynamics.F, false, dense_F);
  append_rows(dynamics.H, false, dense_H);
  append_rows(dynamics.measurement_root.transpose(), false, dense_H);
  append_rows(dynamics.noise_input.transpose(), false, noise_columns);
}

LinearPlanStorage::Dense LinearPlanStorage::append(const Matrix& matrix) {
  const Dense dense{static_cast<std::int32_t>(matrix.rows()), static_cast<std::int32_t>(matrix.cols()),
                    begin_.size(), values_.size()};
  for (Index row = 0; row < matrix.rows(); ++row) {
    Index begin = 0, end = matrix.cols();
    while (begin < end && matrix(row, begin) == 0.0) ++begin;
    while (end > begin && matrix(row, end - 1) == 0.0) --end;
    begin_.push_back(static_cast<std::int32_t>(begin));
    end_.push_back(static_cast<std::int32_t>(end));
  }
  append_rows(matrix, false, values_);
  return dense;
}

DenseRows LinearPlanStorage::rows_of(const Dense& dense) const {
  return {dense.rows, dense.columns, begin_.data() + dense.range, end_.data() + dense.range,
          values_.data() + dense.value};
}

void LinearPlanStorage::append_small(const LinearErrorSystem& system) {
  for (const LinearErrorSystem::Step& step : system.steps) {
    append_rows(step.K, false, small_coefficients_);
    append_rows(step.innovation_whitening, true, small_coefficients_);
    append_rows(step.error_whitening, true, small_coefficients_);
  }
  if (!is_small_monobot(system)) return;
  for (Index i = 0; i < system.H.rows(); ++i) monobot_roots_.push_back(system.measurement_root(i, i));
}

LinearPlanStorage::LinearPlanStorage(const LinearSystemInUnits& in_units)
    : initial_root_(in_units.system.initial_root),
      nis_scale_(in_units.nis_scale),
      nees_scale_(in_units.nees_scale) {
  const LinearErrorSystem& system = in_units.system;
  std::vector<Dense> matrices;
  for (const LinearErrorSystem::Step& step : system.steps) {
    for (const Matrix* matrix : {&step.K, &step.innovation_whitening, &step.error_whitening}) {
      matrices.push_back(append(*matrix));
    }
  }
  for (std::size_t k = 0; k < system.steps.size(); ++k) {
    const Dense *gain = &matrices[3 * k], *innovation = gain + 1, *error = gain + 2;
    steps_.push_back({.gain = rows_of(*gain),
                      .innovation_whitening = rows_of(*innovation),
                      .error_whitening = rows_of(*error),
                      .nis_centre = innovation->rows / nis_scale_[k],
                      .nees_centre = error->rows / nees_scale_[k],
                      .nees_scale = nees_scale_[k]});
  }
  const bool small = is_small(system);
  if (small) append_small(system);
  for (Index k = 1; k <= system.period(); ++k) phases_.emplace_back(system.at(k), small);
  for (const Phase& phase : phases_) {
    plan_phases_.push_back({.identity = phase.identity,
                            .F = phase.F.rows(),
                            .noise_input = phase.noise_input.rows(),
                            .H = phase.H.rows(),
                            .measurement_root = phase.measurement_root.rows(),
                            .dense_F = phase.dense_F.data(),
                            .dense_H = phase.dense_H.data(),
                            .noise_columns = phase.noise_columns.data()});
  }
  plan_ = {.states = static_cast<std::int32_t>(system.F.rows()),
           .process_noises = static_cast<std::int32_t>(system.noise_input.cols()),
           .measurements = static_cast<std::int32_t>(system.H.rows()),
           .steps = static_cast<std::int64_t>(system.steps.size()),
           .period = system.period(),
           .phase = plan_phases_.data(),
           .initial_root = initial_root_.rows(),
           .step = steps_.data(),
           .small_coefficients = small ? small_coefficients_.data() : nullptr,
           .monobot_roots = monobot_roots_.empty() ? nullptr : monobot_roots_.data()};
}

Moments LinearPlanStorage::nees_moments(std::size_t step, const double* sums, Index runs) const {
  return moments_of(sums, steps_[step].error_whitening.rows, nees_scale_[step], runs);
}

Moments LinearPlanStorage::nis_moments(std::size_t step, const double* sums, Index runs) const {
  return moments_of(sums + 2 * kAccumulators, steps_[step].innovation_whitening.rows, nis_scale_[step], runs);
}

}  // namespace credence::internal
