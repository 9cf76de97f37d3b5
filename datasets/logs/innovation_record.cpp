#include "datasets/logs/innovation_record.h"

#include <algorithm>
#include <string>
#include <utility>

#include "analysis/evidence/sums/whole_turns.h"
#include "core/linear_algebra/cholesky.h"
#include "core/record/unwrapped_angles.h"
#include "core/stop_point.h"
#include "datasets/logs/run_fingerprints.h"
#include "datasets/logs/run_name.h"

namespace credence::internal {
namespace {

class InnovationSink final : public LogSink {
 public:
  void begin_file(const std::filesystem::path& file) {
    fingerprints_.begin_file(file);
    number_.begin_file();
  }
  void end_file() {
    if (number_.alone()) fingerprints_.name_by_file();
  }
  void run_number(const std::string& number) override { number_.tell(number); }
  void begin_run(const RunLayout& layout) override {
    fingerprints_.begin_run(number_.next());
    close_run();
    of_layout_.clear();
    sensors_ = layout.sensors;
    turns_.resize(sensors_.size());
    for (const Sensor& sensor : layout.sensors) {
      auto found = std::ranges::find(records_, sensor.name, &SensorRecord::name);
      if (found == records_.end()) {
        records_.push_back({.name = sensor.name, .runs = {}});
        dims_.push_back(0);
        found = records_.end() - 1;
      }
      found->runs.emplace_back();
      of_layout_.push_back(static_cast<std::size_t>(found - records_.begin()));
    }
  }

  void add(const Step& step) override {
    stop_point();
    fingerprints_.add(step);
    if (!step.problem.empty()) return;
    for (std::size_t s = 0; s < std::min(step.innovations.size(), of_layout_.size()); ++s) {
      const std::size_t sensor = of_layout_[s];
      if (step.innovations[s].nu.size() == 0) continue;
      if (sensors_[s].nis_alone) {
        ++records_[sensor].left_out;
      } else {
        add(step.innovations[s], sensors_[s], records_[sensor], turns_[s], dims_[sensor]);
      }
    }
  }

  void end_run(Outcome, std::int64_t) override {}
  void remark(std::string) override {}
  void unmatched(std::int64_t) override {}
  void advance(std::int64_t) override {}

  /// Without empty runs and silent sensors. Throws DataError for a run that is there twice.
  std::vector<SensorRecord> take() {
    fingerprints_.require_distinct();
    close_run();
    for (std::size_t i = 0; i < records_.size(); ++i) {
      std::vector<RecordedInnovations>& runs = records_[i].runs;
      std::erase_if(runs, [](const RecordedInnovations& run) { return run.nis.empty(); });
      for (RecordedInnovations& run : runs) run.dof = static_cast<double>(dims_[i]);
    }
    std::erase_if(records_, [](const SensorRecord& record) { return record.runs.empty(); });
    return std::move(records_);
  }

 private:
  /// What is a turn off in the run that is open.
  void close_run() {
    for (std::size_t s = 0; s < turns_.size(); ++s) {
      SensorRecord& record = records_[of_layout_[s]];
      add_run(turns_[s], std::ssize(record.runs.back().nis), record.turns);
    }
    turns_.clear();
  }

  static void add(const Innovation& innovation, const Sensor& sensor, SensorRecord& record,
                  std::vector<WholeTurns>& turns, Index& dim) {
    const Eigen::LLT<Matrix> llt(innovation.S);
    if (!innovation.complete || (dim > 0 && dim != innovation.nu.size()) || !innovation.nu.allFinite() ||
        !innovation.S.allFinite() || llt.info() != Eigen::Success) {
      ++record.left_out;
      return;
    }
    dim = innovation.nu.size();
    record.unwrapped += count_unwrapped(innovation.nu, sensor.angles);
    add_turns(innovation.nu, innovation.S.diagonal(), sensor.piece, sensor.angles, turns);
    const Vector whitened = llt.matrixL().solve(innovation.nu);
    record.runs.back().nis.push_back(whitened.squaredNorm());
    record.runs.back().whitened.push_back(whitened);
    record.log_determinant += 2.0 * llt.matrixLLT().diagonal().array().log().sum();
  }

  RunFingerprints fingerprints_;
  RunNumber number_;
  std::vector<SensorRecord> records_;
  std::vector<Index> dims_;                     ///< of each record; 0 before its first innovation
  std::vector<std::vector<WholeTurns>> turns_;  ///< of each sensor of the run
  std::vector<Sensor> sensors_;                 ///< of the run
  std::vector<std::size_t> of_layout_;          ///< their records
};

}  // namespace

std::vector<SensorRecord> read_innovations(std::span<const std::filesystem::path> files,
                                           const LogFileReader& read) {
  InnovationSink sink;
  for (const std::filesystem::path& file : files) {
    sink.begin_file(file);
    read(file, sink);
    sink.end_file();
  }
  return sink.take();
}

}  // namespace credence::internal
