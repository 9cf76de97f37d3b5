#pragma once

#include "montecarlo/worlds/charted/charted_settings.h"
#include "montecarlo/worlds/charted/charted_world.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {

/// Runs whose truths are looked at: a step costs some µs, and runs have thousands.
inline constexpr std::int64_t kChartedBoundRuns = 16;

/// The posterior Cramér-Rao bound of a model that knows its noise, in the chart in which errors are judged:
/// in the axes of the body, where motion depends on the state by no more than biases of what is read, given
/// what is read. To first order in the errors, as curvature of the group is.
template <ChartedModel Model>
PosteriorBound charted_bound(Model model, Chart judged, const PlugSettings& settings) {
  using Group = typename Model::Group;
  const auto shared = std::make_shared<const Model>(std::move(model));
  const ChartedWorld<Model> world(shared, judged);
  const NoiseSource source = settings.source();
  std::vector<Group> truths;
  std::vector<Matrix> P0;
  for (std::int64_t run = 0; run < kChartedBoundRuns; ++run) {
    NoiseDraw initial(source, run, 0, NoisePurpose::initial);
    truths.push_back(world.initial(initial));
    P0.push_back(transported(typename Group::Jacobian(world.prior().covariance), truths.back(),
                             Chart::componentwise, Chart::right));
  }
  PosteriorRecursion recursion(std::move(P0), PosteriorRecursion::Motion::of_input);
  BoundRecorder recorder(shared->layout(), kChartedBoundRuns);
  std::vector<PosteriorRecursion::Truth> steps(truths.size());
  for (std::int64_t k = 1; k <= settings.steps; ++k) {
    stop_point();
    for (std::size_t i = 0; i < truths.size(); ++i) {
      const auto run = static_cast<std::int64_t>(i);
      const Group before = truths[i];
      NoiseDraw process(source, run, k, NoisePurpose::process);
      truths[i] = world.step(before, k, process);
      NoiseDraw input(source, run, k, NoisePurpose::process, plugged::kInputSlots);
      const auto motion = shared->motion(before, world.input(truths[i], k, input));
      steps[i].F = motion.F;
      steps[i].Q = motion.Q;
      steps[i].information.setZero(Group::kDim, Group::kDim);
      NoiseDraw measurement(source, run, k, NoisePurpose::measurement);
      if (const std::optional<Aiding> seen = world.measure(truths[i], k, measurement)) {
        const auto exact = shared->innovation(truths[i], *seen);
        const Eigen::LLT<Matrix> root(exact.R);
        if (root.info() != Eigen::Success) return {.reason = kBoundOfNoisyMeasurements};
        const Matrix weighted = root.solve(Matrix(exact.H));
        steps[i].information = exact.H.transpose() * weighted;
      }
    }
    recursion.step(steps);
    Vector bound = Vector::Zero(Group::kDim), at_truth = Vector::Zero(Group::kDim);
    const auto add = [&](const Matrix& P, std::size_t i, Vector& sum) {
      sum += transported(typename Group::Jacobian(P), truths[i], Chart::right, judged).diagonal() /
             static_cast<double>(kChartedBoundRuns);
    };
    for (std::size_t i = 0; i < truths.size(); ++i) {
      add(recursion.bound(i), i, bound);
      add(recursion.at_truth(i), i, at_truth);
    }
    recorder.add(bound, at_truth);
  }
  return recorder.take();
}

/// That of a scenario, of a model made of it.
template <ChartedModel Model>
PosteriorBound charted_bound(const Scenario& scenario) {
  Scenario knowing = scenario;
  knowing.filter.process_scale = knowing.filter.measurement_scale = 1.0;
  return charted_bound(Model(knowing), chart_settings(scenario).judged, plug_settings(scenario));
}

}  // namespace credence::internal
