#include "analysis/laws/gate_rejection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// What a straight line over the bins takes from the sum of squares of the changes.
double explained_by_line(const std::vector<Moments>& bins) {
  double n = 0.0, x = 0.0, y = 0.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const auto count = static_cast<double>(bins[b].count);
    n += count;
    x += count * static_cast<double>(b);
    y += count * bins[b].mean;
  }
  double xx = 0.0, xy = 0.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const double away = static_cast<double>(b) - x / n, count = static_cast<double>(bins[b].count);
    xx += count * away * away;
    xy += count * away * (bins[b].mean - y / n);
  }
  return xx > 0.0 ? xy * xy / xx : 0.0;
}

}  // namespace

void ChangesOfRun::add(std::size_t seen, double before, double change) {
  steps_.push_back({seen, before, change});
}

ChangesOfRun::Comparable ChangesOfRun::comparable() const {
  constexpr std::int64_t kFewest = 4;
  Comparable result;
  if (std::ranges::all_of(steps_, [&](const Step& step) { return step.seen == steps_.front().seen; })) {
    for (const Step& step : steps_) result.changes.push_back(step.change);
    return result;
  }
  struct Alike {
    Moments before, change;
  };
  std::map<std::size_t, Alike> alike;
  for (const Step& step : steps_) {
    Alike& all = alike[step.seen];
    if (!std::isfinite(step.change)) continue;
    all.before.add(step.before);
    all.change.add(step.change);
  }
  double xx = 0.0, xy = 0.0;
  for (const Step& step : steps_) {
    const auto& [before, change] = alike.at(step.seen);
    if (!std::isfinite(step.change) || before.count < kFewest) continue;
    xx += (step.before - before.mean) * (step.before - before.mean);
    xy += (step.before - before.mean) * (step.change - change.mean);
  }
  const double slope = xx > 0.0 ? xy / xx : 0.0;
  Moments taken;
  for (const Step& step : steps_) {
    const auto& [before, change] = alike.at(step.seen);
    const double explained =
        before.count < kFewest ? kNaN : change.mean + slope * (step.before - before.mean);
    result.changes.push_back(step.change - explained);
    if (std::isfinite(explained)) taken.add(explained);
  }
  result.variance = taken.variance();
  return result;
}

void ChangesByNis::add(double survival, double change, double taken) {
  if (!std::isfinite(change)) return;
  if (bins.empty()) bins.resize(kBins);
  const double octaves = survival > 0.0 ? -std::log2(survival) : static_cast<double>(kBins);
  const int bin = std::clamp(static_cast<int>(kBinsPerOctave * octaves), 0, kBins - 1);
  bins[static_cast<std::size_t>(bin)].add(change);
  bins[static_cast<std::size_t>(bin)].m2 += taken;
}

void ChangesByNis::merge(const ChangesByNis& later) {
  if (bins.empty()) bins.resize(later.bins.size());
  for (std::size_t b = 0; b < later.bins.size(); ++b) bins[b].merge(later.bins[b]);
}

std::optional<GateRejection> find_gate_rejection(const ChangesByNis& changes) {
  constexpr std::int64_t kFewest = 8;
  constexpr double kLeastJump = 0.5;
  const std::size_t size = changes.bins.size();
  std::vector<Moments> above(size + 1);  // of all bins from this one on
  for (std::size_t b = size; b > 0; --b) {
    above[b - 1] = changes.bins[b - 1];
    above[b - 1].merge(above[b]);
  }
  std::optional<GateRejection> found;
  Moments below;
  double most = 0.0, tested = 0.0;
  for (std::size_t b = 1; b < size; ++b) {
    below.merge(changes.bins[b - 1]);
    const Moments& beyond = above[b];
    if (below.count < kFewest || beyond.count < kFewest) continue;
    tested += 1.0;
    const auto n = static_cast<double>(beyond.count), m = static_cast<double>(below.count);
    const double jump = beyond.mean - below.mean, told = jump * jump * (n * m / (n + m));
    if (told <= most) continue;
    most = told;
    found.reset();
    if (!(jump > kLeastJump * std::sqrt(below.variance()))) continue;
    const double t = jump / std::sqrt(beyond.variance() / n + below.variance() / m);
    found = GateRejection{.expected = std::exp2(-static_cast<double>(b) / ChangesByNis::kBinsPerOctave),
                          .share = n / (n + m),
                          .p_value = student_upper_p_value(t, std::min(n, m) - 1.0)};
  }
  if (found && explained_by_line(changes.bins) >= most) found.reset();
  if (found) found->p_value = std::min(1.0, tested * found->p_value);
  return found;
}

}  // namespace credence::internal
