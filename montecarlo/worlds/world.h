#pragma once

#include <memory>
#include <optional>
#include <string>

#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/estimator_contest.h"
#include "montecarlo/worlds/linear/linear_problem.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence::internal {

struct WorldStream;

/// The figure of a single run.
enum class RunFigure {
  line_slam,   ///< a vehicle on a line and its landmarks
  plane_slam,  ///< paths, landmarks and ellipses in the plane
  states,      ///< the error of every state with its 2σ
};

/// One kind of world: all that anyone needs to know of it. It states this in a folder of its own, and the
/// registry lists it.
struct World {
  WorldSchema schema;

  /// The linear problem that the scenario is, from which its experiment, the exact moments, `stability` and
  /// the Riccati equation follow; null or nothing where it is not linear.
  std::optional<LinearProblem> (*linear_problem)(const Scenario&) = nullptr;
  /// The experiment of a scenario that is not linear; null where there is none. Throws std::invalid_argument
  /// for what cannot be made.
  std::unique_ptr<Experiment> (*experiment)(const Scenario&) = nullptr;
  /// Doubles that the experiment keeps at the least, beside what is kept of any study; null: none worth it.
  double (*least_doubles)(const Scenario&) = nullptr;
  /// The keys and values on which that depends: "world.landmarks = 3"; null where least_doubles is.
  std::string (*size_text)(const Scenario&) = nullptr;
  /// A few words on the world of a scenario, for reports.
  std::string (*text)(const Scenario&);
  RunFigure figure;
  /// The estimators that `credence estimators` compares; null where there are none.
  const EstimatorOffer* estimators = nullptr;
  /// What no filter's error is below; null of linear worlds, where the exact moments say more, and where it
  /// is not known. Takes seconds at most, and asks stop_point().
  PosteriorBound (*posterior_bound)(const Scenario&) = nullptr;
  /// What it tells a filter in another program; null: what its experiment shows, where that is one vector.
  WorldStream (*stream)(const Scenario&) = nullptr;
};

}  // namespace credence::internal
