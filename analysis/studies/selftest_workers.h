#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "analysis/studies/selftest.h"
#include "montecarlo/engine/byte_stream.h"
#include "montecarlo/engine/ranks.h"

/// @file
/// What the parts of the selftest share: threads and ranks with one progress, noise of their own, shares of
/// studies.

namespace credence::internal {

/// The level at which wrong filters are to be found.
inline constexpr double kSelftestPowerLevel = 0.05;

/// Noise groups that the parts draw from; the last ones add the number of the defect or of the kind.
struct SelftestNoise {
  static constexpr std::uint64_t kTests = 1, kLooks = 2, kSweep = 3, kSingleRuns = 4, kProof = 5, kMixed = 6,
                                 kLogs = 7, kEstimators = 8, kTuning = 9, kAgreement = 10, kWrong = 100,
                                 kSavings = 200, kWord = 300;
};

/// Work items on some threads of all ranks, with progress over all of them; the order of execution changes
/// nothing, as each item writes only what is its own.
class SelftestWorkers {
 public:
  /// total: items of all calls of for_each. `options` must live as long.
  SelftestWorkers(const SelftestOptions& options, std::int64_t total) : options_(options), total_(total) {}

  /// Does work(i) for all i < count, which writes the elements i of `results` and nothing else.
  template <class... Result>
  void for_each(std::int64_t count, const std::function<void(std::int64_t)>& work,
                std::vector<Result>&... results) {
    for_each(
        {.count = count,
         .work = work,
         .write = [&](std::int64_t i, ByteWriter& w) { (w.put(results[static_cast<std::size_t>(i)]), ...); },
         .read = [&](std::int64_t i, ByteReader& r) { (r.get(results[static_cast<std::size_t>(i)]), ...); }});
  }

  /// Whether the results are not all there: the user ended it, or this is not rank 0.
  bool stopped() const;

 private:
  struct Items {
    std::int64_t count = 0;
    const std::function<void(std::int64_t)>& work;
    std::function<void(std::int64_t, ByteWriter&)> write;
    std::function<void(std::int64_t, ByteReader&)> read;
  };
  void for_each(const Items& items);
  void tell_progress();

  const SelftestOptions& options_;
  std::mutex mutex_;
  std::int64_t done_ = 0, total_;
  int part_ = 0;  ///< calls of for_each, so that ranks that are not at the same one are refused
};

/// Whether a test rejects; a p-value of NaN never does.
inline bool is_alarm(double p_value, double level) { return p_value <= level; }

/// A share without its interval, which judge_selftest adds.
inline StudyShare share_of(std::int64_t hits, std::int64_t studies) {
  return {.count = {.inside = hits, .total = studies}};
}

}  // namespace credence::internal
