#pragma once

#include <string_view>
#include <vector>

#include "core/linear_algebra/small_cholesky.h"
#include "core/record/nees_solver.h"
#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"

namespace credence::internal {

/// Where the states of each block of a layout are in a step, whose states may be fewer.
struct StepPlaces {
  std::vector<Index> states{};                 ///< of the step
  std::vector<std::vector<Index>> of_block{};  ///< empty before the first step
  std::vector<Index> angles{};
  Index lead = -1, position = -1;  ///< lead_block, position_block

  /// Does nothing where the states are those of the step before.
  void find(const std::vector<Index>& step_states, const RunLayout& layout);
};

/// The block of the position; −1: there is none.
Index position_block(const RunLayout& layout);

/// The block that is looked at where the whole state is too large, or has a vehicle: the pose, else the
/// position, else that with most states of at most 24, of several the first by name; −1: there is none.
Index lead_block(const RunLayout& layout);

/// A pose in the plane and landmarks, each a block of its own.
bool has_planar_map(const RunLayout& layout);

/// Why a step cannot be used whose error lies where P claims certainty.
inline constexpr std::string_view kClaimedCertainty = "an error where the covariance claims certainty";

/// Normalises the errors and innovations of steps by their covariances, over the range of each.
class StepNormaliser {
 public:
  /// Fills in `normalised` and returns why the step cannot be used, empty if it can: its own problem, or P or
  /// S is not positive semidefinite or not symmetric, or an error lies where P claims certainty, in a
  /// direction that is not of single states.
  std::string_view normalise(const Step& step, const RunLayout& layout, const StepPlaces& places,
                             NormalisedStep& normalised);

  /// The factor of P of the last step, of no more states than it takes; null where there is none, or where
  /// not the P of the step was judged.
  const SmallCholesky* factor_of_state() const {
    const bool as_it_is = certain_.empty() && wrong_.empty();
    return state_.factorised && !state_.wide && as_it_is ? &state_.factor : nullptr;
  }

 private:
  struct Solved {
    NormalisedVector of{};
    bool factorised = false;  ///< the covariance: by `factor`, or by `solver` where it is wide
    bool wide = false;        ///< of more states than `factor` takes
    std::string_view problem = {};
    SmallCholesky factor{};  ///< one of each kind of value, so that none changes its size
    NeesSolver solver{};     ///< likewise
    BlockError block{};  ///< of blocks of some but not all states, but the one that leads and the position

    void clear();
    void normalise(const VectorRef& e, const MatrixRef& covariance);
    /// The same, with the factor of S in `solver`.
    void normalise_innovation(const VectorRef& nu, const MatrixRef& S);
    double log_determinant() const;
    /// Of one state, with the same bits and without a matrix.
    void normalise(double e, double variance);

   private:
    /// False where a pivot is none, or no more than rounding.
    bool factor_by_solver(const VectorRef& e, const MatrixRef& covariance);
    /// The same arithmetic without what the solver copies.
    bool factor_few(const VectorRef& e, const MatrixRef& covariance);
    void normalise_by_rank(const VectorRef& e, const MatrixRef& covariance);
  };

  std::string_view normalise_state(const Step& step, const RunLayout& layout, const StepPlaces& places,
                                   NormalisedStep& normalised);
  std::string_view normalise_known(const Step& step, const RunLayout& layout, const StepPlaces& places,
                                   NormalisedStep& normalised);
  /// The pose and one landmark; without a map the position, or a state without one, unless it is large.
  static void take_moving(const Step& step, const RunLayout& layout, const StepPlaces& at,
                          NormalisedStep& normalised);
  std::string_view normalise_innovations(const Step& step, const RunLayout& layout,
                                         NormalisedStep& normalised);

  Solved state_;
  std::vector<Solved> blocks_, innovations_;
  std::vector<Index> certain_;  ///< states of the step that are known to the rounding of their estimate
  std::vector<Index> wrong_;    ///< that have an error where P claims certainty
};

}  // namespace credence::internal
