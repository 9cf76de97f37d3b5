#include <cmath>
#include <stdexcept>
#include <string>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/lanes/linear_kernel_units.h"

namespace credence::internal {
namespace {

/// y += M x, term by term.
void add_product(const Matrix& matrix, const Vector& x, Vector& y) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index column = 0; column < matrix.cols(); ++column)
      y[row] = fused_multiply_add(matrix(row, column), x[column], y[row]);
  }
}

Vector product(const Matrix& matrix, const Vector& x) {
  Vector y = Vector::Zero(matrix.rows());
  add_product(matrix, x, y);
  return y;
}

double product_squared_norm(const Matrix& matrix, const Vector& x) {
  const Vector y = product(matrix, x);
  double sum = 0.0;
  for (const double value : y) sum = fused_multiply_add(value, value, sum);
  return sum;
}

Vector normals(const NoiseSource& noise, Index run, Index step, NoisePurpose purpose, Index count) {
  Vector out(count);
  noise.normals(run, step, purpose, {out.data(), static_cast<std::size_t>(count)});
  return out;
}

}  // namespace

LinearRunTrace trace_linear(const LinearErrorSystem& in_si, const NoiseSource& noise, Index run) {
  const auto [system, unit, nis_scale, nees_scale] = linear_system_in_units(in_si);
  if (run < 0) throw std::invalid_argument("trace_linear: run is negative: " + std::to_string(run));
  LinearRunTrace trace;
  Vector e = product(system.initial_root, normals(noise, run, 0, NoisePurpose::initial, system.F.rows()));
  trace.initial_error = unit * e;
  for (std::size_t k = 0; k < system.steps.size(); ++k) {
    const LinearErrorSystem::Step& step = system.steps[k];
    const Index number = static_cast<Index>(k) + 1;
    const LinearErrorDynamics& now = system.at(number);
    const Vector v = normals(noise, run, number, NoisePurpose::process, now.noise_input.cols());
    const Vector w = normals(noise, run, number, NoisePurpose::measurement, now.H.rows());
    e = product(now.F, e);
    add_product(now.noise_input, v, e);
    Vector nu = product(now.H, e);
    add_product(now.measurement_root, w, nu);
    add_product(-step.K, nu, e);
    trace.errors.push_back(unit * e);
    trace.innovations.push_back(unit * nu);
    trace.process_noise.push_back(unit * product(now.noise_input, v));
    trace.measurement_noise.push_back(unit * product(now.measurement_root, w));
    trace.nees.push_back(nees_scale[k] * product_squared_norm(step.error_whitening, e));
    trace.nis.push_back(nis_scale[k] * product_squared_norm(step.innovation_whitening, nu));
  }
  return trace;
}

}  // namespace credence::internal
