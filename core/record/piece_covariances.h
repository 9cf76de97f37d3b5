#pragma once

#include "core/types.h"

namespace credence::internal {

/// The covariances of every two components of a piece, by the lower triangle of S: S_10, S_20, S_21, … of
/// one piece after the other (Sensor::piece); keeps the memory of `covariances`.
inline void take_piece_covariances(const MatrixRef& S, Index piece, Vector& covariances) {
  const Index pieces = S.rows() / piece;
  covariances.resize(pieces * (piece * (piece - 1) / 2));
  Index at = 0;
  for (Index first = 0; first < pieces * piece; first += piece) {
    for (Index p = first; p < first + piece; ++p) {
      for (Index q = first; q < p; ++q) covariances[at++] = S(p, q);
    }
  }
}

}  // namespace credence::internal
