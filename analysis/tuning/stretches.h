#pragma once

#include <cstdint>
#include <span>

namespace credence::internal {

/// Stretches of eight correlation times have nearly independent averages: so many tell of a mean.
inline constexpr std::int64_t kFewestStretches = 10;

/// Of the values about their mean (effective_sample.h); NaN where they do not vary.
double correlation_time_of(std::span<const double> values);

/// How many stretches a series of this length and correlation time can be cut into; 0 if too few.
std::int64_t stretch_count(std::size_t length, double correlation_time);

}  // namespace credence::internal
