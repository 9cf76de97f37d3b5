#include "montecarlo/worlds/plugged/function_bound.h"

#include "core/linear_algebra/cholesky.h"

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
  for (std::int64_t k = 1; k <= settings.steps; ++k) {
    stop_point();
    for (std::size_t i = 0; i < truths.size(); ++i) {
      Vector& x = truths[i];
      const auto run = static_cast<std::int64_t>(i);
      steps[i].F = model.F ? model.F(x) : difference_jacobian(model.f, x, angles);
      steps[i].Q = model.Q;
      NoiseDraw process(source, run, k, NoisePurpose::process);
      x = world.step(x, k, process);
      const Matrix H = model.H ? model.H(x) : difference_jacobian(model.h, x, model.measured_angles);
      const Matrix weighted = root.matrixL().solve(H);
      NoiseDraw seen(source, run, k, NoisePurpose::detection);
      steps[i].information = weighted.transpose() * weighted;
      if (detection < 1.0 && seen.uniform() >= detection) steps[i].information.setZero();
    }
    if (!recursion.step(steps)) {
      return {.runs = runs,
              .blocks = {},
              .reason = "the process noise is singular, and the motion depends on the state"};
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
