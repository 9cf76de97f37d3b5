#include "montecarlo/lanes/linear_kernel_units.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

void require_shape(const char* name, const Matrix& matrix, Index rows, Index columns) {
  if (matrix.rows() != rows || matrix.cols() != columns) {
    throw std::invalid_argument(fmt::format("linear system: {} is {}x{}, not {}x{}", name, matrix.rows(),
                                            matrix.cols(), rows, columns));
  }
  if (!matrix.allFinite()) {
    throw std::invalid_argument(fmt::format("linear system: {} has an entry that is not finite", name));
  }
}

double first_nonzero(const Matrix& matrix) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < matrix.cols(); ++column) {
      if (matrix(row, column) != 0.0) return matrix(row, column);
    }
  }
  return 1.0;
}

/// Divides by the last entry c after the change of units; returns c². One whose square, or what it
/// multiplies, would leave the range of a double stays as it is: its products with errors in these units do
/// not.
double scale_whitening(double unit, Matrix& whitening) {
  whitening *= unit;
  const double last = whitening.size() == 0 ? 0.0 : whitening(whitening.rows() - 1, whitening.cols() - 1);
  constexpr double kLargest = 1e100;
  if (!(std::abs(last) < kLargest && std::abs(last) > 1.0 / kLargest)) return 1.0;
  whitening /= last;
  return last * last;
}

}  // namespace

void check_linear_error_system(const LinearErrorSystem& system) {
  const Index n = system.F.rows(), m = system.H.rows();
  for (Index k = 1; k <= system.period(); ++k) {
    const LinearErrorDynamics& dynamics = system.at(k);
    require_shape("F", dynamics.F, n, n);
    require_shape("noise_input", dynamics.noise_input, n, system.noise_input.cols());
    require_shape("H", dynamics.H, m, n);
    require_shape("measurement_root", dynamics.measurement_root, m, m);
  }
  require_shape("initial_root", system.initial_root, n, n);
  for (const LinearErrorSystem::Step& step : system.steps) {
    require_shape("K", step.K, n, m);
    require_shape("innovation_whitening", step.innovation_whitening, step.innovation_whitening.rows(), m);
    require_shape("error_whitening", step.error_whitening, step.error_whitening.rows(), n);
  }
}

LinearSystemInUnits linear_system_in_units(const LinearErrorSystem& system) {
  check_linear_error_system(system);
  LinearSystemInUnits out{
      .system = system, .unit = first_nonzero(system.noise_input), .nis_scale = {}, .nees_scale = {}};
  const auto scale = [&](LinearErrorDynamics& dynamics) {
    dynamics.noise_input /= out.unit;
    dynamics.measurement_root /= out.unit;
  };
  scale(out.system);
  for (LinearErrorDynamics& dynamics : out.system.later) scale(dynamics);
  out.system.initial_root /= out.unit;
  for (LinearErrorSystem::Step& step : out.system.steps) {
    out.nis_scale.push_back(scale_whitening(out.unit, step.innovation_whitening));
    out.nees_scale.push_back(scale_whitening(out.unit, step.error_whitening));
  }
  return out;
}

}  // namespace credence::internal
