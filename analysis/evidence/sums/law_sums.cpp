#include "analysis/evidence/sums/law_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "analysis/evidence/sums/step_series.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/mean/effective_sample.h"

namespace credence::internal {
namespace {

constexpr Index kOfEnds = 3;  // tenths of a run at each end

/// Whether a vector of `dim` is added to the moments; those of a smaller one make place.
bool takes_vector(VectorMoments& moments, Index dim) {
  if (moments.count == 0 || moments.mean.size() == dim) return true;
  if (moments.mean.size() > dim) return false;
  moments = {};
  return true;
}

/// Rows of a group that are whitened.
Index whitened_of_group(Index dim, bool few_runs) {
  constexpr Index kFewStates = 6;
  return few_runs || dim <= kFewStates ? 8 : 1;
}

/// What holds in either of them; `all` may be empty still.
void join(const std::vector<bool>& more, std::vector<bool>& all) {
  all.resize(more.size());
  for (std::size_t i = 0; i < more.size(); ++i) all[i] = all[i] || more[i];
}

/// E[m mᵀ] of vectors m.
Matrix square_of(const VectorMoments& m) {
  return m.scatter / static_cast<double>(m.count) + m.mean * m.mean.transpose();
}

}  // namespace

Index largest_averaged(const RunLayout& layout) {
  constexpr Index kLargest = 24;
  const auto of_map = [](const Block& block) {
    return block.part == Part::landmark || block.part == Part::map;
  };
  return std::ranges::any_of(layout.blocks, of_map) ? kLargestAveragedMap : kLargest;
}

Index RunWhitened::every(Index of_group) const {
  return std::max<Index>(1, (sums.joins() ? 2 : 1) * sums.rows_of_group() / of_group);
}

// Another one of each, as what recurs every few rows would be seen at its best or at its worst alone.
bool RunWhitened::takes(Index of_group) const {
  const Index each = every(of_group), row = sums.rows();
  return (row & (each - 1)) == ((row / each) & (each - 1));
}

void RunWhitened::skip() { next(outer.rows()); }

void RunWhitened::add_square(const Vector& of, Index times) {
  squared += times;
  // Plain: of a few states an expression costs more than its numbers.
  const Index dim = of.size();
  const auto add_to = [&](Matrix& sum) {
    for (Index j = 0; j < dim; ++j) {
      const double by = static_cast<double>(times) * of[j];
      for (Index i = j; i < dim; ++i) sum(i, j) += by * of[i];
    }
  };
  add_to(outer);
  if (!by_group) return;
  add_to(squares.back());
  squared_of_group.back() += times;
}

void RunWhitened::add(const Vector& whitened, Index of_group) {
  const Index times = every(of_group);
  next(whitened.size()) += static_cast<double>(times) * whitened;
  add_square(whitened, times);
}

void RunWhitened::add_each(const Vector& normalised, Index of_group) {
  const Index times = takes(of_group) ? every(of_group) : 0;
  next(normalised.size()) += normalised;
  if (times > 0) add_square(normalised, times);
}

Vector RunWhitened::mean() const {
  Vector sum = Vector::Zero(outer.rows());
  for (Index g = 0; g < sums.groups(); ++g) sum += sums.of_group(g);
  return sum / static_cast<double>(squared);
}

Eigen::Map<Vector> RunWhitened::next(Index dim) {
  if (sums.rows() == 0) outer = Matrix::Zero(dim, dim);
  if (by_group && sums.begins()) begin_squares(dim);
  return sums.next(dim);
}

void RunWhitened::begin_squares(Index dim) {
  if (sums.joins()) {
    const std::size_t half = squares.size() / 2;
    for (std::size_t i = 0; i < half; ++i) {
      squares[i] = squares[2 * i] + squares[2 * i + 1];
      squared_of_group[i] = squared_of_group[2 * i] + squared_of_group[2 * i + 1];
    }
    squares.resize(half);
    squared_of_group.resize(half);
  }
  squares.emplace_back(Matrix::Zero(dim, dim));
  squared_of_group.push_back(0);
}

bool StretchSums::takes(Index dim) {
  if (square.rows() == dim) return true;
  if (square.rows() > dim) return false;
  *this = {};
  square = across = between = Matrix::Zero(dim, dim);
  return true;
}

void StretchSums::add(const RunWhitened& run, const RunSamples& evenly) {
  constexpr Index kStretches = 10;
  const Index groups = run.sums.rows() / run.sums.rows_of_group() / kStretches;
  if (groups == 0 || !takes(run.outer.rows())) return;
  ++runs;
  constexpr Index kMostOscillating = 512;  // the share costs their square
  const Matrix errors = evenly.errors(kMostOscillating);
  oscillating += oscillating_share(errors);
  samples += errors.cols();
  square += run.outer / static_cast<double>(run.squared);
  const auto rows = static_cast<double>(groups * run.sums.rows_of_group());
  Matrix tenths(run.outer.rows(), kStretches);
  for (Index i = 0; i < kStretches; ++i) {
    Vector sum = Vector::Zero(run.outer.rows());
    for (Index g = i * groups; g < (i + 1) * groups; ++g) sum += run.sums.of_group(g);
    tenths.col(i) = sum / rows;
    means.add(tenths.col(i));
  }
  const Vector first = tenths.leftCols<kOfEnds>().rowwise().mean();
  const Vector last = tenths.rightCols<kOfEnds>().rowwise().mean();
  across += 0.5 * (first * last.transpose() + last * first.transpose());
  const Index pairs = tenths.cols() - 1;
  const Matrix steps = tenths.rightCols(pairs) - tenths.leftCols(pairs);
  between += steps * steps.transpose() / (2.0 * static_cast<double>(pairs));
}

void StretchSums::merge(const StretchSums& later) {
  if (later.runs == 0 || !takes(later.square.rows())) return;
  runs += later.runs;
  oscillating += later.oscillating;
  samples += later.samples;
  square += later.square;
  across += later.across;
  between += later.between;
  means.merge(later.means);
}

bool StretchSums::stand(double effective_rows) const {
  return last(effective_rows) || oscillate(effective_rows) || persist(effective_rows);
}

bool StretchSums::persist(double effective_rows) const {
  constexpr double kClearly = 2.5, kCounts = 0.5, kLevel = 0.05;
  const auto of_runs = static_cast<double>(runs), dim = static_cast<double>(square.rows());
  const double squares = across.squaredNorm(), trace = across.trace(), size = square.trace() / dim;
  const double by_chance = between.norm() / (kOfEnds * std::sqrt(of_runs));
  if (runs == 0 || !(size > 0.0) || !(trace > kClearly * by_chance)) return false;
  const double seen = of_runs * trace * trace / squares;    // R d
  if (!(seen > 0.0) || !std::isfinite(seen)) return false;  // of squares too small for a number
  const double perhaps = seen / chi_square_quantile(kLevel, seen);
  const double of_mean = perhaps * std::sqrt(2.0 * squares / of_runs) / (size * dim);
  return of_mean > kCounts * std::sqrt(2.0 / (dim * effective_rows));
}

bool StretchSums::last(double effective_rows) const {
  if (runs == 0) return false;
  return standing_share(square / static_cast<double>(runs), square_of(means)) >
         least_standing_share(square.rows(), means.count, effective_rows);
}

bool StretchSums::oscillate(double effective_rows) const {
  if (runs == 0) return false;
  const auto of_runs = static_cast<double>(runs);
  const double rows = std::min(effective_rows, static_cast<double>(samples)) / of_runs;
  return oscillating / of_runs > least_standing_share(square.rows(), kOscillatingStretches, rows);
}

bool StretchSums::stay() const {
  if (runs == 0) return false;
  return standing_share(square / static_cast<double>(runs), means.mean * means.mean.transpose()) >
         kStandingErrors;
}

void StretchMoments::add(const RunWhitened& run) {
  const auto full = static_cast<std::size_t>(run.sums.rows() / run.sums.rows_of_group());
  for (std::size_t k = 0; k < of.size(); ++k) {
    const auto stretches = static_cast<std::size_t>(kStretches[k]);
    const std::size_t groups = std::min(full, run.squares.size()) / stretches;
    for (std::size_t i = 0; i < stretches && groups > 0; ++i) {
      Matrix sum = Matrix::Zero(run.outer.rows(), run.outer.cols());
      Index rows = 0;
      for (std::size_t g = i * groups; g < (i + 1) * groups; ++g) {
        sum += run.squares[g];
        rows += run.squared_of_group[g];
      }
      if (rows > 0) of[k].add(sum / static_cast<double>(rows));
    }
  }
}

void StretchMoments::merge(const StretchMoments& later) {
  for (std::size_t k = 0; k < of.size(); ++k) of[k].merge(later.of[k]);
}

SecondMoments StretchMoments::of_runs(std::int64_t runs) const {
  const auto stretches = static_cast<Index>(stretches_of_each(static_cast<std::size_t>(runs)));
  const auto at = std::ranges::find(kStretches, stretches);
  if (at == kStretches.end()) return {};
  const SecondMoments& found = of[static_cast<std::size_t>(at - kStretches.begin())];
  return found.runs() == stretches * runs ? found : SecondMoments{};
}

bool LawSums::takes(const std::string& of, Index dim) {
  const Index here = second_moments.dim();
  if (here == dim && (dim == 0 || averaged == of)) return true;
  if (here > dim || (here == dim && averaged < of)) return false;
  averaged = of;
  second_moments = {};
  error_means = {};
  correlated = {};
  whitened_means = {};
  stretch_moments = {};
  return true;
}

void LawSums::add_whitened(std::int64_t step, const Vector& error) {
  VectorMoments& here = whitened[step];
  if (takes_vector(here, error.size())) here.add(error);
}

void LawSums::merge(const LawSums& later) {
  if (second_moments.dim() == 0) averaged = later.averaged;
  if (later.second_moments.dim() > 0 && takes(later.averaged, later.second_moments.dim())) {
    second_moments.merge(later.second_moments);
    error_means.merge(later.error_means);
    join(later.correlated, correlated);
    whitened_means.merge(later.whitened_means);
    stretch_moments.merge(later.stretch_moments);
    if (second_moments.runs() > StretchSums::kMostRuns) stretch_moments = {};
  }
  stretches.merge(later.stretches);
  for (const auto& [step, moments] : later.whitened) {
    VectorMoments& here = whitened[step];
    if (takes_vector(here, moments.mean.size())) here.merge(moments);
  }
  nees_tails.merge(later.nees_tails);
  nis_tails.merge(later.nis_tails);
  nis_of_runs.merge(later.nis_of_runs);
  merge_series(nis_at, later.nis_at);
}

bool LawSums::errors_stand() const {
  if (whitened_means.count == 0 || whitened_means.mean.size() != second_moments.dim()) return false;
  return standing_share(mean_of(second_moments), square_of(whitened_means)) > kStandingErrors;
}

bool RunLaw::add_error(const Vector& error, const Vector& variance) {
  const Index dim = error.size();
  if (normalised.size() != dim) {
    if (errors > 0) return false;  // of fewer states than before: no average of the same thing
    normalised = Vector::Zero(dim);
  }
  ++errors;
  for (Index i = 0; i < dim; ++i) normalised[i] += error[i] / std::sqrt(variance[i]);
  if (averaged.takes(whitened_of_group(dim, few))) return true;
  averaged.skip();
  return false;
}

void RunLaw::add_whitened(const Vector& whitened, const Matrix& P) {
  constexpr double kRounding = 1e-9;  // of a correlation
  const Index dim = whitened.size();
  averaged.add(whitened, whitened_of_group(dim, few));
  correlated.resize(pair_of(dim, 0), false);
  for (Index p = 1; p < dim; ++p) {
    for (Index q = 0; q < p; ++q) {
      if (correlated[pair_of(p, q)]) continue;
      correlated[pair_of(p, q)] = std::abs(P(p, q)) > kRounding * std::sqrt(P(p, p)) * std::sqrt(P(q, q));
    }
  }
}

const RunSamples& RunLaw::samples_of_all(Index rows) const {
  static const RunSamples kNone;
  if (samples.rows() == rows) return samples;
  return lead_samples.rows() == rows ? lead_samples : kNone;
}

void RunLaw::add_to(LawSums& sums, const std::string& of) const {
  if (averaged.squared > 0 && sums.takes(of, averaged.outer.rows())) {
    sums.second_moments.add(averaged.outer / static_cast<double>(averaged.squared));
    sums.error_means.add(normalised / static_cast<double>(errors));
    if (of.empty()) join(correlated, sums.correlated);
    sums.whitened_means.add(averaged.mean());
    if (few) sums.stretch_moments.add(averaged);
    if (sums.second_moments.runs() > StretchSums::kMostRuns) sums.stretch_moments = {};
  }
  sums.stretches.add(of.empty() && averaged.sums.rows() > large.sums.rows() ? averaged : large, samples);
  sums.nees_tails.add(nees_tails);
  sums.nis_tails.add(nis_tails);
  if (nis_dof > 0.0) sums.nis_of_runs.add(nis / nis_dof);
}

bool is_shape_step(std::int64_t step) { return std::has_single_bit(static_cast<std::uint64_t>(step)); }

}  // namespace credence::internal
