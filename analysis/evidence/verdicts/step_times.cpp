#include "analysis/evidence/verdicts/step_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/evidence/sums/step_series.h"

namespace credence::internal {
namespace {

/// So many that the times of steps so far apart differ, and by little else: 1 of 0.1 s, 2 of 0.25 s.
int decimals_of(double interval_s) {
  constexpr double kMost = 6.0, kRounding = 0.01, kOff = 0.15;
  const double least = std::clamp(std::ceil(-std::log10(interval_s) - kRounding), 0.0, kMost);
  const double unit = std::pow(10.0, -least);
  const bool is_off = std::abs(std::round(interval_s / unit) * unit - interval_s) > kOff * interval_s;
  return static_cast<int>(std::min(least + (is_off ? 1.0 : 0.0), kMost));
}

}  // namespace

std::shared_ptr<const StepTimes> StepTimes::every(double step_s) {
  if (!(step_s > 0.0)) return nullptr;
  StepTimes times;
  times.step_s_ = step_s;
  return std::make_shared<const StepTimes>(std::move(times));
}

void StepTimes::add(std::int64_t step, double time_s) {
  if (!std::isfinite(time_s)) return;
  const bool first = std::isnan(run_begin_s_);
  place(step, time_s);
  if (!first || std::isnan(run_begin_s_)) return;
  earliest_begin_s_ = std::fmin(earliest_begin_s_, run_begin_s_);
  latest_begin_s_ = std::fmax(latest_begin_s_, run_begin_s_);
}

void StepTimes::place(std::int64_t step, double time_s) {
  for (; step > kMostSteps * stride_; stride_ *= 2) drop_every_second(elapsed_s_);
  if (!agreed_ || (stride_ > 1 && (step - 1) % stride_ != 0)) return;
  const auto k = static_cast<std::size_t>(stride_ > 1 ? (step - 1) / stride_ : step - 1);
  if (elapsed_s_.size() <= k) elapsed_s_.resize(k + 1, kNaN);
  if (std::isnan(run_begin_s_)) {
    const bool alone = first_step_ == 0;
    if (!alone && std::isnan(elapsed_s_[k])) {
      // At a step of no run before: where all have one clock, which has equal steps.
      const double elapsed_s = time_s - earliest_begin_s_, away = static_cast<double>(step - first_step_);
      agreed_ = latest_begin_s_ - earliest_begin_s_ <= 0.5 * interval_s() &&
                std::abs(elapsed_s - away * interval_s()) < 0.5 * interval_s();
      run_begin_s_ = earliest_begin_s_;
    } else {
      run_begin_s_ = alone ? time_s : time_s - elapsed_s_[k];
    }
    if (alone) first_step_ = step;
  }
  const double elapsed_s = time_s - run_begin_s_;
  if (std::isnan(elapsed_s_[k])) {
    elapsed_s_[k] = elapsed_s;
  } else {
    agreed_ = agreed_ && std::abs(elapsed_s - elapsed_s_[k]) <= 0.5 * interval_s();
  }
  if (step <= last_step_) return;
  if (last_step_ > 0 && !(elapsed_s > last_elapsed_s_)) agreed_ = false;
  last_step_ = step;
  last_elapsed_s_ = elapsed_s;
}

void StepTimes::merge(const StepTimes& later) {
  if (later.first_step_ == 0) return;
  if (first_step_ == 0) {
    *this = later;
    return;
  }
  for (; stride_ < later.stride_; stride_ *= 2) drop_every_second(elapsed_s_);
  agreed_ = agreed_ && later.agreed_;
  begin_run();
  for (std::size_t k = 0; k < later.elapsed_s_.size(); ++k) {
    if (std::isnan(later.elapsed_s_[k])) continue;
    place(1 + static_cast<std::int64_t>(k) * later.stride_, later.earliest_begin_s_ + later.elapsed_s_[k]);
  }
  earliest_begin_s_ = std::min(earliest_begin_s_, run_begin_s_);
  latest_begin_s_ = std::max(latest_begin_s_, run_begin_s_ + later.latest_begin_s_ - later.earliest_begin_s_);
}

double StepTimes::interval_s() const {
  if (step_s_ > 0.0) return step_s_;
  return last_step_ > first_step_ ? last_elapsed_s_ / static_cast<double>(last_step_ - first_step_) : 0.0;
}

bool StepTimes::as_told() const {
  constexpr double kLongest_s = 1e7;  // beyond it, it is a date
  return step_s_ > 0.0 || (latest_begin_s_ - earliest_begin_s_ <= 0.5 * interval_s() &&
                           std::abs(earliest_begin_s_) < kLongest_s);
}

double StepTimes::at(std::int64_t step) const {
  if (step_s_ > 0.0) return step_s_ * static_cast<double>(step);
  if (!known() || step < 1 || (step - 1) % stride_ != 0) return kNaN;
  const auto k = static_cast<std::size_t>((step - 1) / stride_);
  if (k >= elapsed_s_.size()) return kNaN;
  return elapsed_s_[k] + (as_told() ? earliest_begin_s_ : 0.0);
}

std::string StepTimes::text(std::int64_t first, std::int64_t last) const {
  const double from = at(first), to = at(last);
  if (std::isnan(from) || std::isnan(to)) return {};
  const int decimals = decimals_of(interval_s());
  std::string times = fmt::format("{:.{}f}", from, decimals);
  if (last != first) times += fmt::format(" to {:.{}f}", to, decimals);
  return as_told() ? fmt::format(" (t = {} s)", times) : fmt::format(" ({} s after the start)", times);
}

}  // namespace credence::internal
