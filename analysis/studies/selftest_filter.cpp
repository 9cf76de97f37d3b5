#include "analysis/studies/selftest_filter.h"

#include <cmath>
#include <numbers>

#include "core/enum_words.h"
#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

constexpr double kMeasurementVariance = 0.01;  // rad²
constexpr double kInitialVariance = 0.01;      // rad²
constexpr double kTurn = 0.2;                  // rad a step: in 40 steps every run crosses ±π
constexpr double kColour = 0.5;                // lag-1 correlation of coloured measurement noise
constexpr double kNoisy = 0.1;                 // share of the noisier measurements of heavy tails
constexpr double kBias = 0.8;                  // of the compass, in standard deviations of its noise

Eigen::Matrix2d measurement_matrix() {
  Eigen::Matrix2d H;
  H << -1.0, 1.0, 1.0, 0.0;
  return H;
}

Eigen::Matrix2d inverse_factor(const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d L = covariance.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity());
}

using Lanes = SyntheticFilter::Lanes;
using LaneRow = Eigen::Array<double, 1, SyntheticFilter::kRuns>;

// All random numbers of a block of runs.
class BlockNoise {
 public:
  BlockNoise(const NoiseSource& noise, std::int64_t block)
      : source_(noise),
        first_(block * SyntheticFilter::kRuns),
        process_(kPerSlot),
        measurement_(2 * kPerSlot) {
    const std::int64_t first = first_;
    noise.normals_of_runs(first, 1, SyntheticFilter::kSteps, NoisePurpose::process, 1, process_);
    noise.normals_of_runs(first, 1, SyntheticFilter::kSteps, NoisePurpose::measurement, 2, measurement_);
    for (int lane = 0; lane < SyntheticFilter::kRuns; ++lane) {
      noise.normals(first + lane, 0, NoisePurpose::initial, std::span(initial.col(lane).data(), 2));
      heading(lane) = std::numbers::pi * (2.0 * noise.uniform(first + lane, 0, NoisePurpose::world, 0) - 1.0);
    }
  }

  // Keeps the variance: one measurement in ten has nine times that of the others.
  void make_tails_heavy(int k, Lanes& w) const {
    const double usual = 1.0 / std::sqrt(1.0 + 8.0 * kNoisy);
    for (int lane = 0; lane < SyntheticFilter::kRuns; ++lane) {
      const bool noisy = source_.uniform(first_ + lane, k + 1, NoisePurpose::world, 0) < kNoisy;
      w.col(lane) *= noisy ? 3.0 * usual : usual;
    }
  }

  LaneRow process(int k) const { return row(process_, 0, k); }
  Lanes measurement(int k) const {
    Lanes result;
    result.row(0) = row(measurement_, 0, k);
    result.row(1) = row(measurement_, 1, k);
    return result;
  }

  Lanes initial;
  LaneRow heading;  // true, at the start; uniform on (−π, π)

 private:
  static constexpr std::size_t kPerSlot =
      static_cast<std::size_t>(SyntheticFilter::kSteps) * SyntheticFilter::kRuns;

  static LaneRow row(const std::vector<double>& values, int slot, int k) {
    return Eigen::Map<const LaneRow>(values.data() +
                                     (slot * SyntheticFilter::kSteps + k) * SyntheticFilter::kRuns);
  }

  const NoiseSource& source_;
  std::int64_t first_;
  std::vector<double> process_, measurement_;
};

// Compass and estimate both lie in (−π, π], and their difference is not wrapped.
double unwrapped_difference(double heading, double compass_noise, double heading_error) {
  return wrap_angle(heading + compass_noise) - wrap_angle(heading + heading_error);
}

}  // namespace

std::string_view to_string(Defect defect) {
  return word_of(defect,
                 {"exact filter", "Q assumed 1/25", "Q assumed x 25", "R assumed 1/2", "R assumed x 2",
                  "one dof too many", "angle not wrapped", "cross-covariance dropped", "innovation not white",
                  "P0 assumed 1/9", "gated innovations", "biased compass", "noise with heavy tails, P right",
                  "two sensors against one prior, P right"});
}

SyntheticSetup setup_of(Defect defect) {
  constexpr double kResponsive = 0.1;
  switch (defect) {
    case Defect::process_noise_too_small:
      return {.noise_ratio = kResponsive, .process_scale = 1.0 / 25.0, .defect = defect};
    case Defect::process_noise_too_large:
      return {.noise_ratio = kResponsive, .process_scale = 25.0, .defect = defect};
    case Defect::measurement_noise_too_small:
      return {.noise_ratio = kResponsive, .measurement_scale = 0.5, .defect = defect};
    case Defect::measurement_noise_too_large:
      return {.noise_ratio = kResponsive, .measurement_scale = 2.0, .defect = defect};
    case Defect::initial_covariance: return {.initial_scale = 1.0 / 9.0, .defect = defect};
    case Defect::shared_prior: return {.noise_ratio = 1.0, .defect = defect};
    default: return {.defect = defect};
  }
}

SyntheticFilter::SyntheticFilter(const SyntheticSetup& setup) : setup_(setup) {
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d H = measurement_matrix();
  const Eigen::Matrix2d R = setup.measurement_scale * kMeasurementVariance * I;
  const double Q = setup.process_scale * setup.noise_ratio * kMeasurementVariance;
  Eigen::Matrix2d P = setup.initial_scale * kInitialVariance * I;
  for (int k = 0; k < kSteps; ++k) {
    P(0, 0) += Q;
    const Eigen::Matrix2d S = H * P * H.transpose() + R;
    Step step;
    step.missing = setup.every_third_missing && k % 3 == 2;
    step.K = S.llt().solve(H * P).transpose();
    if (step.missing) step.K.setZero();
    step.A = I - step.K * H;
    P = (step.A * P * step.A.transpose() + step.K * R * step.K.transpose()).eval();
    if (setup.defect == Defect::dropped_cross_covariance) P(0, 1) = P(1, 0) = 0.0;
    step.P = P;
    step.S = S;
    step.inverse_factor_P = inverse_factor(P);
    step.inverse_factor_S = inverse_factor(S);
    steps_.push_back(step);
  }
}

std::vector<SyntheticFilter::Sample> SyntheticFilter::simulate(const NoiseSource& noise,
                                                               std::int64_t block) const {
  const BlockNoise drawn(noise, block);
  const double process_std = std::sqrt(setup_.noise_ratio * kMeasurementVariance);
  const Eigen::Matrix2d H = measurement_matrix();
  Lanes error = std::sqrt(kInitialVariance) * drawn.initial;
  Lanes w = Lanes::Zero();
  LaneRow heading = drawn.heading;
  std::vector<Sample> samples;
  samples.reserve(kSteps);
  for (int k = 0; k < kSteps; ++k) {
    const Step& step = steps_[static_cast<std::size_t>(k)];
    const LaneRow v = process_std * drawn.process(k);
    heading += kTurn + v;
    error.row(0).array() -= v;
    const double memory = setup_.defect == Defect::coloured_noise && k > 0 ? kColour : 0.0;
    w = memory * w + std::sqrt((1.0 - memory * memory) * kMeasurementVariance) * drawn.measurement(k);
    if (setup_.defect == Defect::heavy_tails) drawn.make_tails_heavy(k, w);
    Lanes nu = w - H * error;
    if (setup_.defect == Defect::biased_measurement) {
      nu.row(1).array() += kBias * std::sqrt(kMeasurementVariance);
    }
    if (setup_.defect == Defect::unwrapped_angle) {
      for (int lane = 0; lane < kRuns; ++lane) {
        nu(1, lane) = unwrapped_difference(heading(lane), w(1, lane), error(0, lane));
      }
    }
    error += step.K * nu;
    error.row(0) = error.row(0).unaryExpr([](double angle) { return wrap_angle(angle); });
    samples.push_back({.error = error, .innovation = nu});
  }
  return samples;
}

Eigen::Array<double, 1, SyntheticFilter::kRuns> SyntheticFilter::nees(int step, const Lanes& error) const {
  return (steps_[static_cast<std::size_t>(step)].inverse_factor_P * error).colwise().squaredNorm().array();
}

Eigen::Array<double, 1, SyntheticFilter::kRuns> SyntheticFilter::nis(int step,
                                                                     const Lanes& innovation) const {
  return (steps_[static_cast<std::size_t>(step)].inverse_factor_S * innovation)
      .colwise()
      .squaredNorm()
      .array();
}

double SyntheticFilter::assumed_measurement_variance() const {
  return setup_.measurement_scale * kMeasurementVariance;
}

std::vector<Matrix> SyntheticFilter::covariances() const {
  std::vector<Matrix> result;
  for (const Step& step : steps_) result.emplace_back(step.P);
  return result;
}

std::vector<Matrix> SyntheticFilter::transitions() const {
  std::vector<Matrix> result;
  for (const Step& step : steps_) result.emplace_back(step.A);
  return result;
}

}  // namespace credence::internal
