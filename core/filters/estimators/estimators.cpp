#include "core/filters/estimators/estimators.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/filters/estimators/ekf_estimator.h"
#include "core/filters/estimators/fej_estimator.h"
#include "core/filters/estimators/ideal_estimator.h"
#include "core/filters/estimators/intersection_estimator.h"
#include "core/filters/estimators/invariant_estimator.h"
#include "core/filters/estimators/iterated_estimator.h"
#include "core/filters/estimators/oc_estimator.h"
#include "core/filters/estimators/schmidt_estimator.h"
#include "core/filters/estimators/smoother_estimator.h"
#include "core/filters/estimators/ukf_estimator.h"
#include "core/filters/estimators/ukf_manifold_estimator.h"

namespace credence::internal {
namespace {

template <class Estimator, auto... kOptions>
std::unique_ptr<SlamEstimator> make(const EstimatorSettings& settings) {
  return std::make_unique<Estimator>(settings, kOptions...);
}

template <class Estimator>
void assign(SlamEstimator& to, const SlamEstimator& from) {
  static_cast<Estimator&>(to) = static_cast<const Estimator&>(from);
}

template <class Estimator, auto... kOptions>
constexpr EstimatorKind kind(std::string_view name, std::string_view meaning) {
  return {name, meaning, make<Estimator, kOptions...>, assign<Estimator>};
}

constexpr EstimatorKind kKinds[] = {
    kind<EkfEstimator>("ekf", "Jacobians at the newest estimates"),
    kind<IdealEstimator>("ideal", "Jacobians at the truth: the yardstick"),
    kind<FejEstimator>("fej", "Jacobians at the first estimates"),
    kind<OcEstimator>("oc", "Jacobians at the nearest points that keep what is unobservable"),
    kind<InvariantEstimator>("invariant", "right-invariant error on SE(2) with the landmarks"),
    kind<InvariantEstimator, InvariantReset::left>("invariant-left", "left-invariant error"),
    kind<InvariantEstimator, InvariantReset::full>(
        "invariant-reset", "invariant error, left or right, P moved to the chart of the new estimate"),
    kind<IteratedEstimator>("iterated", "Gauss-Newton correction"),
    kind<UkfEstimator>("ukf", "sigma points"),
    kind<UkfManifoldEstimator>("ukf-manifold", "sigma points of the right-invariant error"),
    kind<UkfManifoldEstimator, InvariantReset::left>("ukf-manifold-left",
                                                     "sigma points of the left-invariant error"),
    kind<SchmidtEstimator>("schmidt", "EKF that only considers landmarks after some observations"),
    kind<IntersectionEstimator>("intersection", "split covariance intersection, no correlations kept"),
    kind<SmootherEstimator>("smoother", "Gauss-Newton over a sliding window, marginalised"),
    kind<SmootherEstimator, true>("smoother-fej", "the same with first-estimate Jacobians"),
};

}  // namespace

std::span<const EstimatorKind> estimator_kinds() { return kKinds; }

const EstimatorKind& estimator_kind(std::string_view name) {
  const auto found = std::ranges::find(kKinds, name, &EstimatorKind::name);
  if (found == std::end(kKinds))
    throw std::invalid_argument(fmt::format("no estimator is called \"{}\"", name));
  return *found;
}

std::unique_ptr<SlamEstimator> make_estimator(std::string_view name, const EstimatorSettings& settings) {
  return estimator_kind(name).make(settings);
}

}  // namespace credence::internal
