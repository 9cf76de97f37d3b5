#include "analysis/tuning/filter_score.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence::internal {

FilterScore::FilterScore(std::vector<FilterFactor> factors, Make make, std::int64_t runs, int threads,
                         const std::atomic<bool>* stop)
    : BlackBoxScore(std::move(factors)), make_(std::move(make)), runs_(runs), threads_(threads), stop_(stop) {
  if (runs_ < 1) throw std::invalid_argument("there is no run to tune on");
}

UnitScores FilterScore::play(const std::vector<double>& factors) const {
  const std::unique_ptr<Experiment> experiment = make_(factors);
  std::vector<ScoreSum> runs(static_cast<std::size_t>(runs_));
  const std::int64_t at_a_time = experiment->runs_side_by_side();
  const std::int64_t tasks = (runs_ + at_a_time - 1) / at_a_time;
  for_each_task(tasks, threads_, stop_, [&](std::int64_t task) {
    const std::int64_t first = task * at_a_time, count = std::min(at_a_time, runs_ - first);
    const std::vector<Outcome> outcomes =
        experiment->visit_runs(first, count, [&](std::int64_t i, const TraceStep& step) {
          if (step.step == 0) return;
          ScoreSum& run = runs[static_cast<std::size_t>(i)];
          std::size_t heard = 0;
          for (std::size_t sensor = 0; sensor < step.innovations.size(); ++sensor) {
            const Innovation& innovation = step.innovations[sensor];
            if (innovation.nu.size() == 0) continue;
            run.add(innovation.nu, innovation.S, sensor);
            ++heard;
          }
          if (heard > 1) run.join(heard);
        });
    for (std::int64_t i = 0; i < count; ++i) {
      if (outcomes[static_cast<std::size_t>(i)] != Outcome::ok)
        runs[static_cast<std::size_t>(first + i)].spoil();
    }
    played_.add_part_of(tasks);
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  return unit_scores(runs);
}

}  // namespace credence::internal
