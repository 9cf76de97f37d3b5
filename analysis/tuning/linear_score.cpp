#include "analysis/tuning/linear_score.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kRunsOfScoreTask = 16;

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
    const Index end = std::min(runs(), Index{(task + 1) * kRunsOfScoreTask});
    for (Index run = task * kRunsOfScoreTask; run < end; ++run) score_run(filter, run, scores);
    played_.add_part_of(tasks);
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  played_.finish();
  scores.ok = scores.value.allFinite() && scores.gradient.allFinite();
  return scores;
}

void LinearScore::score_run(const InnovationSensitivities& filter, Index run, UnitScores& scores) const {
  const LinearModel& model = parameters_.model();
  const Index n = model.state_dim(), m = model.measurement_dim(), p = filter.parameters();
  const MeasuredRun& data = runs_[static_cast<std::size_t>(run)];
  const double constant = static_cast<double>(m) * std::log(2.0 * std::numbers::pi);
  Vector x = model.F * data.start, x_next(n), nu(m), u(m), whitened(m), before(m), S_dot_u(m), moved(n * p);
  Matrix x_dot = Matrix::Zero(n, p), x_dot_next(n, p), nu_dot(m, p);
  for (Index k = 0; k < steps(); ++k) {
    const InnovationStep& step = filter.step(k);
    const Index unit = run * stretches_ + k * stretches_ / steps();
    nu.noalias() = data.z.col(k) - model.H * x;
    u.noalias() = step.S_inverse * nu;
    const double nis = nu.dot(u);
    scores.value[unit] -= 0.5 * (constant + step.log_determinant + nis);
    scores.nis[unit] += nis;
    x_next.noalias() = model.F * x;
    x_next.noalias() += step.FK * nu;
    x.swap(x_next);
    if (p == 0) {
      whitened.noalias() = step.S_root_inverse * nu;
      if (k > 0) scores.lag_one[unit] += whitened.dot(before);
      before.swap(whitened);
      continue;
    }
    nu_dot.noalias() = -model.H * x_dot;
    for (Index i = 0; i < p; ++i) {
      S_dot_u.noalias() = step.S_dot[static_cast<std::size_t>(i)] * u;
      scores.gradient(i, unit) += 0.5 * (u.dot(S_dot_u) - step.trace[i]) - u.dot(nu_dot.col(i));
    }
    moved.noalias() = step.FK_dot * nu;
    x_dot_next.noalias() = step.closed * x_dot;
    x_dot_next += Eigen::Map<const Matrix>(moved.data(), n, p);
    x_dot.swap(x_dot_next);
  }
}

Matrix LinearScore::expected_information(const Vector& phi) const {
  const InnovationSensitivities filter(parameters_.at(phi), parameters_.derivatives(phi), steps());
  if (!filter.ok()) return Matrix::Zero(parameters(), parameters());
  return static_cast<double>(runs()) * filter.expected_information(steps());
}

}  // namespace credence::internal
