#include "montecarlo/worlds/plugged/function_bound.h"

#include <limits>

#include "core/linear_algebra/cholesky.h"

namespace credence::internal {
namespace {

/// What rounding may leave of a difference quotient of f at x: that of sums as large as f and its terms, over
/// the step.
Matrix quotient_rounding(const Matrix& J, const VectorRef& x, const VectorRef& f) {
  constexpr double kRoundings = 64.0;
  const Vector size = f.cwiseAbs() + J.cwiseAbs() * x.cwiseAbs();
  const Vector step = (kDifferenceStep * x.cwiseAbs()).cwiseMax(kDifferenceStep);
  return kRoundings * std::numeric_limits<double>::epsilon() * size * step.cwiseInverse().transpose();
}

/// Gives the truths one F where theirs are the same but for the rounding of differences, as those of a linear
/// f are, of which a singular Q allows no other spread.
void join_jacobians(const std::vector<Matrix>& rounding, std::vector<PosteriorRecursion::Truth>& steps) {
  Matrix mean = Matrix::Zero(steps.front().F.rows(), steps.front().F.cols());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Matrix off = (steps[i].F - steps.front().F).cwiseAbs();
    if (!(off.array() <= (rounding[i] + rounding.front()).array()).all()) return;
    mean += steps[i].F / static_cast<double>(steps.size());
  }
  for (PosteriorRecursion::Truth& step : steps) step.F = mean;
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

PosteriorBound posterior_bound(const FunctionModel& model, const PlugSettings& settings, double detection,
                               std::int64_t runs) {
  const FunctionWorld world(model);
  const NoiseSource source = settings.source();
  const std::vector<bool>& angles = world.layout().angles;
  const Eigen::LLT<Matrix> root(model.R);
  if (root.info() != Eigen::Success) return {.reason = kBoundOfNoisyMeasurements};
  std::vector<Vector> truths;
  for (std::int64_t run = 0; run < runs; ++run) {
    NoiseDraw initial(source, run, 0, NoisePurpose::initial);
    truths.push_back(world.initial(initial));
  }
  PosteriorRecursion recursion(std::vector<Matrix>(truths.size(), model.P0),
                               PosteriorRecursion::Motion::of_state);
  BoundRecorder recorder(world.layout(), runs);
  std::vector<PosteriorRecursion::Truth> steps(truths.size());
  std::vector<Matrix> rounding(truths.size());
  for (std::int64_t k = 1; k <= settings.steps; ++k) {
    stop_point();
    for (std::size_t i = 0; i < truths.size(); ++i) {
      Vector& x = truths[i];
      const auto run = static_cast<std::int64_t>(i);
      steps[i].F = model.F ? model.F(x) : difference_jacobian(model.f, x, angles);
      if (!model.F) rounding[i] = quotient_rounding(steps[i].F, x, model.f(x));
      steps[i].Q = model.Q;
      NoiseDraw process(source, run, k, NoisePurpose::process);
      x = world.step(x, k, process);
      const Matrix H = model.H ? model.H(x) : difference_jacobian(model.h, x, model.measured_angles);
      const Matrix weighted = root.matrixL().solve(H);
      NoiseDraw seen(source, run, k, NoisePurpose::detection);
      steps[i].information = weighted.transpose() * weighted;
      if (detection < 1.0 && seen.uniform() >= detection) steps[i].information.setZero();
    }
    if (!model.F) join_jacobians(rounding, steps);
    if (!recursion.step(steps)) {
      return {.runs = runs,
              .blocks = {},
              .reason = "the process noise is singular, and the Jacobian of the motion depends on the state"};
    }
    Vector at_truth = Vector::Zero(model.mean.size());
    for (std::size_t i = 0; i < truths.size(); ++i) {
      at_truth += recursion.at_truth(i).diagonal() / static_cast<double>(runs);
    }
    recorder.add(recursion.bound(0).diagonal(), at_truth);
  }
  return recorder.take();
}

}  // namespace credence
