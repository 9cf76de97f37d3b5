#include "analysis/laws/shape/tail_weight.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr std::size_t kPieces = 20, kLeftOut = 2;

/// Values of a piece of a run, over n.
struct Piece {
  double count = 0.0, sum = 0.0, squares = 0.0;

  void add(double x) { add(1.0, x, 0.0); }
  void add(double values, double mean, double deviations) {
    count += values;
    sum += values * mean;
    squares += values * mean * mean + deviations;
  }
  double mean() const { return sum / count; }
};

/// Y of the pieces of runs, without the largest of each.
SkewedMoments weights_of(std::vector<std::array<Piece, kPieces>>& runs, double dof) {
  Piece all;
  for (std::array<Piece, kPieces>& run : runs) {
    std::ranges::stable_sort(run, {}, &Piece::mean);
    for (const Piece& piece : std::span(run).first(kPieces - kLeftOut)) {
      all.count += piece.count;
      all.sum += piece.sum;
    }
  }
  SkewedMoments weights;
  for (const std::array<Piece, kPieces>& run : runs) {
    for (const Piece& piece : std::span(run).first(kPieces - kLeftOut)) {
      const double mean = piece.mean() / all.mean();
      const double square = piece.squares / (piece.count * all.mean() * all.mean());
      weights.add(square * dof / (dof + 2.0) - 2.0 * mean + 2.0);
    }
  }
  return weights;
}

}  // namespace

void RunTails::add(double nees, double dof) {
  squares_ += nees * nees;
  expected_squares_ += dof * (dof + 2.0);
  sum_ += nees;
  dof_ += dof;
}

double RunTails::value() const {
  if (!(dof_ > 0.0)) return kNaN;
  return squares_ / expected_squares_ - 2.0 * sum_ / dof_ + 2.0;
}

bool RunTails::heavier() const {
  const double mean = sum_ / dof_;
  return squares_ > mean * mean * expected_squares_;
}

void TailSums::add(const RunTails& run) {
  const double value = run.value();
  if (std::isnan(value)) return;
  weights.add(value);
  heavier.add(run.heavier());
}

void TailSums::merge(const TailSums& later) {
  weights.merge(later.weights);
  heavier.merge(later.heavier);
}

SkewedMoments tails_of_pieces(std::span<const std::vector<double>> runs, double dof) {
  std::vector<std::array<Piece, kPieces>> pieces;
  for (const std::vector<double>& run : runs) {
    const std::size_t length = run.size() / kPieces;
    if (length == 0) continue;
    std::array<Piece, kPieces>& here = pieces.emplace_back();
    for (std::size_t k = 0; k < length * kPieces; ++k) here[k / length].add(run[k]);
  }
  return weights_of(pieces, dof);
}

SkewedMoments tails_of_pieces(std::span<const Moments> steps, double dof) {
  std::vector<std::array<Piece, kPieces>> pieces(1);
  const std::size_t length = steps.size() / kPieces;
  for (std::size_t k = 0; k < length * kPieces; ++k) {
    const Moments& step = steps[k];
    pieces[0][k / length].add(static_cast<double>(step.count), step.mean / dof, step.m2 / (dof * dof));
  }
  const bool seen =
      length > 0 && std::ranges::all_of(pieces[0], [](const Piece& p) { return p.count > 0.0; });
  return seen ? weights_of(pieces, dof) : SkewedMoments{};
}

double heavy_tail_p_value(const SkewedMoments& run_values) {
  constexpr std::int64_t kFewestRuns = 10;
  if (run_values.count < kFewestRuns || !(run_values.m2 > 0.0) || !std::isfinite(run_values.m3)) return kNaN;
  return student_upper_p_value(hall_score(run_values, 1.0), static_cast<double>(run_values.count - 1));
}

double heavy_tail_p_value(const TailSums& runs) {
  const double by_weight = heavy_tail_p_value(runs.weights);
  if (std::isnan(by_weight)) return kNaN;
  const double by_number = binomial_upper_tail(runs.heavier.inside, runs.heavier.total, 0.5);
  return std::min(1.0, 2.0 * std::min(by_weight, by_number));
}

double far_tail_p_value(const CoverageCount& within, double quantile) {
  const double outside = static_cast<double>(within.total - within.inside);
  const double expected = (1.0 - quantile) * static_cast<double>(within.total);
  const double p = binomial_p_value(within, quantile);
  return outside > 10.0 * std::max(1.0, expected) ? p : 1.0;
}

}  // namespace credence::internal
