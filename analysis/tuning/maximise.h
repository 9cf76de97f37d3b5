#pragma once

#include <vector>

#include "analysis/tuning/score_model.h"

namespace credence::internal {

/// Where a sum of log scores is sought.
struct SearchBox {
  Vector lower, upper;  ///< of φ
};

/// The highest point that was found.
struct Maximum {
  Vector phi;
  double value = 0.0;  ///< sum of the scores there
  bool ok = false;     ///< false: the scores at the start are none, and the other members mean nothing
};

/// The maximum over the coordinates with `free`, the others staying at `start`, by NLopt: sequential
/// quadratic programming [Kraft 1994] where the model has a gradient, else bound optimisation by quadratic
/// approximation [Powell 2009]. A point without scores counts as lower than all that have
/// some; where there was one, the search begins again from the best, with half the step, while that gains.
///
/// scale: by how much each coordinate has to move for the sum to change by about 1; the search ends where
/// nothing moves by a thousandth of it. Throws std::invalid_argument for a start outside the box, and what
/// the model throws.
Maximum maximise(const ScoreFunction& model, const Vector& start, const SearchBox& box,
                 const std::vector<bool>& free, const Vector& scale);

}  // namespace credence::internal
