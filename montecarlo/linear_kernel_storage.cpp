#include "montecarlo/linear_kernel_storage.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace credence {
namespace {

void require(bool ok, const std::string& what) {
  if (!ok) throw std::invalid_argument("linear system: " + what);
}

void require_shape(const char* name, const Matrix& matrix, Index rows, Index columns) {
  const auto shape = [](Index r, Index c) { return std::to_string(r) + "x" + std::to_string(c); };
  require(matrix.rows() == rows && matrix.cols() == columns,
          std::string(name) + " is " + shape(matrix.rows(), matrix.cols()) + ", not " + shape(rows, columns));
  require(matrix.allFinite(), std::string(name) + " has an entry that is not finite");
}

/// True for the monobots that have a kernel of their own: F = I, noise on the vehicle alone, anchors first.
bool is_small_monobot(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows(), anchors = m - (n - 1);
  if ((n != 2 && n != 3) || anchors < 0 || anchors > 1 || !system.F.isIdentity(0.0)) return false;
  if (system.noise_input.cols() != 1 || !(system.noise_input.bottomRows(n - 1).array() == 0.0).all())
    return false;
  Matrix H = Matrix::Zero(m, n);
  H.col(0).setConstant(-1.0);
  H.bottomRightCorner(n - 1, n - 1).setIdentity();
  if (H != system.H) return false;
  if (!system.measurement_root.isDiagonal(0.0)) return false;
  return std::all_of(system.steps.begin(), system.steps.end(), [&](const LinearErrorSystem::Step& step) {
    return step.innovation_whitening.rows() == m && step.error_whitening.rows() == n &&
           step.innovation_whitening.isLowerTriangular(0.0) && step.error_whitening.isLowerTriangular(0.0);
  });
}

void append_rows(const Matrix& matrix, bool lower, std::vector<double>& out) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < (lower ? row + 1 : matrix.cols()); ++column)
      out.push_back(matrix(row, column));
  }
}

}  // namespace

void check_linear_error_system(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows();
  require_shape("F", system.F, n, n);
  require_shape("noise_input", system.noise_input, n, system.noise_input.cols());
  require_shape("H", system.H, m, n);
  require_shape("measurement_root", system.measurement_root, m, m);
  require_shape("initial_root", system.initial_root, n, n);
  for (const LinearErrorSystem::Step& step : system.steps) {
    require_shape("K", step.K, n, m);
    require_shape("innovation_whitening", step.innovation_whitening, step.innovation_whitening.rows(), m);
    require_shape("error_whitening", step.error_whitening, step.error_whitening.rows(), n);
  }
}

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

void LinearPlanStorage::append_monobot(const LinearErrorSystem& system) {
  monobot_roots_.push_back(system.noise_input(0, 0));
  for (Index i = 0; i < system.H.rows(); ++i) monobot_roots_.push_back(system.measurement_root(i, i));
  for (const LinearErrorSystem::Step& step : system.steps) {
    append_rows(step.K, false, monobot_coefficients_);
    append_rows(step.innovation_whitening, true, monobot_coefficients_);
    append_rows(step.error_whitening, true, monobot_coefficients_);
  }
}

LinearPlanStorage::LinearPlanStorage(const LinearErrorSystem& system)
    : F_(system.F),
      noise_input_(system.noise_input),
      H_(system.H),
      measurement_root_(system.measurement_root),
      initial_root_(system.initial_root) {
  check_linear_error_system(system);
  std::vector<Dense> matrices;
  for (const LinearErrorSystem::Step& step : system.steps) {
    for (const Matrix* matrix : {&step.K, &step.innovation_whitening, &step.error_whitening}) {
      matrices.push_back(append(*matrix));
    }
  }
  for (std::size_t i = 0; i < matrices.size(); i += 3) {
    steps_.push_back({rows_of(matrices[i]), rows_of(matrices[i + 1]), rows_of(matrices[i + 2])});
  }
  if (is_small_monobot(system)) append_monobot(system);
  plan_ = {.states = static_cast<std::int32_t>(system.F.rows()),
           .process_noises = static_cast<std::int32_t>(system.noise_input.cols()),
           .measurements = static_cast<std::int32_t>(system.H.rows()),
           .steps = static_cast<std::int64_t>(system.steps.size()),
           .identity = system.F.isIdentity(0.0),
           .F = F_.rows(),
           .noise_input = noise_input_.rows(),
           .H = H_.rows(),
           .measurement_root = measurement_root_.rows(),
           .initial_root = initial_root_.rows(),
           .step = steps_.data(),
           .monobot_coefficients = monobot_coefficients_.empty() ? nullptr : monobot_coefficients_.data(),
           .monobot_roots = monobot_roots_.data()};
}

}  // namespace credence
