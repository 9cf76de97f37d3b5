#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "montecarlo/engine/result_store_lock.h"
#include "montecarlo/engine/shown_experiment.h"

namespace credence::internal {

enum class RunLogFormat {
  csv,
  npz,
  mcap,  ///< the pose in the plane alone, with its truth
};

/// Removes the logs DIR/run-NNNNNN.csv, .npz and .mcap of the runs from `first` on.
void discard_logs(const std::filesystem::path& directory, std::int64_t first);

/// A folder of logs that no other process writes into; leaves nothing of the lock behind.
struct HeldFolder {
  explicit HeldFolder(const std::filesystem::path& directory) : file(directory / "run.lock"), lock(file) {}
  ~HeldFolder();
  HeldFolder(const HeldFolder&) = delete;
  HeldFolder& operator=(const HeldFolder&) = delete;

  std::filesystem::path file;
  ResultStoreLock lock;
};

/// An experiment that writes a log of every run, DIR/run-000000.csv …, .npz or .mcap, and takes NEES and NIS
/// of what is written, by the code of `credence check`: so both give the same numbers.
///
/// Linear worlds take NEES and NIS from a vectorised kernel otherwise, whose rounding differs in the last
/// digits.
class LoggedExperiment final : public ShownExperiment {
 public:
  /// `inner` must outlive this. Makes the folder, and holds it for as long as this lives; throws OutputError
  /// when it cannot, or when it holds logs of runs (which `credence check` would mix with the new ones); with
  /// `fresh` these are removed. Throws StoreError where another process writes logs there, and
  /// ScenarioError for mcap of a world without a pose in the plane. step_s: the time of a step, s; 0 where
  /// there is none, and a bag has a step each second.
  LoggedExperiment(const Experiment& inner, std::filesystem::path directory, RunLogFormat format, bool fresh,
                   double step_s);

  Outcome visit(std::int64_t run, const StepVisitor& take) const override { return inner_.visit(run, take); }
  std::int64_t runs_side_by_side() const override { return inner_.runs_side_by_side(); }
  std::vector<Outcome> visit_runs(std::int64_t first_run, std::int64_t runs,
                                  const RunsVisitor& take) const override {
    return inner_.visit_runs(first_run, runs, take);
  }
  RunTrace describe_world() const override { return inner_.describe_world(); }

 private:
  StudyStatistics play(std::int64_t first_run, std::int64_t runs, ChunkObserver* observer) const override;

  const Experiment& inner_;
  std::filesystem::path directory_;
  RunLogFormat format_;
  double step_s_;
  std::optional<HeldFolder> held_;
};

}  // namespace credence::internal
