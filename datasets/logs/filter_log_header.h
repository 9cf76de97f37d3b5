#pragma once

#include <string_view>
#include <vector>

#include "core/record/run_layout.h"
#include "core/record/step.h"

/// @file
/// The first line of a log in the project's own format (docs/formats.md): which column holds what.

namespace credence::internal {

/// Where the numbers of a log stand; −1 for a column that is not there.
struct FilterLogHeader {
  /// One triangle or all of a symmetric matrix: columns of the entry (i, j), i ≤ j, and, where the matrix is
  /// full, of (j, i).
  struct Symmetric {
    std::vector<Index> upper;  ///< row by row
    std::vector<Index> lower;  ///< the same order transposed; −1 where only the upper triangle is there
  };
  struct Innovation {
    std::vector<Index> nu;  ///< of Sensor::nis_alone the one of NIS, without an S
    Symmetric S;
    Symmetric R;          ///< of all of nu, or of one observation of Sensor::piece components
    Index noise_dim = 0;  ///< of R; 0: it is not there
  };

  RunLayout layout;
  Index columns = 0;
  Index run = -1, step = -1, time = -1;
  Index nonlinear = -1, inflated = -1;  ///< of which the first row says what RunLayout says
  std::vector<Index> estimate, truth;   ///< of each state; truth is empty where no state has one
  std::vector<Index> error;             ///< of each state that has it in place of these
  Symmetric P;
  std::vector<Innovation> innovations;  ///< one for each sensor
};

/// Reads a header. Throws std::invalid_argument with the problem: an unknown, repeated or missing column, or
/// nothing to judge.
FilterLogHeader parse_filter_log_header(std::string_view line);

}  // namespace credence::internal
