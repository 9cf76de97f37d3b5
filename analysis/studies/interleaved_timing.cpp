#include "analysis/studies/interleaved_timing.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <ctime>
#include <numeric>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

double now_s(TimedClock clock) {
  timespec now{};
  clock_gettime(clock == TimedClock::thread ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double seconds_of(const TimedWork& work, std::int64_t times) {
  const double begin = now_s(work.clock);
  work.work(times);
  return now_s(work.clock) - begin;
}

std::int64_t whole_periods(const TimedWork& work, double times) {
  return work.period * std::llround(std::ceil(times / static_cast<double>(work.period)));
}

/// How often the work is to be done for it to take so many seconds.
std::int64_t calibrate(const TimedWork& work, double seconds) {
  constexpr double kMost = 1e12;  // of work that takes no time
  double times = 1.0;
  while (true) {
    const std::int64_t whole = whole_periods(work, times);
    const double taken = seconds_of(work, whole);
    times = static_cast<double>(whole);
    if (taken >= 0.5 * seconds || times >= kMost) return whole_periods(work, times * seconds / taken);
    times = std::min(10.0 * times, std::max(2.0 * times, times * seconds / taken));
  }
}

}  // namespace

MeasuredTime summarise_times(std::vector<double> repetitions) {
  if (repetitions.empty()) throw std::invalid_argument("a median needs at least one repetition");
  std::vector<double> sorted = repetitions;
  std::ranges::sort(sorted);
  const std::size_t n = sorted.size();
  MeasuredTime time;
  time.median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
  // P(fewer than k of n lie below the median) <= 2.5 % on either side.
  std::size_t k = 0;
  const boost::math::binomial_distribution<> below(static_cast<double>(n), 0.5);
  while (k + 1 <= (n - 1) / 2 && cdf(below, static_cast<double>(k)) <= 0.025) ++k;
  if (k > 0) --k;
  time.lower = sorted[k];
  time.upper = sorted[n - 1 - k];
  time.repetitions = std::move(repetitions);
  return time;
}

std::vector<MeasuredTime> time_interleaved(
    std::span<const TimedWork> works, const TimingPlan& plan, const std::atomic<bool>* stop,
    const std::function<void(std::int64_t done, std::int64_t total)>& progress) {
  if (plan.repetitions < 1 || !(plan.seconds > 0.0)) {
    throw std::invalid_argument("timing needs at least one repetition of some duration");
  }
  const auto stopped = [&] { return stop != nullptr && stop->load(); };
  const auto each = static_cast<std::int64_t>(works.size()), total = (plan.repetitions + 1) * each;
  std::int64_t done = 0;
  const auto tell = [&] {
    ++done;
    if (progress) progress(done, total);
  };
  std::vector<std::int64_t> times;
  for (const TimedWork& work : works) {
    if (stopped()) return {};
    times.push_back(calibrate(work, plan.seconds));
    tell();
  }
  std::vector<std::vector<double>> seconds(works.size());
  std::vector<std::size_t> order(works.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 generator(plan.seed);
  for (int round = 0; round < plan.repetitions && !stopped(); ++round) {
    std::shuffle(order.begin(), order.end(), generator);
    for (const std::size_t i : order) {
      if (stopped()) break;
      works[i].work(1);
      seconds[i].push_back(seconds_of(works[i], times[i]) / (static_cast<double>(times[i]) * works[i].items));
      tell();
    }
  }
  std::vector<MeasuredTime> measured;
  if (works.empty()) return measured;
  // A round that was stopped is dropped.
  const std::size_t whole = std::ranges::min(seconds, {}, &std::vector<double>::size).size();
  if (whole == 0) return measured;
  for (std::vector<double>& of_work : seconds) {
    of_work.resize(whole);
    measured.push_back(summarise_times(std::move(of_work)));
  }
  return measured;
}

}  // namespace credence::internal
