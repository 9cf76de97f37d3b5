#pragma once

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace credence::internal::testing {

/// Numbers of either sign and of all sizes as programs write them, in 1 to 17 digits.
inline std::vector<std::string> number_texts() {
  std::mt19937_64 bits(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> decades(-25.0, 25.0);
  std::vector<std::string> texts;
  for (int i = 0; i < 2000; ++i) {
    const double number = normal(bits) * std::pow(10.0, i % 2 == 0 ? 0.0 : decades(bits));
    for (const int digits : {1, 4, 9, 12, 15, 17}) texts.push_back(fmt::format("{:.{}g}", number, digits));
    texts.push_back(fmt::format("{:.6f}", number));
    texts.push_back(fmt::format("{:.8e}", number));
  }
  return texts;
}

}  // namespace credence::internal::testing
