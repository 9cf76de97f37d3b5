#include "analysis/tuning/score_estimate.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {
namespace {

constexpr double kDifference = 1e-2;  // of the scales: the cubic term is 1e-4 of the curvature
constexpr int kMostNewtonSteps = 8;
constexpr double kGain = 1e-6;
constexpr int kMostHalvings = 6;        // of a Newton step
constexpr double kWorthHalving = 1e-2;  // decrement

std::vector<Index> numbers_of(const std::vector<bool>& free) {
  std::vector<Index> of;
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (free[i]) of.push_back(static_cast<Index>(i));
  }
  return of;
}

/// Gradient, curvature and covariance at estimate.phi; false where there are no scores.
bool measure_curve(const ScoreModel& model, const Vector& scale, ScoreEstimate& estimate) {
  const auto& free = estimate.free;
  const auto p = std::ssize(free);
  const UnitScores here = model.scores(estimate.phi, true);
  if (!here.ok) return false;
  estimate.value = here.sum();
  estimate.unit_scores = here.gradient(free, Eigen::all);
  estimate.information.resize(p, p);
  for (Index i = 0; i < p; ++i) {
    const Index coordinate = free[static_cast<std::size_t>(i)];
    const double h = std::max(kDifference * scale[coordinate], model.resolution());
    Vector phi = estimate.phi;
    Vector change = Vector::Zero(p);
    for (const double side : {1.0, -1.0}) {
      phi[coordinate] = estimate.phi[coordinate] + side * h;
      const UnitScores there = model.scores(phi, true);
      if (!there.ok) return false;
      const Vector sum = there.gradient.rowwise().sum();
      change += side * sum(free);
    }
    estimate.information.col(i) = -change / (2.0 * h);
  }
  symmetrise(estimate.information);
  const Eigen::LLT<Matrix> llt(estimate.information);
  estimate.covariance.resize(0, 0);
  if (p > 0 && llt.info() == Eigen::Success) {
    estimate.covariance = llt.solve(Matrix::Identity(p, p));
  }
  return true;
}

/// The estimate after a move, or a half, a quarter, … of it: the first that scores higher; nothing if none.
std::optional<ScoreEstimate> moved(const ScoreModel& model, const SearchBox& box, const Vector& scale,
                                   const ScoreEstimate& from, const Vector& move) {
  double share = 1.0;
  for (int halving = 0; halving <= kMostHalvings; ++halving, share *= 0.5) {
    ScoreEstimate next = from;
    for (std::size_t i = 0; i < next.free.size(); ++i) {
      const Index c = next.free[i];
      const double to = next.phi[c] + share * move[static_cast<Index>(i)];
      next.phi[c] = std::clamp(to, box.lower[c], box.upper[c]);
    }
    if (halving > 0) {
      const UnitScores there = model.scores(next.phi, false);
      if (!there.ok || there.sum() <= from.value) continue;
    }
    if (measure_curve(model, scale, next) && next.value > from.value) return next;
    if (from.decrement < kWorthHalving) break;
  }
  return std::nullopt;
}

}  // namespace

Matrix ScoreEstimate::sandwich() const {
  return covariance * (unit_scores * unit_scores.transpose()) * covariance;
}

ScoreEstimate estimate_score(const ScoreModel& model, const Vector& start, const SearchBox& box,
                             const std::vector<bool>& free, const Vector& scale) {
  const Maximum maximum = maximise(model, start, box, free, scale);
  ScoreEstimate estimate{.phi = maximum.phi, .value = maximum.value, .free = numbers_of(free)};
  estimate.ok = maximum.ok && measure_curve(model, scale, estimate);
  for (int step = 0; estimate.ok && step < kMostNewtonSteps; ++step) {
    if (estimate.covariance.size() == 0) return estimate;
    const Vector gradient = estimate.unit_scores.rowwise().sum();
    const Vector move = estimate.covariance * gradient;
    estimate.decrement = gradient.dot(move);
    if (estimate.decrement < kGain) return estimate;
    std::optional<ScoreEstimate> next = moved(model, box, scale, estimate, move);
    if (!next) return estimate;
    estimate = std::move(*next);
  }
  return estimate;
}

Maximum profile_score(const ScoreModel& model, Vector start, const SearchBox& box, std::vector<bool> free,
                      const Vector& scale, Index coordinate, double value) {
  start[coordinate] = value;
  free[static_cast<std::size_t>(coordinate)] = false;
  if (!model.has_gradient()) return maximise(model, start, box, free, scale);
  // A search that ends early would end the limits as well.
  ScoreEstimate there = estimate_score(model, start, box, free, scale);
  return {.phi = std::move(there.phi), .value = there.value, .ok = there.ok};
}

ProfileLimits profile_limits(const ScoreModel& model, const ScoreEstimate& estimate, const SearchBox& box,
                             const std::vector<bool>& free, const Vector& scale, Index coordinate,
                             double drop) {
  constexpr double kClose = 1e-3, kShortest = 0.05, kLongest = 2.0;  // of φ
  constexpr double kNoScore = 10.0;
  const double top = estimate.phi[coordinate];
  double reach = 0.5;  // to the limit, of a parabola
  if (estimate.covariance.size() > 0) {
    const Index at = std::ranges::find(estimate.free, coordinate) - estimate.free.begin();
    reach = std::clamp(std::sqrt(2.0 * drop * estimate.covariance(at, at)), kShortest, kLongest);
  }
  const auto limit = [&](double side, double end) {
    Vector others = estimate.phi;
    /// Negative within the limits; of a parabola a straight line.
    const auto excess = [&](double value) {
      Maximum there = profile_score(model, others, box, free, scale, coordinate, value);
      const auto drops = [&] { return std::sqrt(std::max(0.0, estimate.value - there.value) / drop) - 1.0; };
      if ((!there.ok || drops() > 0.0) && others != estimate.phi) {
        Maximum again = profile_score(model, estimate.phi, box, free, scale, coordinate, value);
        if (again.ok && (!there.ok || again.value > there.value)) there = std::move(again);
      }
      if (!there.ok) return kNoScore;
      others = there.phi;
      return drops();
    };
    double inside = top, within = -1.0, outside = top, beyond = -1.0, step = 1.1 * reach;
    while (beyond < 0.0) {
      inside = outside;
      within = beyond;
      if (side * inside >= side * end) return side * std::numeric_limits<double>::infinity();
      outside = side > 0.0 ? std::min(inside + step, end) : std::max(inside - step, end);
      beyond = excess(outside);
      step = std::max(0.5, 1.5 * step);
    }
    if (side < 0.0) {
      std::swap(inside, outside);
      std::swap(within, beyond);
    }
    std::uintmax_t evaluations = 30;
    const auto near = [](double low, double high) { return high - low < kClose; };
    const auto [low, high] =
        boost::math::tools::toms748_solve(excess, inside, outside, within, beyond, near, evaluations);
    return 0.5 * (low + high);
  };
  return {limit(-1.0, box.lower[coordinate]), limit(1.0, box.upper[coordinate])};
}

}  // namespace credence::internal
