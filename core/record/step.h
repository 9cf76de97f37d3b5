#pragma once

#include <cmath>
#include <cstdint>
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

/// An innovation of which only νᵀS⁻¹ν is known (Sensor::nis_alone): it has this NIS and dimension.
inline Innovation nis_alone(double nis, Index dim) {
  return {Vector::Constant(dim, std::sqrt(nis / static_cast<double>(dim))), Matrix::Identity(dim, dim)};
}

}  // namespace credence::internal
