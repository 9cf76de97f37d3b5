#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"

/// @file
/// What any filter says at one step, from whatever file it came: all that is needed to judge it.

namespace credence {

/// What the rows of one log have in common.
struct FilterLogLayout {
  /// "block.state" or a single name; states of one block stand together in a marginal NEES.
  std::vector<std::string> states{};
  std::vector<bool> angles{};          ///< which states are angles (rad)
  std::vector<std::string> sensors{};  ///< names of the innovations; "" for a single one without a name
  std::vector<Index> sensor_dims{};    ///< the largest dimension of each
  bool has_truth = true;               ///< false: innovations alone
  /// false: the covariances between blocks are not known, so that only the NEES of each block is χ².
  bool joint_covariance = true;

  bool operator==(const FilterLogLayout&) const = default;
};

/// An innovation ν with its covariance S; empty when the sensor was silent.
struct FilterInnovation {
  Vector nu;
  Matrix S;
};

/// One step of one run.
struct FilterRow {
  std::int64_t step = 0;                      ///< from 1
  std::int64_t line = 0;                      ///< of its file
  std::vector<Index> states;                  ///< those with an estimate and a truth, ascending
  Vector error;                               ///< x̂ − x of these states, angles wrapped
  Matrix P;                                   ///< their covariance
  std::vector<FilterInnovation> innovations;  ///< one for each sensor
  std::string_view problem = {};              ///< why the row cannot be used, else empty
};

}  // namespace credence
