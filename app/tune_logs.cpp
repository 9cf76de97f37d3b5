#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "app/progress.h"
#include "app/tell.h"
#include "app/tune_command.h"
#include "datasets/logs/innovation_record.h"
#include "datasets/logs/log_format.h"
#include "datasets/logs/log_name.h"
#include "reports/document/tuning/log_tune_report.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

/// "a.csv", "a.csv and 2 more"
std::string names_of(const std::vector<fs::path>& files) {
  std::string names = files.front().string();
  if (files.size() > 1) names += fmt::format(" and {} more", files.size() - 1);
  return names;
}

}  // namespace

int tune_logs(const TuneOptions& options) {
  if (!options.write.empty() || !options.overrides().empty() || !options.free.empty()) {
    throw std::invalid_argument(
        "a log is no scenario: --free, --write, --set, --runs, --steps and --seed have no meaning for it");
  }
  const std::vector<fs::path> files = log_files(options.inputs);
  LogReading reading;
  reading.truth = TruthFiles(files, {});
  const std::vector<SensorRecord> records = [&] {
    const StepDisplay display("tune, reading", options.quiet, "rows");
    return read_innovations(
        files, [&](const fs::path& file, LogSink& sink) { log_format_of(file).read(file, reading, sink); });
  }();
  if (records.empty()) {
    throw std::invalid_argument(fmt::format(
        "{}: no innovations with their covariance, which are what a log is tuned by; check judges errors",
        names_of(files)));
  }
  std::vector<InnovationTuning> sensors;
  sensors.reserve(records.size());
  for (const SensorRecord& record : records)
    sensors.push_back(tune_innovations(record, kTuneConfidence, std::ssize(records)));
  const std::string name = log_name(options.inputs.front());
  tell(log_tune_document(name, sensors), options);
  const bool inconsistent = std::ranges::any_of(
      sensors, [](const InnovationTuning& t) { return is_inconsistent(t.left_out_parts.verdict); });
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

}  // namespace credence::internal
