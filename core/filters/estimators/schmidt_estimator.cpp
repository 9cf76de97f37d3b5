#include "core/filters/estimators/schmidt_estimator.h"

#include <algorithm>
#include <stdexcept>

namespace credence::internal {

SchmidtEstimator::SchmidtEstimator(const EstimatorSettings& settings)
    : EkfEstimator(settings), observations_(static_cast<std::size_t>(settings.landmarks)) {
  if (settings.active_sights < 0)
    throw std::invalid_argument("a number of observations must not be negative");
}

void SchmidtEstimator::started() { std::ranges::fill(observations_, 0); }

void SchmidtEstimator::linearise(const PlanarTruth& truth) {
  for (std::size_t i = 3; i < seen().size(); i += 2)
    ++observations_[static_cast<std::size_t>(seen()[i] - 3) / 2];
  EkfEstimator::linearise(truth);
}

void SchmidtEstimator::apply(Eigen::Map<Matrix>& W, Eigen::Map<Vector>& delta) {
  const Index n = size();
  for (Index j = 0; j < n; ++j) {
    const bool considered = is_considered(j);
    for (Index i = j; i < n; ++i) {
      if (considered && is_considered(i)) continue;
      P()(i, j) -= W.row(i).dot(W.row(j));
    }
  }
  for (Index i = 3; i < n; ++i) {
    if (!is_considered(i)) continue;
    delta[i] = 0.0;
    W.row(i).setZero();  // its gain
  }
}

}  // namespace credence::internal
