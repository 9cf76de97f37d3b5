#include <cmath>

#include "analysis/tuning/tuning.h"
#include "core/linear_algebra/cholesky.h"

namespace credence::internal {
namespace {

constexpr double kDependent = 1e-9;

/// The part of the information of each coordinate that those before it in `chosen` do not hold.
double own_share(const Matrix& information, const std::vector<Index>& chosen, Index candidate) {
  if (chosen.empty()) return 1.0;
  const Matrix among = information(chosen, chosen);
  const Vector across = information(chosen, candidate);
  const Eigen::LLT<Matrix> llt(among);
  return 1.0 - across.dot(llt.solve(across)) / information(candidate, candidate);
}

}  // namespace

TuningForecast forecast_tuning(const ScoreModel& model, const Vector& start, double steps) {
  TuningForecast forecast;
  forecast.steps = steps;
  forecast.information = model.expected_information(start);
  for (const std::string& name : model.names()) forecast.parameters.push_back({.name = name});
  const Matrix& I = forecast.information;
  if (I.size() == 0) {
    for (auto& parameter : forecast.parameters) parameter.identifiable = true;
    return forecast;
  }
  // Greedy: each time the one that adds the most information of its own.
  std::vector<Index> chosen;
  while (true) {
    Index best = -1;
    double most = 0.0;
    for (Index i = 0; i < I.rows(); ++i) {
      if (!(I(i, i) > 0.0) || forecast.parameters[static_cast<std::size_t>(i)].identifiable) continue;
      const double share = own_share(I, chosen, i);
      if (share <= kDependent || share * I(i, i) <= most) continue;
      best = i;
      most = share * I(i, i);
    }
    if (best < 0) break;
    forecast.parameters[static_cast<std::size_t>(best)].identifiable = true;
    chosen.push_back(best);
  }
  for (std::size_t i = 0; i < forecast.parameters.size(); ++i) {
    auto& parameter = forecast.parameters[i];
    const auto at = static_cast<Index>(i);
    if (parameter.identifiable) continue;
    parameter.reason = I(at, at) > 0.0 ? "it cannot be told from a combination of the others"
                                       : "it has no effect on the innovations";
  }
  if (chosen.empty()) return forecast;
  const Matrix among = I(chosen, chosen);
  const Matrix covariance = Eigen::LLT<Matrix>(among).solve(Matrix::Identity(among.rows(), among.cols()));
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const double variance = covariance(static_cast<Index>(i), static_cast<Index>(i));
    auto& parameter = forecast.parameters[static_cast<std::size_t>(chosen[i])];
    parameter.relative_error = std::sqrt(variance);
    parameter.steps_for_10_percent = steps * variance / 0.01;
  }
  return forecast;
}

}  // namespace credence::internal
