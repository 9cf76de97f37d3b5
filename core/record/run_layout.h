#pragma once

#include <string>
#include <vector>

#include "core/types.h"

/// @file
/// What the steps of a run have in common. Whoever produces the steps writes it once, and nobody guesses it
/// from dimensions or names.

namespace credence::internal {

/// Landmarks with a block of their own, the first by number; beyond that only all together.
inline constexpr Index kSingleLandmarks = 50;

}  // namespace credence::internal

namespace credence {

/// What a block of states is to a report.
enum class Part { other, pose, position, heading, landmark, map };

/// Some states that are judged together, beside the whole.
struct Block {
  std::string name;
  Part part = Part::other;
  std::vector<Index> states;  ///< of the layout; ascending, but in the plane x, y and heading

  bool operator==(const Block&) const = default;
};

/// A source of innovations.
struct Sensor {
  std::string name;  ///< "" for the only one
  Index dim = 0;     ///< the largest dimension of an innovation
  /// An innovation may be taken apart into pieces of this dimension, of one landmark each; `dim` where not.
  Index piece = 0;
  /// Variances of a piece of the measurement that the filter assumes; empty: not known.
  std::vector<double> variances{};
  std::vector<bool> angles{};  ///< which components of a piece are angles (rad); empty: none
  /// νᵀS⁻¹ν alone is known, neither ν nor S: steps hold nis_alone().
  bool nis_alone = false;
  bool variances_alone = false;  ///< of S the variances are known, and no covariances

  bool operator==(const Sensor&) const = default;
};

/// The states, blocks and sensors of a run. A step may have fewer states: those not yet initialised.
struct RunLayout {
  std::vector<std::string> states{};  ///< "block.state" or a single name
  std::vector<bool> angles{};         ///< which states are angles (rad)
  std::vector<std::string> units{};   ///< of the states, "m", "m/s"; empty, or "" for one: not known
  std::vector<Block> blocks{};
  std::vector<Sensor> sensors{};
  Index landmark_dim = 0;  ///< of a landmark of Part::map; 0: there is none
  bool has_truth = true;   ///< false: innovations alone
  /// false: the covariances between blocks are not known, so that only the NEES of each block is χ².
  bool joint_covariance = true;
  bool nonlinear = false;  ///< the filter is known to linearise at its own estimates
  bool inflated = false;   ///< the filter is known to inflate its covariance on purpose
  /// An error is the difference of the coordinates of estimate and truth, of angles wrapped.
  bool componentwise = true;

  bool operator==(const RunLayout&) const = default;
};

/// Writes the blocks of states that are named "block.state": one for each name before the dot. A block
/// "vehicle" of x, y and an angle, wherever these stand, is a pose and gives a block of its position and of
/// its heading too; blocks "landmark…" of one dimension are the map, of which the first kSingleLandmarks have
/// a block of their own. Vehicle and landmarks are in metres where the layout names no units.
void add_named_blocks(RunLayout& layout);

}  // namespace credence

namespace credence::internal {

/// The unit that these states have in common: "rad" of angles, else what the layout says; "" where one is not
/// known, or where they differ.
std::string unit_of_states(const RunLayout& layout, const std::vector<Index>& states);

/// Why states "vehicle.…" are no pose or position, and what would be one, in a sentence; empty where they are
/// one, or there are none.
std::string no_pose_sentence(const RunLayout& layout);

}  // namespace credence::internal
