#include "app/log_judge.h"

#include <tbb/global_control.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "datasets/data_error.h"
#include "datasets/filter_log.h"
#include "montecarlo/engine.h"

namespace credence {
namespace {

constexpr std::size_t kGroupFiles = static_cast<std::size_t>(kChunkRuns);

/// The sums of one group of files, in chunks of kChunkRuns runs, or why there are none.
struct Group {
  std::vector<LogStatistics> chunks;
  std::size_t files = 0;
  std::exception_ptr error;
};

/// How many bytes all workers have read.
class ByteCount {
 public:
  explicit ByteCount(const LogJudgeOptions& options) : options_(options) {}

  void advance(std::int64_t bytes) {
    const std::int64_t now = bytes_ += bytes;
    if (!options_.progress) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock) options_.progress(now);
  }

 private:
  const LogJudgeOptions& options_;
  std::atomic<std::int64_t> bytes_{0};
  std::mutex mutex_;
};

Outcome outcome_named(const std::string& name) {
  return name == to_string(Outcome::diverged) ? Outcome::diverged : Outcome::not_positive_definite;
}

Group read_group(std::span<const std::filesystem::path> files, const LogFileReader& read, ByteCount& bytes) {
  Group group;
  LogAccumulator sums;
  try {
    for (const std::filesystem::path& file : files) {
      read(file, sums, [&](std::int64_t more) { bytes.advance(more); });
      for (LogStatistics& chunk : sums.take_chunks()) group.chunks.push_back(std::move(chunk));
    }
    group.chunks.push_back(sums.take());
  } catch (...) {
    group.error = std::current_exception();
  }
  group.files = files.size();
  return group;
}

}  // namespace

void read_own_log(const std::filesystem::path& file, LogAccumulator& sums,
                  const std::function<void(std::int64_t)>& advance) {
  constexpr std::int64_t kRowsBetween = 4096;
  FilterLogReader reader(file);
  sums.begin_file(file, reader.layout());
  FilterRow row;
  std::int64_t rows = 0, told = 0;
  bool open = false;
  const auto end_failed = [&] {
    if (!reader.failure()) return;
    if (!open) sums.begin_run();  // it failed before its first row
    sums.end_run(outcome_named(reader.failure()->outcome), reader.failure()->step);
    open = false;
  };
  while (reader.next(row)) {
    if (reader.run_began()) {
      end_failed();
      sums.begin_run();
      open = true;
    }
    sums.add(row);
    if (++rows % kRowsBetween == 0) {
      advance(reader.bytes_read() - told);
      told = reader.bytes_read();
    }
  }
  end_failed();
  advance(reader.bytes_read() - told);
}

LogJudgeResult judge_logs(std::span<const std::filesystem::path> files, const LogFileReader& read,
                          const LogJudgeOptions& options) {
  const int threads = options.threads > 0
                          ? options.threads
                          : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  ByteCount bytes(options);
  LogJudgeResult result;
  std::exception_ptr error;
  std::atomic<bool> failed{false};
  std::size_t next = 0;
  // TBB hands a group from stage to stage, which a thread sanitizer does not see; the lock it does.
  std::mutex handover;

  const auto take_files = [&](tbb::flow_control& control) -> std::span<const std::filesystem::path> {
    const std::lock_guard lock(handover);
    const bool stopped = options.stop != nullptr && options.stop->load(std::memory_order_relaxed);
    if (next == files.size() || stopped || failed.load()) {
      result.complete = result.complete && !stopped;
      control.stop();
      return {};
    }
    const std::size_t count = std::min(kGroupFiles, files.size() - next);
    next += count;
    return files.subspan(next - count, count);
  };
  const auto read_files = [&](std::span<const std::filesystem::path> group) {
    auto read_one = std::make_shared<Group>(read_group(group, read, bytes));
    const std::lock_guard lock(handover);
    return read_one;
  };
  const auto merge = [&](const std::shared_ptr<Group>& group) {
    const std::lock_guard lock(handover);
    if (error) return;
    error = group->error;
    failed.store(error != nullptr);
    if (error) return;
    for (LogStatistics& chunk : group->chunks) result.statistics.merge(std::move(chunk));
    result.files += static_cast<std::int64_t>(group->files);
  };
  tbb::task_arena arena(threads);
  arena.execute([&] {
    using tbb::filter_mode;
    tbb::parallel_pipeline(
        2 * static_cast<std::size_t>(threads),
        tbb::make_filter<void, std::span<const std::filesystem::path>>(filter_mode::serial_in_order,
                                                                       take_files) &
            tbb::make_filter<std::span<const std::filesystem::path>, std::shared_ptr<Group>>(
                filter_mode::parallel, read_files) &
            tbb::make_filter<std::shared_ptr<Group>, void>(filter_mode::serial_in_order, merge));
  });
  const std::lock_guard lock(handover);
  if (error) std::rethrow_exception(error);
  return result;
}

std::vector<std::filesystem::path> log_files(std::span<const std::string> arguments) {
  std::vector<std::filesystem::path> files;
  for (const std::string& argument : arguments) {
    if (!std::filesystem::is_directory(argument)) {
      files.emplace_back(argument);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(argument)) {
      if (entry.path().extension() == ".csv") inside.push_back(entry.path());
    }
    if (inside.empty()) throw DataError(argument, "", "the folder holds no *.csv");
    std::ranges::sort(inside);
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

}  // namespace credence
