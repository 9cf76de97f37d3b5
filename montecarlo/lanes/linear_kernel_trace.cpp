#include <stdexcept>
#include <string>
#include <utility>

#include "core/simd/fused_multiply_add.h"
#include "montecarlo/lanes/linear_kernel_units.h"

namespace credence::internal {
namespace {

/// y += sign M x, term by term.
void add_product(const Matrix& matrix, const Vector& x, Vector& y, double sign = 1.0) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    double sum = y[row];
    for (Index column = 0; column < matrix.cols(); ++column)
      sum = fused_multiply_add(sign * matrix(row, column), x[column], sum);
    y[row] = sum;
  }
}

/// y = M x, in the memory that y has.
const Vector& set_product(const Matrix& matrix, const Vector& x, Vector& y) {
  y.setZero(matrix.rows());
  add_product(matrix, x, y);
  return y;
}

double squared_norm_in_order(const Vector& y) {
  double sum = 0.0;
  for (const double value : y) sum = fused_multiply_add(value, value, sum);
  return sum;
}

void set_normals(const NoiseSource& noise, Index run, Index step, NoisePurpose purpose, Index count,
                 Vector& out) {
  out.resize(count);
  noise.normals(run, step, purpose, {out.data(), static_cast<std::size_t>(count)});
}

}  // namespace

LinearRunTrace trace_linear(const LinearErrorSystem& in_si, const NoiseSource& noise, Index run) {
  const auto [system, unit, nis_scale, nees_scale] = linear_system_in_units(in_si);
  if (run < 0) throw std::invalid_argument("trace_linear: run is negative: " + std::to_string(run));
  LinearRunTrace trace;
  Vector v, w, e, before, nu, y;
  set_normals(noise, run, 0, NoisePurpose::initial, system.F.rows(), v);
  trace.initial_error = unit * set_product(system.initial_root, v, e);
  for (std::size_t k = 0; k < system.steps.size(); ++k) {
    const LinearErrorSystem::Step& step = system.steps[k];
    const Index number = static_cast<Index>(k) + 1;
    const LinearErrorDynamics& now = system.at(number);
    set_normals(noise, run, number, NoisePurpose::process, now.noise_input.cols(), v);
    set_normals(noise, run, number, NoisePurpose::measurement, now.H.rows(), w);
    std::swap(e, before);
    set_product(now.F, before, e);
    add_product(now.noise_input, v, e);
    set_product(now.H, e, nu);
    add_product(now.measurement_root, w, nu);
    add_product(step.K, nu, e, -1.0);
    trace.errors.push_back(unit * e);
    trace.innovations.push_back(unit * nu);
    trace.process_noise.push_back(unit * set_product(now.noise_input, v, y));
    trace.measurement_noise.push_back(unit * set_product(now.measurement_root, w, y));
    trace.nees.push_back(nees_scale[k] * squared_norm_in_order(set_product(step.error_whitening, e, y)));
    trace.nis.push_back(nis_scale[k] * squared_norm_in_order(set_product(step.innovation_whitening, nu, y)));
  }
  return trace;
}

}  // namespace credence::internal
