#include "analysis/tuning/score_shape.h"

#include <algorithm>
#include <cmath>

namespace credence::internal {
namespace {

std::vector<double> evenly(double low, double high, int points) {
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(points));
  for (int i = 0; i < points; ++i) all.push_back(low + (high - low) * i / (points - 1));
  return all;
}

}  // namespace

ScoreProfile score_profile(const ScoreModel& model, const Tuning& tuning, Index coordinate, int points,
                           double reach) {
  const ScoreEstimate& e = tuning.estimate;
  const auto found = std::ranges::find(e.free, coordinate);
  const Index at = found - e.free.begin();
  std::vector<bool> free(static_cast<std::size_t>(tuning.phi.size()), false);
  Vector scale = Vector::Ones(tuning.phi.size());
  for (std::size_t i = 0; i < e.free.size(); ++i) {
    const auto j = static_cast<Index>(i);
    free[static_cast<std::size_t>(e.free[i])] = true;
    scale[e.free[i]] = 1.0 / std::sqrt(e.information(j, j));
  }
  const double deviation = std::sqrt(e.covariance(at, at));
  // The others follow along the regression on this one.
  const Vector slope = e.covariance.col(at) / e.covariance(at, at);
  const SearchBox box{tuning.phi.array() - 20.0, tuning.phi.array() + 20.0};
  ScoreProfile profile;
  for (const double shift : evenly(-reach * deviation, reach * deviation, points)) {
    Vector start = tuning.phi;
    for (std::size_t i = 0; i < e.free.size(); ++i) start[e.free[i]] += shift * slope[static_cast<Index>(i)];
    const double value = tuning.phi[coordinate] + shift;
    const Maximum there = profile_score(model, start, box, free, scale, coordinate, value);
    profile.phi.push_back(value);
    profile.drop.push_back(there.ok ? e.value - there.value : kNaN);
  }
  return profile;
}

std::vector<RidgePoint> nis_ridge(const ScoreModel& model, const Tuning& tuning, Index first, Index second,
                                  const std::vector<double>& shifts) {
  constexpr double kRidgeTolerance = 1e-6;
  constexpr int kRidgeHalvings = 40;
  const double reach = std::log(1e4);
  std::vector<RidgePoint> ridge;
  for (const double shift : shifts) {
    Vector phi = tuning.phi;
    phi[first] += shift;
    double low = phi[second] - reach, high = phi[second] + reach;
    const auto excess = [&](double value) {
      phi[second] = value;
      const UnitScores scores = model.scores(phi, false);
      return scores.ok ? scores.mean_nis() / tuning.dof - 1.0 : kNaN;
    };
    if (!(excess(low) > 0.0) || !(excess(high) < 0.0)) continue;
    for (int i = 0; i < kRidgeHalvings && high - low > kRidgeTolerance; ++i) {
      const double middle = 0.5 * (low + high);
      (excess(middle) > 0.0 ? low : high) = middle;
    }
    phi[second] = 0.5 * (low + high);
    const UnitScores scores = model.scores(phi, false);
    ridge.push_back({phi, scores.lag_one_correlation(), tuning.estimate.value - scores.sum()});
  }
  return ridge;
}

ScoreSurface score_surface(const ScoreModel& model, const Tuning& tuning, Index first, Index second,
                           double reach, int points) {
  ScoreSurface surface{.first = first,
                       .second = second,
                       .first_phi = evenly(tuning.phi[first] - reach, tuning.phi[first] + reach, points),
                       .second_phi = evenly(tuning.phi[second] - reach, tuning.phi[second] + reach, points),
                       .drop = Matrix::Constant(points, points, kNaN)};
  Vector phi = tuning.phi;
  for (Index i = 0; i < points; ++i) {
    for (Index j = 0; j < points; ++j) {
      phi[first] = surface.first_phi[static_cast<std::size_t>(j)];
      phi[second] = surface.second_phi[static_cast<std::size_t>(i)];
      const UnitScores scores = model.scores(phi, false);
      if (scores.ok) surface.drop(i, j) = (tuning.estimate.value - scores.sum()) / scores.steps;
    }
  }
  return surface;
}

}  // namespace credence::internal
