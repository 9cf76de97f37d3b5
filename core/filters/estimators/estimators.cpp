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

constexpr EstimatorKind kKinds[] = {
    {"ekf", "Jacobians at the newest estimates", make<EkfEstimator>, assign<EkfEstimator>},
    {"ideal", "Jacobians at the truth: the yardstick", make<IdealEstimator>, assign<IdealEstimator>},
    {"fej", "Jacobians at the first estimates", make<FejEstimator>, assign<FejEstimator>},
    {"oc", "Jacobians at the nearest points that keep what is unobservable", make<OcEstimator>,
     assign<OcEstimator>},
    {"invariant", "right-invariant error on SE(2) with the landmarks", make<InvariantEstimator>,
     assign<InvariantEstimator>},
    {"invariant-left", "left-invariant error", make<InvariantEstimator, InvariantReset::left>,
     assign<InvariantEstimator>},
    {"invariant-reset", "invariant error, left or right, P moved to the chart of the new estimate",
     make<InvariantEstimator, InvariantReset::full>, assign<InvariantEstimator>},
    {"iterated", "Gauss-Newton correction", make<IteratedEstimator>, assign<IteratedEstimator>},
    {"ukf", "sigma points", make<UkfEstimator>, assign<UkfEstimator>},
    {"ukf-manifold", "sigma points of the right-invariant error", make<UkfManifoldEstimator>,
     assign<UkfManifoldEstimator>},
    {"ukf-manifold-left", "sigma points of the left-invariant error",
     make<UkfManifoldEstimator, InvariantReset::left>, assign<UkfManifoldEstimator>},
    {"schmidt", "EKF that only considers landmarks after some observations", make<SchmidtEstimator>,
     assign<SchmidtEstimator>},
    {"intersection", "split covariance intersection, no correlations kept", make<IntersectionEstimator>,
     assign<IntersectionEstimator>},
    {"smoother", "Gauss-Newton over a sliding window, marginalised", make<SmootherEstimator>,
     assign<SmootherEstimator>},
    {"smoother-fej", "the same with first-estimate Jacobians", make<SmootherEstimator, true>,
     assign<SmootherEstimator>},
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
