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

}  // namespace

bool LawSums::takes(const std::string& of, Index dim) {
  const Index here = second_moments.dim();
  if (here == dim && (dim == 0 || averaged == of)) return true;
  if (here > dim || (here == dim && averaged < of)) return false;
  averaged = of;
  second_moments = {};
  error_means = {};
  whitened_means = {};
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

bool LawSums::errors_stand() const {
  const VectorMoments& means = whitened_means;
  if (means.count == 0 || means.mean.size() != second_moments.dim()) return false;
  const Matrix square =
      means.scatter / static_cast<double>(means.count) + means.mean * means.mean.transpose();
  return standing_share(mean_of(second_moments), square) > kStandingErrors;
}

void RunLaw::add_error(const Vector& whitened, const Vector& error, const Vector& variance) {
  const Index dim = whitened.size();
  if (outer.rows() != dim) {
    if (steps > 0) return;  // of fewer states than before: no average of the same thing
    outer = Matrix::Zero(dim, dim);
    normalised = whitened_sum = Vector::Zero(dim);
  }
  for (Index j = 0; j < dim; ++j) {
    normalised[j] += error[j] / std::sqrt(variance[j]);
    whitened_sum[j] += whitened[j];
    for (Index i = j; i < dim; ++i) outer(i, j) += whitened[i] * whitened[j];
  }
  ++steps;
}

void RunLaw::add_to(LawSums& sums, const std::string& averaged) const {
  if (steps > 0 && sums.takes(averaged, outer.rows())) {
    sums.second_moments.add(outer / static_cast<double>(steps));
    sums.error_means.add(normalised / static_cast<double>(steps));
    sums.whitened_means.add(whitened_sum / static_cast<double>(steps));
  }
  if (const double tails = nees_tails.value(); !std::isnan(tails)) sums.nees_tails.add(tails);
  if (const double tails = nis_tails.value(); !std::isnan(tails)) sums.nis_tails.add(tails);
  if (nis_dof > 0.0) sums.nis_of_runs.add(nis / nis_dof);
}

bool is_shape_step(std::int64_t step) { return std::has_single_bit(static_cast<std::uint64_t>(step)); }

}  // namespace credence::internal
