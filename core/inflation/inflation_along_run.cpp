#include "core/inflation/inflation_along_run.h"

namespace credence::internal {
namespace {

/// The blocks of the map side by side, d×n_f.
Matrix map_blocks(const Matrix& P, const BlockLayout& layout) {
  const Index d = layout.landmark;
  Matrix blocks(d, d * layout.landmarks);
  for (Index j = 0; j < layout.landmarks; ++j) {
    blocks.middleCols(d * j, d) = P.block(layout.landmark_offset(j), layout.landmark_offset(j), d, d);
  }
  return blocks;
}

void set_map_blocks(Matrix& P, const BlockLayout& layout, const Matrix& blocks) {
  const Index d = layout.landmark;
  for (Index j = 0; j < layout.landmarks; ++j) {
    P.block(layout.landmark_offset(j), layout.landmark_offset(j), d, d) = blocks.middleCols(d * j, d);
  }
}

double trace_of(const Matrix& P, const BlockLayout& layout) {
  return P.diagonal().tail(layout.landmark * layout.landmarks).sum();
}

}  // namespace

InflationStep InflationAlongRun::apply(Matrix& P, const BlockLayout& layout, const InflationRule& rule,
                                       const MinTraceOptions& options) {
  if (rule.is_sequential()) return {};
  const bool guarded = rule.inflation == Inflation::map && rule.solution == InflationSolution::min_trace &&
                       rule.constant.size() == 0;
  if (!guarded) return inflate(P, layout, rule.inflation, rule.solution, warm_start_, options);

  const double before = trace_of(P, layout);
  InflationStep step = inflate(P, layout, rule.inflation, rule.solution, warm_start_, options);
  if (blocks_.cols() == layout.landmark * layout.landmarks && trace_of(P, layout) > trace_) {
    set_map_blocks(P, layout, blocks_);
    step.added_trace = trace_ - before;
    step.kept = true;
    return step;
  }
  blocks_ = map_blocks(P, layout);
  trace_ = trace_of(P, layout);
  return step;
}

}  // namespace credence::internal
