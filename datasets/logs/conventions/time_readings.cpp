#include "datasets/logs/conventions/time_readings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/logs/time_offset.h"

namespace credence::internal {
namespace {

/// Samples with the truth at other times.
class OtherTimes {
 public:
  OtherTimes(const PoseChart& declared, std::span<const PoseSample> samples, const TruthLookup& truth_at)
      : declared_(declared), samples_(samples), truth_at_(truth_at) {}

  /// The mean NEES of every `stride`-th sample with the truth so much later; infinite where fewer than half
  /// of them have one.
  double nees(double later_s, std::size_t stride) const {
    const std::vector<PoseSample> moved = at(later_s, stride);
    if (2 * moved.size() * stride < samples_.size()) return std::numeric_limits<double>::infinity();
    const PoseReading reading{"", "", declared_};
    return mean_nees(std::span(moved), estimated_components(declared_.axes),
                     [&](const PoseSample& s, PoseError& e, PoseCovariance& P) { reading.read(s, e, P); });
  }

  double least() const {
    const auto stride_for = [&](std::size_t rows) {
      return std::max<std::size_t>(1, samples_.size() / rows);
    };
    constexpr std::size_t kOnGrid = 256, kBetween = 1024;
    return time_of_least_cost(
        [&](std::span<const double> times_s) {
          std::vector<double> costs;
          costs.reserve(times_s.size());
          for (const double time_s : times_s) costs.push_back(nees(time_s, stride_for(kOnGrid)));
          return costs;
        },
        [&](double time_s) { return nees(time_s, stride_for(kBetween)); });
  }

  std::vector<PoseSample> at(double later_s, std::size_t stride = 1) const {
    std::vector<PoseSample> moved;
    for (std::size_t i = 0; i < samples_.size(); i += stride) {
      PoseSample sample = samples_[i];
      if (truth_at_(sample.time_s + later_s, sample.truth)) moved.push_back(sample);
    }
    return moved;
  }

 private:
  const PoseChart& declared_;
  std::span<const PoseSample> samples_;
  const TruthLookup& truth_at_;
};

}  // namespace

std::vector<TimeReading> time_readings(const PoseChart& declared, std::span<const PoseSample> samples,
                                       double spacing_s, const TruthLookup& truth_at) {
  constexpr double kTaken = 0.1;  // of the NEES
  constexpr double kSame = 0.05;  // of a sample
  const OtherTimes other(declared, samples, truth_at);
  std::vector<TimeReading> readings;
  const auto add = [&](double later_s, const std::string& by, std::string repair) {
    std::vector<PoseSample> moved = other.at(later_s);
    if (2 * moved.size() < samples.size()) return;
    readings.push_back(
        {{fmt::format("the estimate's times are {} too {}", by, later_s > 0.0 ? "early" : "late"),
          std::move(repair), declared},
         std::move(moved)});
  };
  for (const double later_s : {spacing_s, -spacing_s}) {
    add(later_s, fmt::format("{:.3g} s, one sample,", spacing_s),
        fmt::format("the time of what was estimated, or --time-offset {:.3g}", later_s));
  }
  const double best_s = other.least();
  if (std::isnan(best_s) || std::abs(std::abs(best_s) - spacing_s) < kSame * spacing_s) return readings;
  if (!(other.nees(best_s, 1) < (1.0 - kTaken) * other.nees(0.0, 1))) return readings;
  add(best_s, fmt::format("{:.2g} s", std::abs(best_s)),
      fmt::format("the time of what was estimated, or --time-offset {:.2g}; --time-offset estimate finds it",
                  best_s));
  return readings;
}

}  // namespace credence::internal
