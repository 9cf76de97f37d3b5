#include "datasets/logs/conventions/step_conventions.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/manifold/angle.h"
#include "datasets/logs/conventions/reading_fit.h"
#include "datasets/logs/conventions/thinned.h"

namespace credence::internal {
namespace {

struct StepReading {
  std::string cause;
  std::function<void(Matrix& P)> change;
};

/// P_ij ← d_i P_ij d_j with d = factor in one state, or in all of those.
auto scaled(std::vector<Index> states, double factor) {
  return [states = std::move(states), factor](Matrix& P) {
    for (const Index i : states) {
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  };
}

std::vector<StepReading> step_readings(const RunLayout& layout) {
  std::vector<StepReading> list = {
      {"P holds standard deviations, not variances (square them)",
       [](Matrix& P) { P = P.cwiseProduct(P.cwiseAbs()).eval(); }},
      {"P is the information matrix (invert it)",
       [](Matrix& P) { P = P.llt().solve(Matrix::Identity(P.rows(), P.cols())).eval(); }},
  };
  std::vector<Index> angles;
  const auto add_degrees = [&](const std::string& what, const std::vector<Index>& states) {
    list.push_back({fmt::format("P is in degrees in {}, the error in radians", what),
                    scaled(states, kRadiansPerDegree)});
    list.push_back({fmt::format("the error is in degrees in {}, P in radians", what),
                    scaled(states, 1.0 / kRadiansPerDegree)});
  };
  for (std::size_t i = 0; i < layout.angles.size(); ++i) {
    if (!layout.angles[i]) continue;
    angles.push_back(static_cast<Index>(i));
    add_degrees(layout.states[i], {static_cast<Index>(i)});
  }
  if (angles.size() > 1) add_degrees("all angles", angles);
  return list;
}

}  // namespace

void StepConventions::begin_run(const RunLayout& layout) {
  layout_ = layout;
  ForwardingSink::begin_run(layout);
}

void StepConventions::add(const Step& step) {
  constexpr std::size_t kMostStates = 12;
  ForwardingSink::add(step);
  const std::size_t n = layout_.states.size();
  if (!step.problem.empty() || n == 0 || n > kMostStates || step.states.size() != n) return;
  if (keep_thinned(rows_, stride_, seen_)) {
    Matrix& row = rows_.emplace_back(step.error.size(), step.error.size() + 1);
    row << step.P, step.error;
  }
}

void StepConventions::finish() {
  if (rows_.size() < kFewestForReading || !layout_.joint_covariance) return;
  const auto n = static_cast<Index>(layout_.states.size());
  const auto rows_changed_by = [&](const std::function<void(Matrix&)>& change) -> ReadingRow {
    return [&](std::size_t i, Vector& error, Matrix& P) {
      if (rows_[i].rows() != n) return false;
      error = rows_[i].col(n);
      P = rows_[i].leftCols(n);
      change(P);
      return true;
    };
  };
  const ReadingFit declared = fit_reading(rows_.size(), n, {}, rows_changed_by([](Matrix&) {}));
  if (!declared.misfits()) return;
  std::optional<ReadingFit> best;
  std::string cause;
  for (const StepReading& reading : step_readings(layout_)) {
    const auto found = fitting_reading(rows_.size(), n, {}, rows_changed_by(reading.change));
    if (!found || (best && best->log_likelihood >= found->log_likelihood)) continue;
    best = found;
    cause = reading.cause;
  }
  if (!best) return unexplained();
  hint(
      fmt::format("The covariance does not fit as it is read ({}). It would fit if {} (mean NEES {:.4g}). "
                  "Whether it is so, the log cannot say: look at the program that wrote it.",
                  misfit_text(declared, n), cause, best->nees));
}

}  // namespace credence::internal
