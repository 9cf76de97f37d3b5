#include "datasets/logs/conventions/convention_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "datasets/logs/conventions/thinned.h"

namespace credence::internal {
namespace {

const std::vector<std::vector<Index>> kPoseParts = {{0, 1, 2}, {3, 4, 5}};

/// Mean NEES of the samples; NaN where a P is not positive definite.
template <class Read>
double mean_nees(const std::vector<PoseSample>& samples, Read read) {
  double sum = 0.0;
  PoseError error;
  PoseCovariance P;
  for (const PoseSample& sample : samples) {
    read(sample, error, P);
    const Eigen::LLT<PoseCovariance> factor(P);
    if (factor.info() != Eigen::Success) return kNaN;
    sum += factor.matrixL().solve(error).squaredNorm();
  }
  return sum / static_cast<double>(samples.size());
}

}  // namespace

void ConventionCheck::add(const PoseEstimate& estimate, const UncertainPose& truth) {
  if (declared_.axes.orientation == OrientationError::planar) return;
  if (seen_ == 0) first_s_ = estimate.time_s;
  last_s_ = estimate.time_s;
  if (!keep_thinned(samples_, stride_, seen_)) return;
  PoseSample sample{.time_s = estimate.time_s, .estimate = estimate.pose, .truth = truth.pose};
  sample.written = declared_.position_first(estimate.covariance);  // which is its own inverse
  if (!truth.covariance.isZero(0.0)) {
    sample.truth_covariance = transported(truth.covariance, truth.pose, declared_.axes, kFixedAxes);
  }
  samples_.push_back(sample);
}

void ConventionCheck::tell(const TruthComparison& truth, LogSink& sink) const {
  if (samples_.empty()) return sink.charts({.declared = std::string(declared_.name)});
  ChartFindings findings = charts();
  if (std::string text = charts_text(findings); !text.empty()) sink.remark(std::move(text));
  sink.charts(std::move(findings));
  if (samples_.size() < kFewestForReading) return;
  const ReadingFit declared = fit({"", "", declared_});
  if (!declared.misfits()) return;
  std::string text = mistakes(declared, truth);
  if (text.empty()) return sink.unexplained();
  sink.misfit(std::move(text));
}

double ConventionCheck::spacing() const {
  return (last_s_ - first_s_) / static_cast<double>(std::max<std::size_t>(1, seen_ - 1));
}

ReadingRow ConventionCheck::rows_of(const PoseReading& reading) const {
  return [this, &reading](std::size_t i, Vector& e, Matrix& C) {
    PoseError error;
    PoseCovariance P;
    if (!reading.read(samples_[i], error, P)) return false;
    e = error;
    C = P;
    return true;
  };
}

ReadingFit ConventionCheck::fit(const PoseReading& reading) const {
  return fit_reading(samples_.size(), 6, kPoseParts, rows_of(reading));
}

ChartFindings ConventionCheck::charts() const {
  ChartFindings findings{.declared = std::string(declared_.name), .rows = std::ssize(samples_)};
  for (const PoseChart& chart : pose_charts()) {
    if (chart.axes.orientation == OrientationError::planar) continue;
    const PoseReading reading{"", "", chart};
    ChartNees nees{.chart = std::string(chart.name)};
    nees.as_written = mean_nees(
        samples_, [&](const PoseSample& s, PoseError& e, PoseCovariance& P) { reading.read(s, e, P); });
    nees.carried = mean_nees(samples_, [&](const PoseSample& s, PoseError& e, PoseCovariance& P) {
      const PoseCovariance J = error_change(s.estimate, s.truth, declared_.axes, chart.axes);
      e = pose_error(s.estimate, s.truth, chart.axes);
      P = declared_.position_first(s.written) +
          transported(s.truth_covariance, s.truth, kFixedAxes, declared_.axes);
      P = (J * P * J.transpose()).eval();
    });
    if (samples_.size() >= kFewestForReading && std::isfinite(nees.as_written))
      nees.p_value = fit(reading).p_value;
    findings.charts.push_back(std::move(nees));
  }
  return findings;
}

std::string ConventionCheck::charts_text(const ChartFindings& findings) const {
  constexpr double kDiffer = 1.1;
  std::string text;
  double least = HUGE_VAL, most = 0.0, least_carried = HUGE_VAL, most_carried = 0.0;
  for (const ChartNees& nees : findings.charts) {
    append_item(text, fmt::format("{} {}", nees.chart, number_text(nees.as_written)));
    // What an author may have meant without a mistake in order or unit.
    const PoseErrorAxes& axes = pose_chart_named(nees.chart).axes;
    if (std::isfinite(nees.as_written) && axes.position == PositionError::world &&
        axes.unit == RotationUnit::vector) {
      least = std::min(least, nees.as_written);
      most = std::max(most, nees.as_written);
    }
    if (std::isfinite(nees.carried)) {
      least_carried = std::min(least_carried, nees.carried);
      most_carried = std::max(most_carried, nees.carried);
    }
  }
  if (!charts_asked_ && !(most > kDiffer * least)) return "";
  if (!std::isfinite(least_carried))
    return "Charts cannot be compared: the covariance of the pose is singular.";
  return fmt::format(
      "What the covariance speaks of matters here; mean NEES of the pose (6 expected) if what is written "
      "were of the chart: {}. Judged is {} (--chart), a choice to be made before these numbers are looked "
      "at. Its covariance, carried over exactly into each of these charts, has a mean NEES of {} to {}.",
      text, declared_.name, number_text(least_carried), number_text(most_carried));
}

std::string ConventionCheck::likely_mistake(const ReadingFit& declared, const TruthLookup& truth_at) const {
  constexpr double kFarOff = 100.0, kNear = 4.0, kDim = 6.0;
  if (std::isfinite(declared.nees) && declared.nees < kFarOff * kDim) return "";
  std::optional<PoseReading> best;
  ReadingFit best_fit;
  for (PoseReading& reading : mistaken_readings(declared_, spacing(), truth_at)) {
    const ReadingFit found = fit(reading);
    if (!(found.nees > kDim / kNear && found.nees < kDim * kNear)) continue;
    if (best && found.log_likelihood <= best_fit.log_likelihood) continue;
    best = std::move(reading);
    best_fit = found;
  }
  if (!best) return "";
  return fmt::format(
      "The covariance does not fit as it is read (chart {}, {}). It nearly would if {} (mean NEES {}; "
      "{}), though errors are correlated for too long to test that. Whether it is so, the log cannot say: "
      "look at the program that wrote it.",
      declared_.name, misfit_text(declared, 6), best->cause, number_text(best_fit.nees), best->repair);
}

std::string ConventionCheck::mistakes(const ReadingFit& declared, const TruthComparison& truth) const {
  constexpr std::size_t kMostNamed = 3;
  // A reading so much less likely than the best is no rival: 3 in the logarithm over all samples.
  constexpr double kRival = 3.0;
  const TruthLookup truth_at = [&](double time_s, SpatialPose& pose) {
    const std::optional<UncertainPose> at = truth.truth_at(time_s);
    if (at) pose = at->pose;
    return at.has_value();
  };
  struct Fitting {
    PoseReading reading;
    ReadingFit fit;
  };
  std::vector<Fitting> fitting;
  for (PoseReading& reading : mistaken_readings(declared_, spacing(), truth_at)) {
    const auto found = fitting_reading(samples_.size(), 6, kPoseParts, rows_of(reading));
    if (found) fitting.push_back({std::move(reading), *found});
  }
  if (fitting.empty()) return likely_mistake(declared, truth_at);
  std::ranges::stable_sort(fitting, std::greater(), [](const Fitting& f) { return f.fit.log_likelihood; });
  const double best = fitting.front().fit.log_likelihood;
  std::erase_if(fitting, [&](const Fitting& f) {
    return f.fit.log_likelihood < best - kRival / static_cast<double>(samples_.size());
  });
  if (fitting.size() > kMostNamed) fitting.resize(kMostNamed);
  std::string repairs;
  for (const auto& [reading, fit] : fitting) {
    append_item(repairs,
                fmt::format("{} (mean NEES {}; {})", reading.cause, number_text(fit.nees), reading.repair),
                ", or if ");
  }
  return fmt::format(
      "The covariance does not fit as it is read (chart {}, {}). It would fit if {}. Whether it is so, the "
      "log cannot say: look at the program that wrote it.",
      declared_.name, misfit_text(declared, 6), repairs);
}

}  // namespace credence::internal
