#include "datasets/replay/replay_result.h"

#include <cmath>

namespace credence::internal {

bool has_true_heading(const ReplayResult& result) {
  return !result.references.empty() && result.references.front().dof == 3;
}

double gate_threshold(double gate_probability) { return -2.0 * std::log1p(-gate_probability); }

// With 2 dof the law is exponential with mean 2, cut at g: 2 − g (1 − p)/p.
double expected_nis(double gate_probability) {
  if (gate_probability <= 0) return 2.0;
  return 2.0 - gate_threshold(gate_probability) * (1.0 - gate_probability) / gate_probability;
}

}  // namespace credence::internal
