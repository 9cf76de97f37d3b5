#include "analysis/studies/selftest_study.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

/// The way that the vehicle goes; it has no part in the filter.
constexpr double kMetresPerStep = 1.0;

/// The gate of gated innovations: the 95 % quantile of their law.
double synthetic_gate() {
  static const double gate = chi_square_quantile(0.95, SyntheticFilter::kInnovationDof);
  return gate;
}

RunLayout layout_of(const SyntheticFilter& filter) {
  RunLayout layout{.states = {"heading", "landmark"},
                   .angles = {true, false},
                   .blocks = {{"heading", Part::heading, {0}}, {"landmark", Part::other, {1}}},
                   .sensors = {{.name = "", .dim = 2, .piece = 2}}};
  const double R = filter.assumed_measurement_variance();
  layout.sensors.front().variances = {R, R};
  layout.sensors.front().angles = {false, true};  // the bearing of the landmark is small, the compass turns
  if (filter.setup().defect == Defect::shared_prior) {
    layout.sensors = {{.name = "landmark", .dim = 1, .piece = 1, .variances = {R}},
                      {.name = "compass", .dim = 1, .piece = 1, .variances = {R}, .angles = {true}}};
  }
  if (filter.setup().defect == Defect::wrong_dof) {
    layout.states.emplace_back("idle");
    layout.angles.push_back(false);
  }
  return layout;
}

/// What the filter shows of one run at step k (from 0).
void show(const SyntheticFilter& filter, const SyntheticFilter::Sample& sample, int k, int run, Step& step) {
  const Index n = std::ssize(step.states);
  step.step = k + 1;
  step.error = Vector::Zero(n);
  step.error.head<2>() = sample.error.col(run);
  step.P = Matrix::Identity(n, n);
  step.P.topLeftCorner<2, 2>() = filter.setup().logged_scale * filter.covariance(k);
  const Eigen::Vector2d nu = sample.innovation.col(run);
  const Eigen::Matrix2d& S = filter.innovation_covariance(k);
  if (filter.missing(k)) {
    for (Innovation& innovation : step.innovations) innovation = {};
    return;
  }
  if (filter.setup().defect == Defect::shared_prior) {
    for (Index i = 0; i < 2; ++i) {
      step.innovations[static_cast<std::size_t>(i)] = {nu.segment(i, 1), S.block(i, i, 1, 1)};
    }
    return;
  }
  const bool gated = filter.setup().defect == Defect::gated_innovations;
  if (gated && nu.dot(S.llt().solve(nu)) > synthetic_gate()) {
    step.innovations.front() = {};
  } else {
    step.innovations.front() = {nu, S};
  }
}

}  // namespace

Evidence synthetic_evidence(std::span<const SyntheticFilter> filters, const NoiseSource& noise,
                            std::int64_t first_block, int runs, int steps, CalibrationRecorder* calibration) {
  const RunLayout layout = layout_of(filters.front());
  EvidenceRecorder recorder(layout);
  Step step;
  step.innovations.resize(layout.sensors.size());
  for (Index i = 0; i < std::ssize(layout.states); ++i) step.states.push_back(i);
  for (int first = 0; first < runs; first += SyntheticFilter::kRuns) {
    std::vector<std::vector<SyntheticFilter::Sample>> samples;
    for (const SyntheticFilter& filter : filters) {
      samples.push_back(filter.simulate(noise, first_block + first / SyntheticFilter::kRuns));
    }
    for (int run = 0; run < std::min(SyntheticFilter::kRuns, runs - first); ++run) {
      const std::size_t of = static_cast<std::size_t>(first + run) % filters.size();
      recorder.begin_run();
      if (calibration != nullptr) calibration->begin_run(layout, fmt::format("{}", first + run));
      for (int k = 0; k < steps; ++k) {
        show(filters[of], samples[of][static_cast<std::size_t>(k)], k, run, step);
        recorder.add(step);
        if (calibration != nullptr) calibration->add(step, kMetresPerStep * k);
      }
    }
  }
  Evidence all;
  for (Evidence& chunk : recorder.take_chunks()) all.merge(std::move(chunk));
  all.merge(recorder.take());
  return all;
}

Evidence synthetic_evidence(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t first_block,
                            int runs, int steps, CalibrationRecorder* calibration) {
  return synthetic_evidence({&filter, 1}, noise, first_block, runs, steps, calibration);
}

void add_samples(const SyntheticFilter& filter, std::span<const SyntheticFilter::Sample> samples,
                 std::vector<Moments>& nees, std::vector<Moments>& nis) {
  for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    const auto step_nees = filter.nees(k, samples[at].error);
    const auto step_nis = filter.nis(k, samples[at].innovation);
    for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
      nees[at].add(step_nees(run));
      nis[at].add(step_nis(run));
    }
  }
}

std::vector<double> synthetic_dofs(const std::vector<Moments>& steps, double dof) {
  std::vector<double> result;
  result.reserve(steps.size());
  for (const Moments& step : steps) result.push_back(dof * static_cast<double>(step.count));
  return result;
}

}  // namespace credence::internal
