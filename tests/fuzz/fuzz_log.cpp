#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "datasets/data_error.h"
#include "datasets/logs/autopilot/ulog_states.h"
#include "datasets/logs/log_format.h"

/// @file
/// The entry of libFuzzer for the format CREDENCE_FUZZ_FORMAT: any bytes give runs, or one error of the two
/// kinds that a user may see; everything else is a finding.

namespace credence::internal {
namespace {

/// Requires of what it takes that the judging code can rely on it.
class RequiringSink final : public LogSink {
 public:
  void begin_run(const RunLayout& layout) override { states_ = layout.states.size(); }
  void add(const Step& step) override {
    for (const Index state : step.states) {
      if (static_cast<std::size_t>(state) >= states_) std::abort();
    }
    if (step.P.rows() != step.P.cols() || step.error.size() != step.P.rows()) std::abort();
  }
  void end_run(Outcome, std::int64_t) override {}
  void remark(std::string) override {}
  void unmatched(std::int64_t) override {}
  void advance(std::int64_t) override {}

 private:
  std::size_t states_ = 0;
};

/// A file in memory, of this process.
std::filesystem::path memory_file(const char* name) {
  return "/dev/shm/credence-fuzz-" + std::to_string(getpid()) + "-" + name;
}

void write(const std::filesystem::path& file, const char* bytes, std::size_t size) {
  std::ofstream(file, std::ios::binary).write(bytes, static_cast<std::streamsize>(size));
}

/// Two truths: poses, and a survey point.
std::filesystem::path truth_of(std::string_view format) {
  const std::filesystem::path file = memory_file("truth");
  std::string text;
  if (format == "rtklib") {
    text =
        "%  GPST  e-baseline(m) n-baseline(m) u-baseline(m) Q ns sde(m) sdn(m) sdu(m) sden(m) sdnu(m) "
        "sdue(m) age(s) ratio\n"
        "2020/01/01 00:00:00.000 1 2 3 1 9 0.01 0.01 0.02 0 0 0 0 9\n";
  } else {
    for (int i = 0; i < 40; ++i) text += std::to_string(i) + " 1 2 3 0 0 0 1\n";
  }
  write(file, text.data(), text.size());
  return file;
}

LogReading options_of(const LogFormat& format, const std::filesystem::path& file) {
  LogReading options;
  options.matching.max_time_difference_s = 1.0;
  if (format.name == "mcap" || format.name == "db3" || format.name == "rosbag") {
    options.truth_topic = "/truth";
  } else if (format.takes_truth) {
    options.truth = TruthFiles(std::span(&file, 1), {truth_of(format.name).string()});
  }
  return options;
}

/// In seven of eight inputs the poses are taken as planar, whose conventions are not looked at: that costs
/// more than the reading.
LogReading options_for(LogReading options, const LogFormat& format, std::size_t size) {
  constexpr std::size_t kConventionsIn = 8;
  const bool poses = format.has_poses && format.name != "openvins" && format.name != "cnspy";
  if (poses && size % kConventionsIn != 0) options.chart = pose_chart_of(OrientationError::planar);
  return options;
}

template <class Read>
void allowed_to_fail(Read read) {
  try {
    read();
  } catch (const DataError&) {
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace
}  // namespace credence::internal

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace credence;
  using namespace credence::internal;
  static const LogFormat& format = log_format_named(CREDENCE_FUZZ_FORMAT);
  static const std::filesystem::path file = memory_file("input");
  static const LogReading all = options_of(format, file);
  const LogReading options = options_for(all, format, size);
  write(file, reinterpret_cast<const char*>(data), size);
  RequiringSink sink;
  allowed_to_fail([&] { log_format_of(file); });
  allowed_to_fail([&] { format.read(file, options, sink); });
  if (format.name == "ulog") {
    LogReading states = options;
    states.truth_topic = kUlogTruth;
    allowed_to_fail([&] { format.read(file, states, sink); });
  }
  allowed_to_fail([&] { format.list(file); });
  return 0;
}
