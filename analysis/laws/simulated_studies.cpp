#include "analysis/laws/simulated_studies.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

/// Of this skewness and deviation.
boost::random::gamma_distribution<double> gamma_law(double deviation, double skewness) {
  require_positive("deviation", deviation);
  require_positive("skewness", skewness);
  const double shape = 4.0 / (skewness * skewness);
  return boost::random::gamma_distribution<double>(shape, deviation / std::sqrt(shape));
}

}  // namespace

SimulatedStudies::SimulatedStudies(int studies, double deviation, double skewness)
    : studies_(static_cast<std::size_t>(studies)), gamma_(gamma_law(deviation, skewness)) {
  require_positive("studies", studies);
  shift_ = 1.0 - gamma_.alpha() * gamma_.beta();
}

std::span<const SkewedMoments> SimulatedStudies::of_runs(std::int64_t runs) {
  require_positive("runs", static_cast<double>(runs));
  const std::size_t end = static_cast<std::size_t>(runs) * studies_;
  if (moments_.empty()) moments_.resize(studies_);
  while (moments_.size() < studies_ + end) {
    SkewedMoments moments = moments_[moments_.size() - studies_];
    moments.add(std::max(0.0, shift_ + gamma_(bits_)));
    moments_.push_back(moments);
  }
  return std::span(moments_).subspan(end, studies_);
}

}  // namespace credence::internal
