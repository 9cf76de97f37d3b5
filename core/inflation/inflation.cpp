#include "core/inflation/inflation.h"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>

#include "core/inflation/pairwise_bound.h"
#include "core/linear_algebra/decompositions.h"

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

/// Rank, gap and least eigenvalues of a symmetric ΔP that should be psd.
void describe_spectrum(InflationReport& report, const Matrix& delta, double tolerance) {
  const Index size = delta.rows();
  const double largest = delta.diagonal().maxCoeff();
  report.min_eigenvalue =
      Eigen::SelfAdjointEigenSolver<Matrix>(delta, Eigen::EigenvaluesOnly).eigenvalues()(0);
  if (!(largest > 0.0)) return;
  const Vector scale = delta.diagonal().cwiseMax(1e-6 * largest).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * delta * scale.asDiagonal();
  const Vector eigenvalues =
      Eigen::SelfAdjointEigenSolver<Matrix>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  report.min_relative_eigenvalue = eigenvalues(0);
  report.rank = (eigenvalues.array() > tolerance * eigenvalues(size - 1)).count();
  const Index first_kept = size - report.rank;
  const double dropped = first_kept > 0 ? eigenvalues(first_kept - 1) : 0.0;
  report.rank_gap =
      dropped > 0.0 ? eigenvalues(first_kept) / dropped : std::numeric_limits<double>::infinity();
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

InflationReport describe_inflation(const MatrixRef& P_before, const MatrixRef& P_after,
                                   const BlockLayout& layout, Inflation inflation, double rank_tolerance) {
  require_square(P_before, layout);
  require_square(P_after, layout);
  const auto [set, offset] = decorrelated_set(layout, inflation);
  InflationReport report;
  report.size = set.state_dim();
  if (report.size == 0) return report;
  const Matrix before = P_before.block(offset, offset, report.size, report.size);
  const Matrix delta = P_after.block(offset, offset, report.size, report.size) - before;
  describe_spectrum(report, delta, rank_tolerance);
  const MinTraceBound exact = min_trace_bound(before, set);
  report.trace = delta.trace();
  report.exact_trace = exact.primal;
  report.exact_gap = exact.relative_gap;
  if (exact.primal > 0.0) report.trace_ratio = report.trace / exact.primal;
  return report;
}

}  // namespace credence
