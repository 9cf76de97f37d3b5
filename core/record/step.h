#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/types.h"

/// @file
/// What a filter shows at one step, from whatever world or file it comes: all that is needed to judge it.

namespace credence {

/// An innovation ν with its covariance S; empty when the sensor was silent.
struct Innovation {
  Vector nu{};
  Matrix S{};
  Matrix R{};  ///< of the measurement, as the filter assumes it; empty: not known but for Sensor::variances
  bool complete = true;  ///< of each observation in ν all components are there
};

/// One step of one run.
struct Step {
  std::int64_t step = 0;                  ///< from 1
  std::int64_t line = 0;                  ///< of its file, if it has one
  std::vector<Index> states{};            ///< those with an estimate and a truth, by number of the layout
  Vector error{};                         ///< x̂ ⊟ x of these states, as the producer defines it
  Vector estimate{};                      ///< x̂ of these states, in coordinates; empty: not known
  Matrix P{};                             ///< their covariance
  std::vector<Innovation> innovations{};  ///< one for each sensor
  std::string_view problem = {};          ///< why the step cannot be used, else empty
};

}  // namespace credence

namespace credence::internal {

/// An innovation of which only νᵀS⁻¹ν is known (Sensor::nis_alone): ν is that number, and there is no S.
inline Innovation nis_alone(double nis) { return {.nu = Vector::Constant(1, nis)}; }

/// Whether the components `kept` of an innovation make up observations of `piece` components each.
inline bool are_complete(std::span<const Index> kept, Index piece) {
  const auto at = [&](Index k) { return kept[static_cast<std::size_t>(k)]; };
  for (Index k = 0; k < std::ssize(kept); ++k) {
    const Index first = at(k - k % piece);
    if (first % piece != 0 || at(k) != first + k % piece) return false;
  }
  return std::ssize(kept) % piece == 0;
}

}  // namespace credence::internal
