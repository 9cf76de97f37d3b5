#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "montecarlo/worlds/estimator_contest.h"

namespace credence::internal {

/// What contest_player makes.
template <class Simulation, class Run, class Judge>
class ContestPlayer final : public EstimatorPlayer {
 public:
  ContestPlayer(const EstimatorContest& contest, Simulation simulation, std::vector<Run> runs, Judge judge)
      : contest_(contest),
        simulation_(std::move(simulation)),
        runs_(std::move(runs)),
        judge_(std::move(judge)) {}

  void play(std::int64_t run, EstimatorListener& listener) override {
    const auto estimate = simulation_.start(run);
    for (Run& each : runs_) each.start(estimate);
    std::vector<bool> stopped(runs_.size());
    for (Index k = 1; k <= contest_.steps(); ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto read = simulation_.read(at);
      const auto seen = simulation_.observe(at);
      const bool with_map = k % contest_.map_stride() == 0;
      for (std::size_t e = 0; e < runs_.size(); ++e) {
        if (stopped[e]) continue;
        const Outcome outcome = runs_[e].step(at, read, seen);
        if (outcome != Outcome::ok) listener.failed(e, k, outcome);
        stopped[e] = outcome != Outcome::ok || !listener.take(e, k, judge_(e, runs_[e], with_map));
      }
    }
  }

 private:
  const EstimatorContest& contest_;
  Simulation simulation_;
  std::vector<Run> runs_;
  Judge judge_;
};

/// Plays estimators, each a `Run` that hears the same simulation; `judge(e, run, with_map)` tells what is
/// judged of a step of estimator e. `contest` must live as long.
template <class Simulation, class Run, class Judge>
std::unique_ptr<EstimatorPlayer> contest_player(const EstimatorContest& contest, Simulation simulation,
                                                std::vector<Run> runs, Judge judge) {
  return std::make_unique<ContestPlayer<Simulation, Run, Judge>>(contest, std::move(simulation),
                                                                 std::move(runs), std::move(judge));
}

}  // namespace credence::internal
