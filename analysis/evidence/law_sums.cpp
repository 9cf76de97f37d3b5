#include "analysis/evidence/law_sums.h"

#include <bit>
#include <cmath>

#include "analysis/evidence/step_series.h"
#include "analysis/laws/effective_sample.h"

namespace credence::internal {
namespace {

/// Whether a vector of `dim` is added to the moments; those of a smaller one make place.
bool takes_vector(VectorMoments& moments, Index dim) {
  if (moments.count == 0 || moments.mean.size() == dim) return true;
  if (moments.mean.size() > dim) return false;
  moments = {};
  return true;
}

bool stand(const VectorMoments& means, const SecondMoments& second) {
  if (means.count == 0 || means.mean.size() != second.dim()) return false;
  const Matrix square =
      means.scatter / static_cast<double>(means.count) + means.mean * means.mean.transpose();
  return standing_share(mean_of(second), square) > kStandingErrors;
}

/// Adds the means of ten equal stretches; of fewer groups of rows none.
void add_stretches(const RunLaw& run, VectorMoments& means) {
  constexpr std::size_t kStretches = 10;
  const std::size_t groups = static_cast<std::size_t>(run.steps / run.rows_of_group) / kStretches;
  if (groups == 0) return;
  const auto rows = static_cast<double>(static_cast<Index>(groups) * run.rows_of_group);
  for (std::size_t i = 0; i < kStretches; ++i) {
    Vector sum = Vector::Zero(run.outer.rows());
    for (std::size_t g = i * groups; g < (i + 1) * groups; ++g) sum += run.whitened_sums[g];
    means.add(sum / rows);
  }
}

}  // namespace

bool LawSums::takes(const std::string& of, Index dim) {
  const Index here = second_moments.dim();
  if (here == dim && (dim == 0 || averaged == of)) return true;
  if (here > dim || (here == dim && averaged < of)) return false;
  averaged = of;
  second_moments = {};
  error_means = {};
  whitened_means = {};
  stretch_means = {};
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
    whitened_means.merge(later.whitened_means);
    stretch_means.merge(later.stretch_means);
  }
  for (const auto& [step, moments] : later.whitened) {
    VectorMoments& here = whitened[step];
    if (takes_vector(here, moments.mean.size())) here.merge(moments);
  }
  nees_tails.merge(later.nees_tails);
  nis_tails.merge(later.nis_tails);
  nis_of_runs.merge(later.nis_of_runs);
  merge_series(nees_at, later.nees_at);
  merge_series(nis_at, later.nis_at);
}

bool LawSums::errors_stand() const { return stand(whitened_means, second_moments); }

bool LawSums::stretches_stand() const { return stand(stretch_means, second_moments); }

Vector& RunLaw::group_at_hand() {
  constexpr std::size_t kMostGroups = 64;
  if (steps % rows_of_group != 0) return whitened_sums.back();
  if (whitened_sums.size() == kMostGroups) {
    for (std::size_t i = 0; i < kMostGroups / 2; ++i)
      whitened_sums[i] = whitened_sums[2 * i] + whitened_sums[2 * i + 1];
    whitened_sums.resize(kMostGroups / 2);
    rows_of_group *= 2;
  }
  return whitened_sums.emplace_back(Vector::Zero(outer.rows()));
}

void RunLaw::add_error(const Vector& whitened, const Vector& error, const Vector& variance) {
  const Index dim = whitened.size();
  if (outer.rows() != dim) {
    if (steps > 0) return;  // of fewer states than before: no average of the same thing
    outer = Matrix::Zero(dim, dim);
    normalised = Vector::Zero(dim);
  }
  Vector& sum = group_at_hand();
  for (Index j = 0; j < dim; ++j) {
    normalised[j] += error[j] / std::sqrt(variance[j]);
    sum[j] += whitened[j];
    for (Index i = j; i < dim; ++i) outer(i, j) += whitened[i] * whitened[j];
  }
  ++steps;
}

void RunLaw::add_to(LawSums& sums, const std::string& averaged) const {
  if (steps > 0 && sums.takes(averaged, outer.rows())) {
    sums.second_moments.add(outer / static_cast<double>(steps));
    sums.error_means.add(normalised / static_cast<double>(steps));
    Vector sum = Vector::Zero(outer.rows());
    for (const Vector& of_group : whitened_sums) sum += of_group;
    sums.whitened_means.add(sum / static_cast<double>(steps));
    add_stretches(*this, sums.stretch_means);
  }
  if (const double tails = nees_tails.value(); !std::isnan(tails)) sums.nees_tails.add(tails);
  if (const double tails = nis_tails.value(); !std::isnan(tails)) sums.nis_tails.add(tails);
  if (nis_dof > 0.0) sums.nis_of_runs.add(nis / nis_dof);
}

bool is_shape_step(std::int64_t step) { return std::has_single_bit(static_cast<std::uint64_t>(step)); }

}  // namespace credence::internal
