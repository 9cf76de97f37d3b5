#include "analysis/laws/chi_square/chi_square_truncated.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

void require_gate(double gate) {
  if (!(gate > 0.0)) throw std::invalid_argument(fmt::format("gate = {} must be > 0", gate));
}

}  // namespace

Cumulants truncated_chi_square_cumulants(double dof, double gate) {
  require_gate(gate);
  const double passed = chi_square_cdf(gate, dof);
  const double first = dof * chi_square_cdf(gate, dof + 2.0) / passed;
  const double second = dof * (dof + 2.0) * chi_square_cdf(gate, dof + 4.0) / passed;
  const double third = dof * (dof + 2.0) * (dof + 4.0) * chi_square_cdf(gate, dof + 6.0) / passed;
  return {.mean = first,
          .variance = second - first * first,
          .third = third - 3.0 * first * second + 2.0 * first * first * first};
}

}  // namespace credence::internal
