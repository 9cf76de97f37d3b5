#include "core/inflation/inflation.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/inflation/pairwise_bound.h"

namespace credence::internal {
namespace {

void require_square(const MatrixRef& P, const BlockLayout& layout) {
  const Index n = layout.state_dim();
  if (P.rows() == n && P.cols() == n) return;
  throw std::invalid_argument(fmt::format("P is {}x{}, but the layout has {} states", P.rows(), P.cols(), n));
}

/// The states that an inflation decorrelates, as a layout of their own, and how many come before them.
struct DecorrelatedSet {
  BlockLayout layout;
  Index offset;
};

DecorrelatedSet decorrelated_set(const BlockLayout& layout, Inflation inflation) {
  switch (inflation) {
    case Inflation::none:
      return {{.vehicle = 0, .landmark = layout.landmark, .landmarks = 0}, layout.state_dim()};
    case Inflation::full: return {layout, 0};
    case Inflation::map:
      return {{.vehicle = 0, .landmark = layout.landmark, .landmarks = layout.landmarks}, layout.vehicle};
  }
  throw std::invalid_argument("unknown inflation");
}

InflationStep decorrelate(Matrix& P, const DecorrelatedSet& set, InflationSolution solution,
                          MinTraceState* state, const MinTraceOptions& options) {
  const Index size = set.layout.state_dim();
  Eigen::Ref<Matrix> A = P.block(set.offset, set.offset, size, size);
  switch (solution) {
    case InflationSolution::pairwise: {
      const double before = A.trace();
      decorrelate_pairwise(A, set.layout);
      return {.added_trace = A.trace() - before};
    }
    case InflationSolution::min_trace: {
      const MinTraceBound bound = decorrelate_min_trace(A, set.layout, options, state);
      return {bound.primal, bound.relative_gap, bound.converged};
    }
    case InflationSolution::sequential:
    case InflationSolution::batch:
    case InflationSolution::drop:
      throw std::invalid_argument(
          "solution = sequential, batch or drop is a rule within an update, not a map of P");
  }
  throw std::invalid_argument("unknown solution");
}

InflationStep inflate(Matrix& P, const BlockLayout& layout, Inflation inflation, InflationSolution solution,
                      MinTraceState* state, const MinTraceOptions& options) {
  require_square(P, layout);
  if (inflation == Inflation::none) return {};
  return decorrelate(P, decorrelated_set(layout, inflation), solution, state, options);
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

void inflate(Matrix& P, const BlockLayout& layout, Inflation inflation, InflationSolution solution) {
  inflate(P, layout, inflation, solution, nullptr, MinTraceOptions{});
}

InflationStep inflate(Matrix& P, const BlockLayout& layout, Inflation inflation, InflationSolution solution,
                      MinTraceState& state, const MinTraceOptions& options) {
  return inflate(P, layout, inflation, solution, &state, options);
}

}  // namespace credence
