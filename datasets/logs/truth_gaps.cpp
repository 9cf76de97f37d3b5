#include "datasets/logs/truth_gaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/linear_algebra/psd_root.h"
#include "datasets/logs/conventions/pose_error.h"

namespace credence::internal {
namespace {

/// Without the largest twentieth: a truth that jumps, or a manoeuvre, would say how all the others grow.
double trimmed_mean(std::vector<double>& values) {
  const auto kept = values.begin() + static_cast<std::ptrdiff_t>(values.size() - values.size() / 20);
  std::ranges::nth_element(values, kept - 1);
  return std::accumulate(values.begin(), kept, 0.0) / static_cast<double>(kept - values.begin());
}

}  // namespace

bool is_any_too_far(std::span<const Vector> deviations, const Matrix& P) {
  if (deviations.empty()) return false;
  const Matrix W = psd_whitening(P);
  const double most = TruthGaps::kShare * static_cast<double>(W.rows());
  return std::ranges::any_of(deviations, [&](const Vector& d) { return (W * d).squaredNorm() > most; });
}

TruthGaps::TruthGaps(const Trajectory& truth, const TrajectoryMatching& matching)
    : truth_(truth), matching_(matching) {
  constexpr std::size_t kFewestRows = 32, kMostRows = 4096, kWidestLag = 4;
  const std::size_t rows = truth.time_s.size();
  if (rows < kFewestRows + 2 * kWidestLag) return;
  std::vector<double> position[3], rotation[3];
  const std::size_t stride = (rows + kMostRows - 1) / kMostRows;
  for (std::size_t i = kWidestLag; i + kWidestLag < rows; i += stride) {
    for (std::size_t k = 0; k < 3; ++k) {
      const TruthDeviation d = departure(i, std::size_t{1} << k);
      position[k].push_back(d.position.squaredNorm());
      rotation[k].push_back(d.rotation.squaredNorm());
    }
  }
  of_position_ = growth_of(position[0], position[1], position[2]);
  of_rotation_ = growth_of(rotation[0], rotation[1], rotation[2]);
}

TruthGaps::Growth TruthGaps::growth_of(std::vector<double> of_one, std::vector<double> of_two,
                                       std::vector<double> of_four) {
  constexpr double kRandomWalk = 2.0, kSteady = 16.0;
  const double one = trimmed_mean(of_one), two = trimmed_mean(of_two), four = trimmed_mean(of_four);
  if (!(two > one)) return {.motion = 0.0};
  // Within the gap it is no less than over longer ones; noise makes the first of these too small.
  const double growth = std::clamp(std::max(two / one, (four - two) / (two - one)), kRandomWalk, kSteady);
  return {.usual = std::sqrt(one),
          .alpha = std::log(growth) / std::log(4.0),
          .motion = one > 0.0 ? std::min(1.0, (two - one) / (growth - 1.0) / one) : 1.0};
}

TruthDeviation TruthGaps::departure(std::size_t i, std::size_t lag) const {
  const double before_s = truth_.time_s[i - lag], after_s = truth_.time_s[i + lag];
  const SpatialPose line = pose_between(truth_.poses[i - lag], truth_.poses[i + lag],
                                        (truth_.time_s[i] - before_s) / (after_s - before_s));
  const SpatialPose& row = truth_.poses[i];
  return {row.position - line.position, rotation_log(line.orientation.conjugate() * row.orientation)};
}

std::vector<TruthDeviation> TruthGaps::at(double time_s) const {
  const std::vector<double>& times = truth_.time_s;
  const double t = time_s + matching_.time_offset_s.value_or(0.0);
  if (times.size() < 2) return {};
  const auto upper = static_cast<std::size_t>(std::ranges::lower_bound(times, t) - times.begin());
  const std::size_t after = std::clamp<std::size_t>(upper, 1, times.size() - 1), before = after - 1;
  const double gap = times[after] - times[before], share = (t - times[before]) / gap;
  const bool first_is_nearer = t - times[before] <= times[after] - t;
  if (std::abs(t - times[first_is_nearer ? before : after]) <= kSameTime_s) return {};

  std::vector<TruthDeviation> from_line;
  for (const std::size_t i : {before, after}) {
    if (i == 0 || i + 1 == times.size() || upper == 0 || upper == times.size()) continue;
    const double beside = 4.0 * (times[i] - times[i - 1]) * (times[i + 1] - times[i]);
    const auto scale = [&](const Growth& growth, double length) {
      const double place = std::pow(4.0 * share * (1.0 - share), std::clamp(growth.alpha + 0.5, 1.0, 2.0));
      const double raised = growth.alpha < 1.0 && length > 0.0 ? std::max(1.0, growth.usual / length) : 1.0;
      return raised * std::sqrt(growth.motion * place * std::pow(gap * gap / beside, growth.alpha));
    };
    const TruthDeviation d = departure(i, 1);
    from_line.push_back({scale(of_position_, d.position.norm()) * d.position,
                         scale(of_rotation_, d.rotation.norm()) * d.rotation});
  }
  if (matching_.truth_time == TruthTime::interpolated) return from_line;

  const SpatialPose& taken = truth_.poses[first_is_nearer ? before : after];
  const SpatialPose line = pose_between(truth_.poses[before], truth_.poses[after], share);
  const TruthDeviation moved = {line.position - taken.position,
                                rotation_log(taken.orientation.conjugate() * line.orientation)};
  std::vector<TruthDeviation> result = {moved};
  for (const TruthDeviation& d : from_line) {
    for (const double side : {1.0, -1.0})
      result.push_back({moved.position + side * d.position, moved.rotation + side * d.rotation});
  }
  return result;
}

std::string TruthGaps::left_out_rows() const {
  const std::string count = fmt::format("{} row{} left out, ", left_out_, left_out_ == 1 ? " is" : "s are");
  const double percent = 100.0 * std::sqrt(kShare);
  if (matching_.truth_time == TruthTime::nearest) {
    return count + fmt::format(
                       "from whose time to that of the nearest row of the truth the truth moves by "
                       "more than {:.0f} % of σ",
                       percent);
  }
  return count + fmt::format(
                     "whose truth lies between two of its rows, {:.2g} s apart, and may be off the "
                     "straight line between them by more than {:.0f} % of σ",
                     mean_interval_s(truth_), percent);
}

void TruthGaps::tell(const std::filesystem::path& estimate, std::int64_t rows, LogSink& sink) const {
  if (left_out_ == 0) return;
  if (rows > 0) return sink.remark(left_out_rows() + ".");
  throw DataError(
      estimate, "",
      fmt::format("all {}; {}", left_out_rows(),
                  matching_.truth_time == TruthTime::nearest
                      ? "--truth-time interpolated takes the line between two rows of the truth"
                      : "what is needed is a truth of more rows, or estimates beside its rows (--truth-time "
                        "nearest)"));
}

}  // namespace credence::internal
