#include "analysis/tuning/linear_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr Index kRunsOfScoreTask = 16;

}  // namespace

LinearScore::LinearScore(NoiseParameters parameters, std::vector<MeasuredRun> runs, int threads,
                         const std::atomic<bool>* stop)
    : parameters_(std::move(parameters)),
      runs_(std::move(runs)),
      threads_(threads),
      stop_(stop),
      stretches_(1) {
  if (runs_.empty() || runs_.front().z.cols() == 0) throw std::invalid_argument("there is nothing measured");
  const LinearModel& model = parameters_.model();
  for (const MeasuredRun& run : runs_) {
    if (run.start.size() != model.state_dim() || run.z.rows() != model.measurement_dim() ||
        run.z.cols() != steps()) {
      throw std::invalid_argument(fmt::format(
          "a run of {} measurements of {} components and a start of {} for a model of {}, {} and {}",
          run.z.cols(), run.z.rows(), run.start.size(), steps(), model.measurement_dim(), model.state_dim()));
    }
  }
  const Index count = std::ssize(runs_);
  if (count < kFewestUnits) stretches_ = std::min(steps(), (kFewestUnits + count - 1) / count);
}

UnitScores LinearScore::scores(const Vector& phi, bool gradient) const {
  const auto derivatives = gradient ? parameters_.derivatives(phi) : std::vector<NoiseDerivative>{};
  const StopScope scope(stop_);
  const InnovationSensitivities filter(parameters_.at(phi), derivatives, steps());
  UnitScores scores;
  scores.ok = filter.ok();
  if (!scores.ok) return scores;
  scores.value = scores.nis = scores.lag_one = Vector::Zero(units());
  scores.gradient = Matrix::Zero(filter.parameters(), units());
  scores.steps = static_cast<double>(runs() * steps());
  scores.dof = scores.steps * static_cast<double>(parameters_.model().measurement_dim());
  const std::int64_t tasks = (runs() + kRunsOfScoreTask - 1) / kRunsOfScoreTask;
  for_each_task(tasks, tasks == 1 ? 1 : threads_, stop_, [&](std::int64_t task) {
    score_runs(filter, task * kRunsOfScoreTask, scores);
    played_.add_part_of(tasks);
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  played_.finish();
  scores.ok = scores.value.allFinite() && scores.gradient.allFinite();
  return scores;
}

void LinearScore::score_runs(const InnovationSensitivities& filter, Index first, UnitScores& scores) const {
  using Runs = Eigen::Matrix<double, kRunsOfScoreTask, Eigen::Dynamic>;  // a row for each run
  using OfRuns = Eigen::Array<double, kRunsOfScoreTask, 1>;
  const LinearModel& model = parameters_.model();
  const Index n = model.state_dim(), m = model.measurement_dim(), p = filter.parameters();
  const Index count = std::min(kRunsOfScoreTask, runs() - first);
  const auto data =
      std::span(runs_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
  const double constant = static_cast<double>(m) * std::log(2.0 * std::numbers::pi);
  const auto inner = [](const auto& a, const auto& b) {
    return OfRuns((a.array() * b.array()).rowwise().sum());
  };
  Runs start = Runs::Zero(kRunsOfScoreTask, n), z = Runs::Zero(kRunsOfScoreTask, m);
  for (Index run = 0; run < count; ++run)
    start.row(run) = data[static_cast<std::size_t>(run)].start.transpose();
  Runs x = start.lazyProduct(model.F.transpose()), x_next = x;
  Runs nu = z, u = z, whitened = z, before = z, S_dot_u = z, nu_dot = z;
  Runs x_dot = Runs::Zero(kRunsOfScoreTask, n * p), x_dot_next = x_dot;
  for (Index k = 0; k < steps(); ++k) {
    const InnovationStep& step = filter.step(k);
    for (Index run = 0; run < count; ++run)
      z.row(run) = data[static_cast<std::size_t>(run)].z.col(k).transpose();
    const Index stretch = k * stretches_ / steps();
    const auto add = [&, this](const OfRuns& values, auto&& to) {
      for (Index run = 0; run < count; ++run) to((first + run) * stretches_ + stretch) += values[run];
    };
    nu = z;
    nu.noalias() -= x.lazyProduct(model.H.transpose());
    u.noalias() = nu.lazyProduct(step.S_inverse.transpose());
    const OfRuns nis = inner(nu, u);
    add(-0.5 * (constant + step.log_determinant + nis), scores.value);
    add(nis, scores.nis);
    x_next.noalias() = x.lazyProduct(model.F.transpose());
    x_next.noalias() += nu.lazyProduct(step.FK.transpose());
    x.swap(x_next);
    if (p == 0) {
      whitened.noalias() = nu.lazyProduct(step.S_root_inverse.transpose());
      if (k > 0) add(inner(whitened, before), scores.lag_one);
      before.swap(whitened);
      continue;
    }
    for (Index i = 0; i < p; ++i) {
      const auto of_i = x_dot.middleCols(i * n, n);
      S_dot_u.noalias() = u.lazyProduct(step.S_dot[static_cast<std::size_t>(i)].transpose());
      nu_dot.noalias() = -of_i.lazyProduct(model.H.transpose());
      add(0.5 * (inner(u, S_dot_u) - step.trace[i]) - inner(u, nu_dot), scores.gradient.row(i));
      auto next = x_dot_next.middleCols(i * n, n);
      next.noalias() = of_i.lazyProduct(step.closed.transpose());
      next.noalias() += nu.lazyProduct(step.FK_dot.middleRows(i * n, n).transpose());
    }
    x_dot.swap(x_dot_next);
  }
}

Matrix LinearScore::expected_information(const Vector& phi) const {
  const InnovationSensitivities filter(parameters_.at(phi), parameters_.derivatives(phi), steps());
  if (!filter.ok()) return Matrix::Zero(parameters(), parameters());
  return static_cast<double>(runs()) * filter.expected_information(steps());
}

}  // namespace credence::internal
