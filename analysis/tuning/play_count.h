#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

namespace credence::internal {

/// How many times the data of a score were played, within a play by its parts; told by one thread at a time.
class PlayCount {
 public:
  using Watch = std::function<void(double plays)>;

  void watch(Watch watch) { watch_ = std::move(watch); }

  /// One of so many parts of this play is done.
  void add_part_of(std::int64_t parts) const { add(0, 1.0 / static_cast<double>(parts)); }
  /// The play is done.
  void finish() const { add(1, 0.0); }

 private:
  void add(std::int64_t plays, double share) const {
    if (!watch_) return;
    const std::lock_guard lock(mutex_);
    plays_ += plays;
    share_ = plays > 0 ? 0.0 : share_ + share;
    watch_(static_cast<double>(plays_) + share_);
  }

  Watch watch_;
  mutable std::mutex mutex_;
  mutable std::int64_t plays_ = 0;
  mutable double share_ = 0.0;
};

}  // namespace credence::internal
