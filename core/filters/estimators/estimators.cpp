#include "core/filters/estimators/estimators.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/filters/estimators/ekf_estimator.h"
#include "core/filters/estimators/fej_estimator.h"
#include "core/filters/estimators/ideal_estimator.h"
#include "core/filters/estimators/invariant_estimator.h"
#include "core/filters/estimators/iterated_estimator.h"
#include "core/filters/estimators/oc_estimator.h"
#include "core/filters/estimators/ukf_estimator.h"

namespace credence {
namespace {

template <class Estimator>
std::unique_ptr<SlamEstimator> make(const EstimatorSettings& settings) {
  return std::make_unique<Estimator>(settings);
}

constexpr EstimatorKind kKinds[] = {
    {"ekf", "Jacobians at the newest estimates", make<EkfEstimator>},
    {"ideal", "Jacobians at the truth: the yardstick", make<IdealEstimator>},
    {"fej", "Jacobians at the first estimates", make<FejEstimator>},
    {"oc", "Jacobians at the nearest points that keep what is unobservable", make<OcEstimator>},
    {"invariant", "right-invariant error on SE(2) with the landmarks", make<InvariantEstimator>},
    {"iterated", "Gauss-Newton correction", make<IteratedEstimator>},
    {"ukf", "sigma points", make<UkfEstimator>},
};

}  // namespace

std::span<const EstimatorKind> estimator_kinds() { return kKinds; }

std::unique_ptr<SlamEstimator> make_estimator(std::string_view name, const EstimatorSettings& settings) {
  const auto found = std::ranges::find(kKinds, name, &EstimatorKind::name);
  if (found == std::end(kKinds))
    throw std::invalid_argument(fmt::format("no estimator is called \"{}\"", name));
  return found->make(settings);
}

}  // namespace credence
