#include "analysis/evidence/law_sums.h"

#include <bit>
#include <cmath>

#include "analysis/evidence/step_series.h"
#include "analysis/laws/effective_sample.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kRunAverages = 0;  // the key of LawSums::whitened

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
  whitened.erase(kRunAverages);
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
    if (const auto means = later.whitened.find(kRunAverages); means != later.whitened.end())
      whitened[kRunAverages].merge(means->second);
  }
  for (const auto& [step, moments] : later.whitened) {
    if (step == kRunAverages) continue;
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
  const auto found = whitened.find(kRunAverages);
  if (found == whitened.end() || found->second.mean.size() != second_moments.dim()) return false;
  const VectorMoments& means = found->second;
  const Matrix square =
      means.scatter / static_cast<double>(means.count) + means.mean * means.mean.transpose();
  return standing_share(mean_of(second_moments), square) > kStandingErrors;
}

void RunLaw::add_error(const Vector& whitened, const Vector& error, const Vector& variance) {
  const Index dim = whitened.size();
  if (outer.rows() != dim) {
    if (steps > 0) return;  // of fewer states than before: no average of the same thing
    outer = Matrix::Zero(dim, dim);
    normalised = Vector::Zero(2 * dim);
  }
  for (Index j = 0; j < dim; ++j) {
    normalised[j] += error[j] / std::sqrt(variance[j]);
    normalised[dim + j] += whitened[j];
    for (Index i = j; i < dim; ++i) outer(i, j) += whitened[i] * whitened[j];
  }
  ++steps;
}

void RunLaw::add_to(LawSums& sums, const std::string& averaged) const {
  if (steps > 0 && sums.takes(averaged, outer.rows())) {
    sums.second_moments.add(outer / static_cast<double>(steps));
    const Vector averages = normalised / static_cast<double>(steps);
    sums.error_means.add(averages.head(outer.rows()));
    sums.whitened[kRunAverages].add(averages.tail(outer.rows()));
  }
  if (const double tails = nees_tails.value(); !std::isnan(tails)) sums.nees_tails.add(tails);
  if (const double tails = nis_tails.value(); !std::isnan(tails)) sums.nis_tails.add(tails);
  if (nis_dof > 0.0) sums.nis_of_runs.add(nis / nis_dof);
}

bool is_shape_step(std::int64_t step) { return std::has_single_bit(static_cast<std::uint64_t>(step)); }

}  // namespace credence::internal
