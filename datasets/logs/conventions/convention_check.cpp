#include "datasets/logs/conventions/convention_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "datasets/logs/conventions/thinned.h"
#include "datasets/logs/conventions/time_readings.h"

namespace credence::internal {
namespace {

/// Position and rotation, as places in the components; a heading is tested as a component.
std::vector<std::vector<Index>> parts_of(const PoseChart& chart) {
  if (chart.axes.orientation == OrientationError::planar) return {{0, 1}};
  return {{0, 1, 2}, {3, 4, 5}};
}

}  // namespace

bool ConventionCheck::takes(std::span<const Index> estimated) const {
  return std::ranges::includes(estimated, components());
}

void ConventionCheck::add(const PoseEstimate& estimate, const UncertainPose& truth) {
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
  ChartFindings findings = charts();
  if (std::string text = charts_text(findings); !text.empty()) sink.remark(std::move(text));
  sink.charts(std::move(findings));
  if (samples_.size() < kFewestForReading) return;
  const ReadingFit declared = fit({.reading = {"", "", declared_}});
  if (!declared.misfits()) return;
  std::string text = mistakes(declared, truth);
  if (text.empty()) return sink.unexplained();
  sink.misfit(std::move(text));
}

double ConventionCheck::spacing() const {
  return (last_s_ - first_s_) / static_cast<double>(std::max<std::size_t>(1, seen_ - 1));
}

ReadingRow ConventionCheck::rows_of(const Candidate& candidate) const {
  return [this, &candidate](std::size_t i, Vector& e, Matrix& C) {
    PoseError error;
    PoseCovariance P;
    if (!candidate.reading.read(samples_of(candidate)[i], error, P)) return false;
    e = error(components());
    C = P(components(), components());
    return true;
  };
}

ReadingFit ConventionCheck::fit(const Candidate& candidate) const {
  return fit_reading(samples_of(candidate).size(), dim(), parts_of(declared_), rows_of(candidate));
}

std::optional<ReadingFit> ConventionCheck::fitting(const Candidate& candidate) const {
  return fitting_reading(samples_of(candidate).size(), dim(), parts_of(declared_), rows_of(candidate));
}

ChartFindings ConventionCheck::charts() const {
  ChartFindings findings{.declared = std::string(declared_.name)};
  if (samples_.empty() || declared_.axes.orientation == OrientationError::planar) return findings;
  findings.rows = std::ssize(samples_);
  for (const PoseChart& chart : pose_charts()) {
    if (chart.axes.orientation == OrientationError::planar) continue;
    const PoseReading reading{"", "", chart};
    ChartNees nees{.chart = std::string(chart.name)};
    nees.as_written =
        mean_nees(std::span(samples_), components(),
                  [&](const PoseSample& s, PoseError& e, PoseCovariance& P) { reading.read(s, e, P); });
    nees.carried = mean_nees(
        std::span(samples_), components(), [&](const PoseSample& s, PoseError& e, PoseCovariance& P) {
          const PoseCovariance J = error_change(s.estimate, s.truth, declared_.axes, chart.axes);
          e = pose_error(s.estimate, s.truth, chart.axes);
          P = declared_.position_first(s.written) +
              transported(s.truth_covariance, s.truth, kFixedAxes, declared_.axes);
          P = (J * P * J.transpose()).eval();
        });
    if (samples_.size() >= kFewestForReading && std::isfinite(nees.as_written))
      nees.p_value = fit({reading}).p_value;
    findings.charts.push_back(std::move(nees));
  }
  return findings;
}

std::string ConventionCheck::charts_text(const ChartFindings& findings) const {
  if (findings.charts.empty()) return "";
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

std::vector<ConventionCheck::Candidate> ConventionCheck::candidates(const TruthComparison& truth) const {
  const TruthLookup truth_at = [&](double time_s, SpatialPose& pose) {
    const std::optional<UncertainPose> at = truth.truth_at(time_s);
    if (at) pose = at->pose;
    return at.has_value();
  };
  std::vector<Candidate> all;
  for (PoseReading& reading : mistaken_readings(declared_)) all.push_back({std::move(reading)});
  for (TimeReading& other : time_readings(declared_, samples_, spacing(), truth_at))
    all.push_back({std::move(other.reading), std::move(other.samples)});
  return all;
}

std::string ConventionCheck::likely_mistake(const ReadingFit& declared,
                                            std::span<const Candidate> candidates) const {
  constexpr double kFarOff = 100.0, kNear = 4.0;
  const auto expected = static_cast<double>(dim());
  if (std::isfinite(declared.nees) && declared.nees < kFarOff * expected) return "";
  const Candidate* best = nullptr;
  ReadingFit best_fit;
  for (const Candidate& candidate : candidates) {
    const ReadingFit found = fit(candidate);
    if (!(found.nees > expected / kNear && found.nees < expected * kNear)) continue;
    if (best != nullptr && found.log_likelihood <= best_fit.log_likelihood) continue;
    best = &candidate;
    best_fit = found;
  }
  if (best == nullptr) return "";
  return fmt::format(
      "The covariance does not fit as it is read (chart {}, {}). It nearly would if {} (mean NEES {}; "
      "{}), though errors are correlated for too long to test that. Whether it is so, the log cannot say: "
      "look at the program that wrote it.",
      declared_.name, misfit_text(declared, dim()), best->reading.cause, number_text(best_fit.nees),
      best->reading.repair);
}

std::string ConventionCheck::mistakes(const ReadingFit& declared, const TruthComparison& truth) const {
  constexpr std::size_t kMostNamed = 3;
  // A reading so much less likely than the best is no rival: 3 in the logarithm over all samples.
  constexpr double kRival = 3.0;
  struct Fitting {
    const PoseReading* reading;
    ReadingFit fit;
  };
  std::vector<Fitting> fits;
  const std::vector<Candidate> all = candidates(truth);
  for (const Candidate& candidate : all) {
    const std::optional<ReadingFit> found = fitting(candidate);
    if (found) fits.push_back({&candidate.reading, *found});
  }
  if (fits.empty()) return likely_mistake(declared, all);
  std::ranges::stable_sort(fits, std::greater(), [](const Fitting& f) { return f.fit.log_likelihood; });
  const double best = fits.front().fit.log_likelihood;
  std::erase_if(fits, [&](const Fitting& f) {
    return f.fit.log_likelihood < best - kRival / static_cast<double>(samples_.size());
  });
  if (fits.size() > kMostNamed) fits.resize(kMostNamed);
  std::string repairs;
  for (const auto& [reading, fit] : fits) {
    append_item(repairs,
                fmt::format("{} (mean NEES {}; {})", reading->cause, number_text(fit.nees), reading->repair),
                ", or if ");
  }
  return fmt::format(
      "The covariance does not fit as it is read (chart {}, {}). It would fit if {}. Whether it is so, the "
      "log cannot say: look at the program that wrote it.",
      declared_.name, misfit_text(declared, dim()), repairs);
}

}  // namespace credence::internal
