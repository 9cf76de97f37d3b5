#include "core/inflation.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/pairwise_bound.h"

namespace credence {
namespace {

void require_square(const Matrix& P, const BlockLayout& layout) {
  const Index n = layout.state_dim();
  if (P.rows() == n && P.cols() == n) return;
  throw std::invalid_argument(fmt::format("P is {}x{}, but the layout has {} states", P.rows(), P.cols(), n));
}

void decorrelate(Eigen::Ref<Matrix> A, const BlockLayout& layout, InflationSolution solution) {
  switch (solution) {
    case InflationSolution::pairwise:
      return decorrelate_pairwise(A, layout);
    case InflationSolution::min_trace:
      throw std::invalid_argument("solution = min_trace is not built yet");
    case InflationSolution::sequential:
      throw std::invalid_argument("solution = sequential is a rule within an update, not a map of P");
  }
}

}  // namespace

void inflate(Matrix& P, const BlockLayout& layout, Inflation inflation, InflationSolution solution) {
  require_square(P, layout);
  switch (inflation) {
    case Inflation::none:
      return;
    case Inflation::full:
      return decorrelate(P, layout, solution);
    case Inflation::map: {
      const Index n_f = layout.landmark * layout.landmarks;
      const BlockLayout map{.vehicle = 0, .landmark = layout.landmark, .landmarks = layout.landmarks};
      return decorrelate(P.bottomRightCorner(n_f, n_f), map, solution);
    }
  }
}

}  // namespace credence
