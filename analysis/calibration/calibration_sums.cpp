#include "analysis/calibration/calibration_sums.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/correlation/thinned_series.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/run_mean.h"
#include "analysis/laws/ten_stretches.h"
#include "core/linear_algebra/squared_norm.h"
#include "core/record/take_block.h"

namespace credence::internal {
namespace {

/// Of the open run; with fewer than half of them two are joined.
constexpr std::size_t kGroups = 160;

void add_to(std::vector<double>& sums, const std::vector<double>& more) {
  if (sums.size() < more.size()) sums.resize(more.size(), 0.0);
  for (std::size_t i = 0; i < more.size(); ++i) sums[i] += more[i];
}

/// Whether sums over the parts of the two add up.
bool same_states(const RunLayout& a, const RunLayout& b) {
  return a.states == b.states && a.blocks == b.blocks;
}

/// Of the components `at` along any direction.
double largest_variance(const Matrix& P, const std::vector<Index>& at) {
  if (at.size() == 1) return P(at[0], at[0]);
  if (at.size() > 2) return P(at, at).selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const double a = P(at[0], at[0]), b = P(at[1], at[1]);
  return 0.5 * (a + b) + std::hypot(0.5 * (a - b), P(at[1], at[0]));
}

/// With the bits of Eigen, whose expression costs more than three products.
double dot_of_columns(const Matrix& columns, Index a, Index b) {
  if (columns.rows() != 3) return columns.col(a).dot(columns.col(b));
  const double *x = columns.data() + 3 * a, *y = columns.data() + 3 * b;
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

}  // namespace

void CalibrationSum::clear(std::size_t parts) {
  rows = 0;
  nees = 0.0;
  marginal.assign(parts, 0.0);
  pairs.assign(parts * (parts + 1) / 2, 0.0);
  bins.clear();
}

void CalibrationSum::merge(const CalibrationSum& later) {
  rows += later.rows;
  nees += later.nees;
  add_to(marginal, later.marginal);
  add_to(pairs, later.pairs);
  auto next = bins.begin();  // where both have the same
  for (const auto& [place, bin] : later.bins) {
    next = bins.try_emplace(next, place);
    Bin& here = next++->second;
    here.rows += bin.rows;
    here.squared += bin.squared;
    here.variance += bin.variance;
    here.normalised += bin.normalised;
  }
}

void CalibrationUnits::append(CalibrationRecorder& later) {
  std::vector<CalibrationRun> more = later.take();
  if (more.empty()) return;
  if (runs.empty() || layout.states.size() < later.layout().states.size()) {
    runs.clear();
    parts = later.parts();
    layout = later.layout();
  }
  if (!same_states(layout, later.layout())) return;
  std::ranges::move(more, std::back_inserter(runs));
  if (runs.size() > CalibrationRecorder::kMostRuns) runs.resize(CalibrationRecorder::kMostRuns);
}

void CalibrationUnits::keep_whole_runs() {
  for (CalibrationRun& run : runs) {
    run.stretches.clear();
    run.effective_rows = 1.0;
  }
}

std::vector<Block> calibration_parts(const RunLayout& layout) {
  constexpr std::size_t kMostParts = 4;
  std::vector<Block> parts;
  std::vector<bool> taken(layout.states.size(), false);
  const bool map = std::ranges::count(layout.blocks, Part::map, &Block::part) > 0;
  for (const Block& block : layout.blocks) {
    if (block.part == Part::pose || (map && block.part == Part::landmark) || block.states.empty()) continue;
    const auto is_taken = [&](Index s) { return taken[static_cast<std::size_t>(s)]; };
    if (std::ranges::any_of(block.states, is_taken)) continue;
    for (const Index s : block.states) taken[static_cast<std::size_t>(s)] = true;
    parts.push_back(block);
  }
  if (parts.size() > 1 && parts.size() <= kMostParts && std::ranges::all_of(taken, std::identity()))
    return parts;
  Block all{.name = "state", .part = {}, .states = {}};
  for (Index i = 0; i < std::ssize(layout.states); ++i) all.states.push_back(i);
  return {std::move(all)};
}

bool CalibrationRecorder::takes(const RunLayout& layout) {
  const Index n = std::ssize(layout.states);
  return layout.has_truth && layout.joint_covariance && n > 0 && n <= kLargest;
}

void CalibrationRecorder::begin_run(const RunLayout& layout, std::string name) {
  close_run();
  const Index n = std::ssize(layout.states);
  open_ = takes(layout) && runs_.size() < kMostRuns;
  if (!open_) return;
  if (!same_states(layout, layout_)) {
    open_ = n > std::ssize(layout_.states);
    if (!open_) return;
    runs_.clear();
    layout_ = layout;
    parts_ = calibration_parts(layout);
    block_of_part_.clear();
    for (const Block& part : parts_)
      block_of_part_.push_back(
          static_cast<std::size_t>(std::ranges::find(layout.blocks, part) - layout.blocks.begin()));
    const auto position = std::ranges::find(layout.blocks, Part::position, &Block::part);
    position_ = position == layout.blocks.end() ? std::vector<Index>{} : position->states;
    for (std::size_t r = 0; r < kRisks.size() && !position_.empty(); ++r)
      limits_[r] = chi_square_upper_quantile(kRisks[r], static_cast<double>(position_.size()));
  }
  run_ = {.name = std::move(name), .whole = {}, .position_dim = std::ssize(position_)};
  last_bins_.assign(static_cast<std::size_t>(n), {});
  open_groups_ = 0;
  nees_.clear();
  rows_per_group_ = 1;
}

void CalibrationRecorder::add(const Step& step, double distance_m, FactoredState factored) {
  if (!step.problem.empty()) return;
  if (factored.factor != nullptr) return add(factored, distance_m);
  const auto n = static_cast<Index>(layout_.states.size());
  if (!open_ || std::ssize(step.states) != n || step.error.size() != n) return;
  if (!step.error.allFinite() || !factor_.compute(step.P)) return;
  whitened_ = step.error;
  factor_.solve_lower(whitened_);
  add({step.error, step.P, whitened_.squaredNorm(), {&factor_, nullptr}}, distance_m);
}

void CalibrationRecorder::add(FactoredState factored, double distance_m) {
  const NormalisedStep& step = *factored.normalised;
  if (!open_ || step.states.size() != layout_.states.size()) return;
  add({step.error, step.P, step.whole.value, factored}, distance_m);
}

void CalibrationRecorder::add(const Row& row, double distance_m) {
  const auto n = static_cast<Index>(layout_.states.size());
  const double nees = row.nees / static_cast<double>(n);
  if (!std::isfinite(nees)) return;
  CalibrationSum& sum = group_at_hand();
  ++sum.rows;
  sum.nees += nees;
  nees_.push_back(nees);
  const std::size_t m = parts_.size();
  if (m == 1) {
    sum.marginal[0] += nees;
    sum.pairs[0] += static_cast<double>(n) * nees;
  } else {
    add_parts(row, sum);
  }
  for (Index i = 0; i < n; ++i) {
    const double squared = row.error[i] * row.error[i], variance = row.P(i, i);
    CalibrationSum::Bin& bin = bin_of(i, variance, sum);
    ++bin.rows;
    bin.squared += squared;
    bin.variance += variance;
    bin.normalised += squared / variance;
  }
  DistanceSums::Bin here{.rows = 1, .nees = nees};
  if (!position_.empty()) add_position(row, here);
  run_.distance.add(distance_m, here);
}

CalibrationSum::Bin& CalibrationRecorder::bin_of(Index state, double variance, CalibrationSum& sum) {
  LastBin& last = last_bins_[static_cast<std::size_t>(state)];
  if (!(variance > last.above && variance < last.below)) {
    constexpr double kRounding =
        1e-12;  // of the logarithm and the powers: near an edge the logarithm decides
    last.bin = static_cast<int>(std::floor(2.0 * std::log10(variance)));
    last.above = (1.0 + kRounding) * std::pow(10.0, 0.5 * last.bin);
    last.below = (1.0 - kRounding) * std::pow(10.0, 0.5 * (last.bin + 1));
    last.place = -1;
  }
  if (last.place < 0) {
    const std::size_t before = sum.bins.size();
    const auto found = sum.bins.try_emplace(sum.bins.end(), {state, last.bin});  // of a new group
    if (sum.bins.size() > before && found + 1 != sum.bins.end()) {  // which moves those behind it
      for (LastBin& other : last_bins_) other.place = -1;
    }
    last.place = found - sum.bins.begin();
  }
  return sum.bins.nth(static_cast<std::size_t>(last.place))->second;
}

CalibrationSum& CalibrationRecorder::group_at_hand() {
  if (open_groups_ > 0 && groups_[open_groups_ - 1].rows < rows_per_group_) return groups_[open_groups_ - 1];
  if (open_groups_ == kGroups) {
    open_groups_ /= 2;
    for (std::size_t i = 0; i < open_groups_; ++i) {
      if (i > 0) std::swap(groups_[i], groups_[2 * i]);
      groups_[i].merge(groups_[2 * i + 1]);
    }
    rows_per_group_ *= 2;
  }
  if (open_groups_ == groups_.size()) groups_.emplace_back();
  CalibrationSum& group = groups_[open_groups_++];
  group.clear(parts_.size());
  for (LastBin& last : last_bins_) last.place = -1;
  return group;
}

void CalibrationRecorder::add_position(const Row& row, DistanceSums::Bin& here) {
  const double largest = largest_variance(row.P, position_);
  const double squared = squared_norm(row.error, position_);
  for (std::size_t r = 0; r < kRisks.size(); ++r) {
    if (squared > limits_[r] * largest) ++run_.beyond[r];
  }
  here.squared = squared;
  for (const Index i : position_) here.variance += row.P(i, i);
  const auto cell = [](double value) {
    constexpr double kLeast = 1e-12, kMost = 1e12;  // m
    return static_cast<int>(
        std::floor(kStanfordCellsOfADecade * std::log10(std::clamp(value, kLeast, kMost))));
  };
  ++run_.stanford[{cell(std::sqrt(squared)), cell(std::sqrt(largest))}];
}

void CalibrationRecorder::add_parts(const Row& row, CalibrationSum& sum) {
  const std::size_t m = parts_.size();
  parts_whitened_.setZero(row.error.size(), static_cast<Index>(m));  // L⁻¹ e_a, of the error of a part alone
  for (std::size_t a = 0; a < m; ++a) {
    const std::vector<Index>& at = parts_[a].states;
    auto whitened = parts_whitened_.col(static_cast<Index>(a));
    for (const Index state : at) whitened[state] = row.error[state];
    row.factored.factor->solve_lower(whitened);
    if (row.factored.normalised != nullptr) {
      const NormalisedSquare& part = row.factored.normalised->blocks[block_of_part_[a]];
      sum.marginal[a] += part.value / static_cast<double>(at.size());
      continue;
    }
    if (at.size() == 1) {
      const double u = row.error[at[0]] / std::sqrt(row.P(at[0], at[0]));
      sum.marginal[a] += u * u;
      continue;
    }
    take_block(row.error, row.P, at, part_error_, part_P_);
    if (!part_factor_.compute(part_P_)) continue;  // by rounding alone: P has a factor
    part_factor_.solve_lower(part_error_);
    sum.marginal[a] += part_error_.squaredNorm() / static_cast<double>(at.size());
  }
  double* pair = sum.pairs.data();
  for (std::size_t a = 0; a < m; ++a) {
    for (std::size_t b = a; b < m; ++b) {  // e_aᵀ (P⁻¹)_ab e_b
      *pair++ += (a == b ? 1.0 : 2.0) *
                 dot_of_columns(parts_whitened_, static_cast<Index>(a), static_cast<Index>(b));
    }
  }
}

void CalibrationRecorder::add_stretches() {
  const std::size_t groups = open_groups_ / CalibrationRun::kTenths;  // of a tenth
  const auto suffice = [&](std::size_t of_stretch) {
    const double rows = static_cast<double>(of_stretch) * static_cast<double>(rows_per_group_);
    return of_stretch > 0 && rows >= shortest_stretch(run_.correlation_time, 0.0);
  };
  if (!suffice(groups)) return;
  const std::size_t halves = suffice(groups / 2) ? 2 : 1, count = halves * CalibrationRun::kTenths;
  for (std::size_t s = 0; s < count; ++s) {
    CalibrationSum& stretch = run_.stretches.emplace_back();
    for (std::size_t g = s * groups / halves; g < (s + 1) * groups / halves; ++g) stretch.merge(groups_[g]);
  }
}

void CalibrationRecorder::close_run() {
  if (!std::exchange(open_, false) || nees_.empty()) return;
  const double n = static_cast<double>(layout_.states.size());
  for (std::size_t g = 0; g < open_groups_; ++g) run_.whole.merge(groups_[g]);
  const ThinnedSeries series = thinned(nees_);
  const double mean = run_.whole.nees / static_cast<double>(run_.whole.rows);
  const EffectiveSample sample = effective_sample(std::vector<std::span<const double>>{series.values}, mean);
  if (sample.reason.empty()) {
    const double time = series.rows_per_value * sample.correlation_time;
    run_.correlation_time = time;
    run_.effective_rows = unbiased_size(static_cast<double>(run_.whole.rows), time);
    if (std::ssize(runs_) + 1 < kFewestRunsCompared) add_stretches();
  }
  const auto place = static_cast<std::size_t>(std::ceil(kCovered * static_cast<double>(nees_.size()))) - 1;
  std::ranges::nth_element(nees_, nees_.begin() + static_cast<std::ptrdiff_t>(place));
  run_.coverage_factor = n * nees_[place] / chi_square_quantile(kCovered, n);
  runs_.push_back(std::move(run_));
}

std::vector<CalibrationRun> CalibrationRecorder::take() {
  close_run();
  return std::exchange(runs_, {});
}

}  // namespace credence::internal
