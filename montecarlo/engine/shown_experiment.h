#pragma once

#include <optional>

#include "montecarlo/engine/experiment.h"

namespace credence::internal {

/// An experiment that shows the steps of a chunk while it runs it.
class ShownExperiment : public Experiment {
 public:
  using Experiment::Experiment;

  StudyStatistics run_chunk(std::int64_t first_run, std::int64_t runs) const final {
    return play(first_run, runs, nullptr);
  }
  bool shows_as_it_runs() const final { return true; }
  std::optional<StudyStatistics> show_chunk(std::int64_t first_run, std::int64_t runs,
                                            ChunkObserver& observer) const final {
    return play(first_run, runs, &observer);
  }

 private:
  /// Runs a chunk; the observer, if there is one, sees its steps, and changes no bit.
  virtual StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const = 0;
};

}  // namespace credence::internal
