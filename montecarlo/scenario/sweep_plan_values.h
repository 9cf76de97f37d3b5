#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "montecarlo/scenario/scenario_value.h"

namespace credence::internal {

/// The most values that one list, and the most points that one sweep may have.
inline constexpr std::size_t kLargestSweep = 1'000'000;

/// The values that a list of the [sweep] table stands for, in the order written.
///
/// Items are separated by commas; each is a number or word, or one of
///   `a:b`         a, a + 1, … up to b,
///   `a:step:b`    in decimal arithmetic: 0.1:0.1:0.5 is exactly 0.1, 0.2, 0.3, 0.4, 0.5,
///   `lin(a,b,n)`  n values at equal distances, both ends included,
///   `log(a,b,n)`  n values at equal ratios, the inner ones rounded to 12 digits.
/// Values made of integers are integers where whole. Throws std::invalid_argument naming the item.
std::vector<ScalarValue> expand_sweep_list(std::string_view list);

}  // namespace credence::internal
