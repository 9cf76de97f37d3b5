#include "analysis/laws/scores/proper_scores.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

void require_nees(double nees) {
  if (nees < 0.0) throw std::invalid_argument(fmt::format("nees = {} must be >= 0", nees));
}

/// Of the trapezoidal rule. In ln t the integrand is analytic and bounded for |Im ln t| < π/2, so the error
/// of a step h is e^{−π²/h}; beyond the ends the integrand is below 1e-16 of the whole.
struct Node {
  double t = 0.0, taken_off = 0.0, weight = 0.0;  ///< t, t/(1 + t), t^{−1/2}
};
constexpr double kStep = 0.3;

const std::array<Node, 207>& nodes() {
  static const std::array<Node, 207> all = [] {
    constexpr double kFirst = -25.0;
    std::array<Node, 207> made;
    for (std::size_t i = 0; i < made.size(); ++i) {
      const double t = std::exp(kFirst + kStep * static_cast<double>(i));
      made[i] = {t, t / (1.0 + t), 1.0 / std::sqrt(t)};
    }
    return made;
  }();
  return all;
}

// E√q of the header from E q and 1 − φ.
template <typename LessThanOne>
double mean_root(double mean, LessThanOne less_than_one) {
  if (mean == 0.0) return 0.0;
  double sum = 0.0;
  for (const Node& node : nodes()) sum += (less_than_one(node.t / mean) - node.taken_off) * node.weight;
  const double pi = boost::math::constants::pi<double>();
  return std::sqrt(mean) * (pi + kStep * sum) / (2.0 * std::sqrt(pi));
}

// 1 − φ is 1 − r + r (1 − e^{−w}), r = (1 + p)^{−1/2} with 1 + p the product of all 1 + 2 λ_j t: of numbers
// that are not negative, so that none of its digits is lost.
double mean_distance(const Vector& variances, const Vector& squared_offsets) {
  return mean_root(variances.sum() + squared_offsets.sum(), [&](double t) {
    double p = 0.0, w = 0.0;
    for (Index j = 0; j < variances.size(); ++j) {
      const double spread = 2.0 * t * variances[j];
      p += spread + spread * p;
      if (squared_offsets[j] > 0.0) w += t * squared_offsets[j] / (1.0 + spread);
    }
    const double root = std::sqrt(1.0 + p), r = 1.0 / root;
    const double of_offset = w > 0.0 ? -r * std::expm1(-w) : 0.0;
    return (p < 1.0 ? p * r / (1.0 + root) : 1.0 - r) + of_offset;
  });
}

}  // namespace

Score log_score(double nees, double log_determinant, double dof) {
  require_nees(nees);
  if (!(std::isfinite(dof) && dof >= 0.0)) {
    throw std::invalid_argument(fmt::format("dof = {} must be a finite number >= 0", dof));
  }
  const double constant = dof * std::log(boost::math::constants::two_pi<double>()) + log_determinant;
  return {.value = -0.5 * (constant + nees), .expected = -0.5 * (constant + dof)};
}

Score energy_score(VectorRef error, MatrixRef P) {
  if (P.rows() != error.size() || P.cols() != error.size()) {
    throw std::invalid_argument(
        fmt::format("P is {}x{} but the error has {} components", P.rows(), P.cols(), error.size()));
  }
  if (error.size() == 0) return {};
  if (!error.allFinite() || !P.allFinite()) return {.value = kNaN, .expected = kNaN};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(P);
  constexpr double kRounding = 1e-9;
  if (eigen.info() != Eigen::Success ||
      eigen.eigenvalues()[0] < -kRounding * std::abs(eigen.eigenvalues()[error.size() - 1])) {
    return {.value = kNaN, .expected = kNaN};
  }
  const Vector variances = eigen.eigenvalues().cwiseMax(0.0);
  const Vector squared_offsets = (eigen.eigenvectors().transpose() * error).cwiseAbs2();
  // X − X' ~ N(0, 2P).
  const double expected = mean_distance(variances, Vector::Zero(error.size())) / std::sqrt(2.0);
  return {.value = mean_distance(variances, squared_offsets) - expected, .expected = expected};
}

Score whitened_energy_score(double nees, double dof) {
  require_nees(nees);
  require_positive("dof", dof);
  if (std::isnan(nees)) return {.value = kNaN, .expected = kNaN};
  const double expected = boost::math::tgamma_delta_ratio(0.5 * (dof + 1.0), -0.5);
  if (std::isinf(nees)) return {.value = nees, .expected = expected};
  const double distance = mean_root(dof + nees, [&](double t) {
    return -std::expm1(-0.5 * dof * std::log1p(2.0 * t) - t * nees / (1.0 + 2.0 * t));
  });
  return {.value = distance - expected, .expected = expected};
}

}  // namespace credence::internal
