#include "datasets/logs/ros/covariance_sentinels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>

#include "core/append_item.h"

namespace credence::internal {
namespace {

constexpr std::array<const char*, 6> kPoseComponents = {"x",          "y",          "z",
                                                        "rotation x", "rotation y", "rotation z"};

/// Not a number equals itself here.
bool same_bits(const PoseCovariance& a, const PoseCovariance& b) {
  return std::equal(a.data(), a.data() + a.size(), b.data(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

/// "z, rotation x (61 rows); …", those of the same count together; "" for none.
std::string components(const std::array<std::int64_t, 6>& counts, std::int64_t rows) {
  std::map<std::int64_t, std::string, std::greater<>> names;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) append_item(names[counts[i]], kPoseComponents[i]);
  }
  std::string all;
  for (const auto& [count, text] : names) {
    append_item(all,
                fmt::format("{} in {}", text,
                            count == rows ? "every row" : fmt::format("{} of {} rows", count, rows)),
                "; ");
  }
  return all;
}

}  // namespace

std::vector<Index> CovarianceSentinels::kept(const PoseCovariance& P, const SpatialPose& pose) {
  if (rows_++ == 0) {
    first_ = P;
    start_ = pose.position;
  }
  changed_ = changed_ || !same_bits(P, first_);
  moved_m_ = std::max(moved_m_, (pose.position - start_).norm());
  if (P(0, 0) == -1.0) {
    ++unknown_;
    return {};
  }
  std::vector<Index> result;
  for (Index i = 0; i < 6; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double variance = P(i, i);
    if (variance == 0.0) {
      ++zero_[at];
    } else if (!std::isfinite(variance)) {
      ++not_finite_[at];
    } else if (variance >= kNotEstimated) {
      ++large_[at];
    } else {
      result.push_back(i);
    }
  }
  return result;
}

bool CovarianceSentinels::constant() const {
  constexpr std::int64_t kEnough = 10;
  constexpr double kMoved_m = 0.1;
  return rows_ >= kEnough && !changed_ && moved_m_ >= kMoved_m;
}

bool CovarianceSentinels::planar() const {
  constexpr std::array<bool, 6> kPlane = {true, true, false, false, false, true};
  for (std::size_t i = 0; i < kPlane.size(); ++i) {
    const std::int64_t missing = zero_[i] + large_[i] + not_finite_[i];
    if (missing != (kPlane[i] ? 0 : rows_)) return false;
  }
  return rows_ > 0 && unknown_ == 0;
}

std::vector<std::string> CovarianceSentinels::remarks(const std::string& topic) const {
  std::vector<std::string> sentences;
  const auto say = [&](const char* what, const std::array<std::int64_t, 6>& counts) {
    if (const std::string text = components(counts, rows_); !text.empty()) {
      sentences.push_back(fmt::format(
          "{}: a variance {} means “not estimated”, and is left out of the dof: {}.", topic, what, text));
    }
  };
  say("of 0", zero_);
  say("at or above 1e5", large_);
  say("that is not finite", not_finite_);
  if (unknown_ > 0) {
    sentences.push_back(fmt::format(
        "{}: −1 in the first element says in {} of {} rows that nothing is known.", topic, unknown_, rows_));
  }
  if (constant()) {
    sentences.push_back(
        fmt::format("{}: the covariance never changes over {} rows while the body moves {:.3g} m: a "
                    "constant that was written down, not an estimate.",
                    topic, rows_, moved_m_));
  }
  return sentences;
}

}  // namespace credence::internal
