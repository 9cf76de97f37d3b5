#pragma once

#include <string_view>
#include <vector>

#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence::internal {

/// Where the states of each block of a layout are in a step, whose states may be fewer.
struct StepPlaces {
  std::vector<Index> states{};                 ///< of the step
  std::vector<std::vector<Index>> of_block{};  ///< empty before the first step
  std::vector<Index> angles{};

  /// Does nothing where the states are those of the step before.
  void find(const std::vector<Index>& step_states, const RunLayout& layout);
};

/// The block of the position; −1: there is none.
Index position_block(const RunLayout& layout);

/// A pose in the plane and landmarks, each a block of its own.
bool has_planar_map(const RunLayout& layout);

/// Normalises the errors and innovations of steps by their covariances, over the range of each.
class StepNormaliser {
 public:
  /// Fills in `normalised` and returns why the step cannot be used, empty if it can: P or S is not positive
  /// semidefinite or not symmetric, or an error lies where P claims certainty.
  std::string_view normalise(const Step& step, const RunLayout& layout, const StepPlaces& places,
                             NormalisedStep& normalised);

 private:
  struct Solved {
    NormalisedVector of{};
    bool factorised = false;  ///< `solver` holds the factor of the covariance
    std::string_view problem = {};
    NeesSolver solver{};  ///< one of each kind of value, so that none changes its size
    BlockError block{};   ///< of the first block, of the position, and of blocks of some but not all states

    void clear();
    void normalise(const VectorRef& e, const MatrixRef& covariance);
    /// Of one state, with the same bits and without a matrix.
    void normalise(double e, double variance);
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
};

}  // namespace credence::internal
