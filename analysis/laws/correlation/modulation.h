#pragma once

#include <cstddef>
#include <span>

#include "core/nan.h"

/// @file
/// Whether the size of a series, as of the NEES or NIS of one run, goes up and down in time, in a wave or
/// slowly: a P that is too small at some times and too large at others may be right on average, and its
/// errors look like those of heavy tails.

namespace credence::internal {

/// A mean over that of the whole series, with its standard error.
struct SeriesLevel {
  double mean = kNaN, error = kNaN;
};

struct Modulation {
  double p_value = kNaN;
  double wave = kNaN;  ///< values in a wave, or in the shortest of the slow ones, that speaks most
  SeriesLevel low = {}, high = {};  ///< of the values where these waves are below zero, and above
};

/// The levels of a series where its waves from the first to the last frequency, from 1, together are below
/// and above zero; errors are those of values that an autoregression of first order makes about them.
void set_levels(std::span<const double> series, std::size_t first, std::size_t last, Modulation& of);

/// The p-value of "the series has no more of a wave, and of what is slow, than its short memory makes".
///
/// The periodogram I_j of the ranks, which tails do not reach, is divided by the spectrum of
/// r_h = a ρ^(h − 1), h ≥ 1, with a = r_1 and ρ = (r_2 + r_3)/(r_1 + r_2), at most 1 − 200/N so that the
/// lowest 30 frequencies are nearly alike; by none where r_1 is within chance. Then I_j are nearly
/// exponential and alike nearby: each is compared with the mean of the 32 around it (F of 2 and 64 dof,
/// Bonferroni over all), and the mean of the first K = 1, 2, 4, 8, 16 with that of the next 4 K + 16 (F of 2
/// K and 8 K + 32 dof, Bonferroni). Bonferroni over both. A regime that lasts for hardly longer than errors
/// are correlated is taken for that.
///
/// N is cut to a product of 2, 3 and 5; of a long series averages are looked at (thinned_series.h). NaNs for
/// fewer than 135 values, or some that are not finite, or all equal. Cost N log N. Measured levels are in
/// docs/statistics.md.
Modulation modulation(std::span<const double> series);

}  // namespace credence::internal
