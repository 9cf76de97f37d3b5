#include "analysis/tuning/filter_score.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/linear_algebra/cholesky.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence {
namespace {

constexpr double kFactorDifference = 0.02;  // of φ: the score is smooth, and its rounding far below
constexpr Index kFewestUnits = 10;          // of an estimated covariance

/// The sums of one run.
struct PlayedRun {
  double value = 0.0, nis = 0.0, lag_one = 0.0, steps = 0.0, dof = 0.0;
  Vector before{};  ///< normalised, of the last step with one
  bool ok = true;

  void add(const Vector& nu, const Matrix& S) {
    const Eigen::LLT<Matrix> llt(S);
    ok = ok && llt.info() == Eigen::Success && nu.allFinite();
    if (!ok) return;
    Vector u = llt.matrixL().solve(nu);
    const auto m = static_cast<double>(nu.size());
    value -= 0.5 * (m * std::log(2.0 * std::numbers::pi) + u.squaredNorm()) +
             llt.matrixLLT().diagonal().array().log().sum();
    nis += u.squaredNorm();
    if (before.size() == u.size()) lag_one += u.dot(before);
    steps += 1.0;
    dof += m;
    before = std::move(u);
  }
};

}  // namespace

FilterScore::FilterScore(std::vector<FilterFactor> factors, Make make, std::int64_t runs, int threads,
                         const std::atomic<bool>* stop)
    : factors_(std::move(factors)), make_(std::move(make)), runs_(runs), threads_(threads), stop_(stop) {
  if (runs_ < 1 || factors_.empty()) throw std::invalid_argument("there is nothing to tune, or no run");
  for (const FilterFactor& factor : factors_) {
    if (factor.start > 0.0 && std::isfinite(factor.start)) continue;
    throw std::invalid_argument(
        fmt::format("{} = {}: only what is positive has a factor", factor.name, factor.start));
  }
}

std::vector<std::string> FilterScore::names() const {
  std::vector<std::string> names;
  for (const FilterFactor& factor : factors_) names.push_back(factor.name);
  return names;
}

std::vector<NoiseValue> FilterScore::values(const Vector& phi) const {
  std::vector<NoiseValue> values;
  for (Index i = 0; i < parameters(); ++i) {
    const FilterFactor& factor = factors_[static_cast<std::size_t>(i)];
    const double value = factor.start * std::exp(phi[i]);
    values.push_back({factor.name, value, value * Vector::Unit(parameters(), i), true});
  }
  return values;
}

UnitScores FilterScore::play(const Vector& phi) const {
  std::vector<double> values;
  for (const NoiseValue& value : this->values(phi)) values.push_back(value.value);
  const std::unique_ptr<Experiment> experiment = make_(values);
  std::vector<PlayedRun> runs(static_cast<std::size_t>(runs_));
  for_each_task(runs_, threads_, stop_, [&](std::int64_t i) {
    PlayedRun& run = runs[static_cast<std::size_t>(i)];
    const Outcome outcome = experiment->visit(i, [&](const TraceStep& step) {
      for (const Innovation& innovation : step.innovations) {
        if (step.step > 0 && innovation.nu.size() > 0) run.add(innovation.nu, innovation.S);
      }
    });
    run.ok = run.ok && outcome == Outcome::ok;
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  UnitScores scores;
  scores.value = scores.nis = scores.lag_one = Vector::Zero(runs_);
  for (Index i = 0; i < runs_; ++i) {
    const PlayedRun& run = runs[static_cast<std::size_t>(i)];
    scores.ok = scores.ok && run.ok && std::isfinite(run.value);
    scores.value[i] = run.value;
    scores.nis[i] = run.nis;
    scores.lag_one[i] = run.lag_one;
    scores.steps += run.steps;
    scores.dof += run.dof;
  }
  scores.ok = scores.ok && scores.steps > 0.0;
  return scores;
}

UnitScores FilterScore::scores(const Vector& phi, bool gradient) const {
  UnitScores scores = play(phi);
  if (!gradient) return scores;
  scores.gradient.resize(parameters(), runs_);
  for (Index i = 0; i < parameters() && scores.ok; ++i) {
    const Vector shift = kFactorDifference * Vector::Unit(parameters(), i);
    const UnitScores more = play(phi + shift), less = play(phi - shift);
    scores.ok = more.ok && less.ok;
    if (scores.ok) scores.gradient.row(i) = (more.value - less.value) / (2.0 * kFactorDifference);
  }
  return scores;
}

Matrix FilterScore::expected_information(const Vector& phi) const {
  if (runs_ < kFewestUnits) return {};
  const UnitScores there = scores(phi, true);
  if (!there.ok) return {};
  const Matrix centred = there.gradient.colwise() - there.gradient.rowwise().mean();
  const auto units = static_cast<double>(runs_);
  return units / (units - 1.0) * centred * centred.transpose();
}

}  // namespace credence
