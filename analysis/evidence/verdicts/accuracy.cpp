#include "analysis/evidence/verdicts/accuracy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/scores/rmse_interval.h"

namespace credence::internal {
namespace {

/// As the layout says; nothing where a block mixes angles and others.
std::optional<std::string> unit_of(const Block& block, const RunLayout& layout) {
  std::string unit = unit_of_states(layout, block.states);
  const auto is_angle = [&](Index state) { return unit_of_states(layout, {state}) == "rad"; };
  if (unit.empty() && std::ranges::any_of(block.states, is_angle)) return std::nullopt;
  return unit;
}

}  // namespace

MeanInterval efficiency(double bound, MeanInterval squared) {
  if (std::isnan(bound) || squared.count == 0 || !(squared.mean > 0.0)) return {};
  const double relative = squared.standard_error / squared.mean;
  std::swap(squared.lower, squared.upper);
  for (double* value : {&squared.mean, &squared.lower, &squared.upper}) *value = bound / *value;
  squared.standard_error = relative * squared.mean;
  return squared;
}

MeanInterval BlockAccuracy::efficiency() const {
  return credence::internal::efficiency(bound, squared_error);
}

std::vector<BlockAccuracy> block_accuracy(const Evidence& evidence, double confidence) {
  std::vector<BlockAccuracy> all;
  for (const Block& block : evidence.layout.blocks) {
    if (block.part == Part::pose || block.part == Part::landmark) continue;
    const auto sums = std::ranges::find(evidence.blocks, block.name, &BlockSums::name);
    auto unit = unit_of(block, evidence.layout);
    if (!unit || sums == evidence.blocks.end() || sums->squared_error.count == 0) continue;
    if (sums->squared_error.mean == 0.0 && sums->claimed.mean == 0.0) continue;  // known exactly
    all.push_back({.of = block.name,
                   .unit = *std::move(unit),
                   .squared_error = mean_square_interval(sums->squared_error, confidence),
                   .claimed = sums->claimed.mean});
  }
  return all;
}

void add_bound(const PosteriorBound& bound, const StudyStatistics& statistics, double confidence,
               std::vector<BlockAccuracy>& accuracy) {
  for (const BoundCurve& curve : bound.blocks) {
    const auto block = std::ranges::find(accuracy, curve.block, &BlockAccuracy::of);
    if (block == accuracy.end()) continue;
    if (!std::isnan(curve.mean_bound())) {
      block->bound = curve.mean_bound();
      block->at_truth = curve.mean_at_truth();
    } else if (const Moments& squared = statistics.steps.back()[Quantity::landmark_error_squared];
               squared.count > 0 && !std::isnan(curve.bound.back())) {
      const Moments& claimed = statistics.steps.back()[Quantity::landmark_variance];
      BlockAccuracy last{.of = block->of + ", last step",
                         .unit = block->unit,
                         .squared_error = positive_mean_interval(squared, confidence),
                         .claimed = claimed.count > 0 ? claimed.mean : kNaN,
                         .at_truth = curve.at_truth.back(),
                         .bound = curve.bound.back()};
      accuracy.insert(block + 1, std::move(last));
    }
  }
}

}  // namespace credence::internal
