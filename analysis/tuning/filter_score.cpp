#include "analysis/tuning/filter_score.h"

#include <stdexcept>
#include <utility>

#include "core/parallel_tasks.h"
#include "core/stop_point.h"

namespace credence {

FilterScore::FilterScore(std::vector<FilterFactor> factors, Make make, std::int64_t runs, int threads,
                         const std::atomic<bool>* stop)
    : BlackBoxScore(std::move(factors)), make_(std::move(make)), runs_(runs), threads_(threads), stop_(stop) {
  if (runs_ < 1) throw std::invalid_argument("there is no run to tune on");
}

UnitScores FilterScore::play(const std::vector<double>& factors) const {
  const std::unique_ptr<Experiment> experiment = make_(factors);
  std::vector<ScoreSum> runs(static_cast<std::size_t>(runs_));
  for_each_task(runs_, threads_, stop_, [&](std::int64_t i) {
    ScoreSum& run = runs[static_cast<std::size_t>(i)];
    const Outcome outcome = experiment->visit(i, [&](const TraceStep& step) {
      for (const Innovation& innovation : step.innovations) {
        if (step.step > 0 && innovation.nu.size() > 0) run.add(innovation.nu, innovation.S);
      }
    });
    if (outcome != Outcome::ok) run.spoil();
  });
  if (stop_ != nullptr && stop_->load()) throw Stopped{};
  return unit_scores(runs);
}

}  // namespace credence
