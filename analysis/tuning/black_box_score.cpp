#include "analysis/tuning/black_box_score.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/linear_algebra/cholesky.h"

namespace credence::internal {
namespace {

constexpr Index kFewestUnits = 10;  // of an estimated covariance

}  // namespace

void ScoreSum::add(VectorRef nu, MatrixRef S, std::size_t sensor) {
  const Eigen::LLT<Matrix> llt(S);
  ok_ = ok_ && llt.info() == Eigen::Success && nu.allFinite();
  if (!ok_) return;
  const Vector u = llt.matrixL().solve(nu);
  add_normalised(u, 2.0 * llt.matrixLLT().diagonal().array().log().sum(), sensor);
}

void ScoreSum::add_normalised(VectorRef u, double log_determinant, std::size_t sensor) {
  const auto m = static_cast<double>(u.size());
  const double nis = u.squaredNorm();
  value_ -= 0.5 * (m * std::log(2.0 * std::numbers::pi) + nis + log_determinant);
  nis_ += nis;
  if (sensor >= before_.size()) before_.resize(sensor + 1);
  Vector& before = before_[sensor];
  if (before.size() == u.size()) lag_one_ += u.dot(before);
  steps_ += 1.0;
  dof_ += m;
  before = u;
  ok_ = ok_ && std::isfinite(value_);
}

UnitScores unit_scores(const std::vector<ScoreSum>& units) {
  UnitScores scores;
  scores.value = scores.nis = scores.lag_one = Vector::Zero(std::ssize(units));
  for (std::size_t i = 0; i < units.size(); ++i) {
    const ScoreSum& unit = units[i];
    const auto at = static_cast<Index>(i);
    scores.ok = scores.ok && unit.ok();
    scores.composite = scores.composite || unit.composite();
    scores.value[at] = unit.value();
    scores.nis[at] = unit.nis();
    scores.lag_one[at] = unit.lag_one();
    scores.steps += unit.steps();
    scores.dof += unit.dof();
  }
  scores.ok = scores.ok && scores.steps > 0.0;
  return scores;
}

BlackBoxScore::BlackBoxScore(std::vector<FilterFactor> factors, double resolution)
    : factors_(std::move(factors)), resolution_(resolution) {
  if (factors_.empty()) throw std::invalid_argument("there is nothing to tune");
  for (const FilterFactor& factor : factors_) {
    if (factor.start > 0.0 && std::isfinite(factor.start)) continue;
    throw std::invalid_argument(
        fmt::format("{} = {}: only what is positive has a factor", factor.name, factor.start));
  }
}

std::vector<std::string> BlackBoxScore::names() const {
  std::vector<std::string> names;
  for (const FilterFactor& factor : factors_) names.push_back(factor.name);
  return names;
}

std::vector<NoiseValue> BlackBoxScore::values(const Vector& phi) const {
  std::vector<NoiseValue> values;
  for (Index i = 0; i < parameters(); ++i) {
    const FilterFactor& factor = factors_[static_cast<std::size_t>(i)];
    const double value = factor.start * std::exp(phi[i]);
    values.push_back({factor.name, value, value * Vector::Unit(parameters(), i), true});
  }
  return values;
}

UnitScores BlackBoxScore::play_at(const Vector& phi) const {
  std::vector<double> factors;
  for (const NoiseValue& value : values(phi)) factors.push_back(value.value);
  UnitScores scores = play(factors);
  played_.finish();
  return scores;
}

UnitScores BlackBoxScore::scores(const Vector& phi, bool gradient) const {
  UnitScores scores = play_at(phi);
  if (!gradient) return scores;
  scores.gradient.resize(parameters(), units());
  for (Index i = 0; i < parameters() && scores.ok; ++i) {
    const Vector shift = resolution_ * Vector::Unit(parameters(), i);
    const UnitScores more = play_at(phi + shift), less = play_at(phi - shift);
    scores.ok = more.ok && less.ok;
    if (scores.ok) scores.gradient.row(i) = (more.value - less.value) / (2.0 * resolution_);
  }
  return scores;
}

Matrix BlackBoxScore::expected_information(const Vector& phi) const {
  if (units() < kFewestUnits) return {};
  const UnitScores there = scores(phi, true);
  if (!there.ok) return {};
  const Matrix centred = there.gradient.colwise() - there.gradient.rowwise().mean();
  const auto n = static_cast<double>(units());
  return n / (n - 1.0) * centred * centred.transpose();
}

}  // namespace credence::internal
