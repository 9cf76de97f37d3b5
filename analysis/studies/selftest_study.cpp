#include "analysis/studies/selftest_study.h"

#include "analysis/laws/chi_square.h"

namespace credence {
namespace {

using Sample = SyntheticFilter::Sample;

constexpr std::size_t kStudySteps = SyntheticFilter::kSteps;

bool is_logged(const SyntheticFilter& filter, double nis) {
  return filter.setup().defect != Defect::gated_innovations || nis <= synthetic_gate();
}

void collect_errors(const SyntheticFilter& filter, int k, const Eigen::Vector2d& error, double nees,
                    SyntheticStudy& study) {
  const std::size_t at = static_cast<std::size_t>(k);
  study.nees[at].add(nees);
  study.heading_nees[at].add(error(0) * error(0) / filter.covariance(k)(0, 0));
  study.landmark_nees[at].add(error(1) * error(1) / filter.covariance(k)(1, 1));
  study.coverage[at].add(nees <= 4.0);
  if (k + 1 == SyntheticFilter::kSteps) {
    study.last_nees.push_back(nees);
    study.last_errors.emplace_back(error);
  }
}

void collect_innovation(const SyntheticFilter& filter, int k, const Vector& u, SyntheticStudy& study) {
  const std::size_t at = static_cast<std::size_t>(k);
  const double nis = u.squaredNorm();
  if (nis <= synthetic_gate()) {
    study.gated_nis[at].add(nis);
    study.gated_nis_values.push_back(nis);
  }
  if (!is_logged(filter, nis)) return;
  study.nis[at].add(nis);
  study.nis_values.push_back(nis);
  study.innovation.add(u);
}

void collect_block(const SyntheticFilter& filter, const SyntheticStudy::Block& block, SyntheticStudy& study) {
  Eigen::Array<double, 1, SyntheticFilter::kRuns> run_sums;
  run_sums.setZero();
  SyntheticFilter::Lanes innovation_sums = SyntheticFilter::Lanes::Zero();
  for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
    const Sample& sample = block[static_cast<std::size_t>(k)];
    const auto nees = filter.nees(k, sample.error);
    run_sums += nees;
    innovation_sums += sample.innovation;
    study.beyond_half_turn += sample.beyond_half_turn;
    for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
      collect_errors(filter, k, sample.error.col(run), nees(run), study);
      collect_innovation(filter, k, sample.innovation.col(run), study);
    }
  }
  const SyntheticFilter::Lanes last = filter.whitened(SyntheticFilter::kSteps - 1, block.back().error);
  for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
    study.run_sum_nees.add(run_sums(run));
    study.run_mean_innovation.add(innovation_sums.col(run) / SyntheticFilter::kSteps);
    study.last_whitened.add(last.col(run));
  }
}

}  // namespace

double synthetic_gate() {
  static const double gate = chi_square_quantile(0.95, SyntheticFilter::kInnovationDof);
  return gate;
}

SyntheticStudy make_study(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t first_block,
                          int blocks) {
  SyntheticStudy study;
  study.nees = study.heading_nees = study.landmark_nees = study.nis = study.gated_nis =
      SyntheticStudy::PerStep(kStudySteps);
  study.coverage.resize(kStudySteps);
  for (int block = 0; block < blocks; ++block) {
    study.blocks.push_back(filter.simulate(noise, first_block + block));
    collect_block(filter, study.blocks.back(), study);
  }
  return study;
}

void add_samples(const SyntheticFilter& filter, std::span<const Sample> samples, std::vector<Moments>& nees,
                 std::vector<Moments>& nis) {
  for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    const auto step_nees = filter.nees(k, samples[at].error);
    for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
      nees[at].add(step_nees(run));
      nis[at].add(samples[at].innovation.col(run).squaredNorm());
    }
  }
}

LagProducts synthetic_lags(const SyntheticFilter& filter, const SyntheticStudy& study, int first_step) {
  constexpr Index kLags = 5;
  LagProducts lags(2, kLags);
  for (const SyntheticStudy::Block& block : study.blocks) {
    for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
      lags.begin_run();
      for (std::size_t k = static_cast<std::size_t>(first_step); k < block.size(); ++k) {
        const Vector u = block[k].innovation.col(run);
        if (is_logged(filter, u.squaredNorm())) {
          lags.add(u);
        } else {
          lags.add_missing();
        }
      }
    }
  }
  return lags;
}

std::vector<double> synthetic_dofs(const std::vector<Moments>& steps, double dof) {
  std::vector<double> result;
  result.reserve(steps.size());
  for (const Moments& step : steps) result.push_back(dof * static_cast<double>(step.count));
  return result;
}

}  // namespace credence
