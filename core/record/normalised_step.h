#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "core/nan.h"
#include "core/types.h"

/// @file
/// What a step shows (step.h) once its errors and innovations are normalised by their covariances. Whoever
/// has the Cholesky factors of P and S at hand fills it in; of other steps they are computed.

namespace credence::internal {

/// eᵀ C⁻¹ e of some error and its covariance.
struct NormalisedSquare {
  double value = 0.0;
  Index dof = -1;  ///< −1: there was none
};

/// Whitened as u = L⁻¹ e, C = L Lᵀ.
struct NormalisedVector : NormalisedSquare {
  Vector whitened{};  ///< `dof` numbers
};

/// An innovation.
struct NormalisedInnovation : NormalisedVector {
  Vector nu{}, variance{};    ///< ν and the diagonal of S; empty where NIS alone is known
  Vector covariance{};        ///< S_pq, q < p, row by row, of each piece (Sensor::piece) one after the other
  double noise_share = kNaN;  ///< tr(S⁻¹ R)/m, where R is known
  bool complete = true;       ///< as Innovation::complete
};

/// A block's error with its covariance.
struct BlockError {
  Vector error{};
  Matrix P{};
};

/// What of a step is looked at for lateness (laws/lateness.h): some of its states.
struct MovingPart : BlockError {
  std::vector<Index> places{};  ///< in the step; empty: there is nothing to look at
};

/// Of `count` landmarks the known one that is looked at in a step, another one each time; −1: none is known.
template <typename Known>
Index landmark_in_turn(std::int64_t step, Index count, Known known) {
  for (Index i = 0; i < count; ++i) {
    const Index landmark = (i + step) % count;
    if (known(landmark)) return landmark;
  }
  return -1;
}

/// Whether NEES of n numbers is checked by a factor of P at this step of a run, whoever plays it: up to
/// twelve numbers always, else at the powers of two, at every sixteenth step and at the last.
constexpr bool is_checked(Index n, std::int64_t step, std::int64_t last) {
  return n <= 12 || step % 16 == 0 || step == last || std::has_single_bit(static_cast<std::uint64_t>(step));
}

/// The largest state whose covariance a step tells.
inline constexpr Index kLargestTold = 60;

/// One step of one run.
struct NormalisedStep {
  std::int64_t step = 0;        ///< from 1
  std::int64_t line = 0;        ///< as Step::line
  std::vector<Index> states{};  ///< as Step::states
  Vector error{}, variance{};   ///< of these states
  Vector estimate{};            ///< x̂ of these states, in coordinates; empty: not known
  MovingPart moving{};          ///< of a map in the plane the pose and one landmark
  /// Of these states, its lower triangle; empty where it is not known or of more than kLargestTold states,
  /// and perhaps at other steps than those of is_checked.
  Matrix P{};
  NormalisedSquare whole{};                ///< its dof is the sum over blocks without a joint covariance
  double log_determinant = kNaN;           ///< of P of full rank
  std::vector<NormalisedSquare> blocks{};  ///< of the layout
  /// States of the layout that have an error where P claims certainty: they are judged as if they had none.
  std::vector<Index> wrongly_certain{};
  BlockError lead{}, position{};                    ///< of the block that leads, and of that of the position
  std::vector<NormalisedInnovation> innovations{};  ///< one for each sensor
};

}  // namespace credence::internal
