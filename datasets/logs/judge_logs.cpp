#include "datasets/logs/judge_logs.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <set>
#include <utility>

#include "core/parallel_tasks.h"
#include "datasets/data_error.h"
#include "datasets/logs/filter_log.h"
#include "montecarlo/engine/engine.h"

namespace credence {
namespace {

constexpr std::size_t kGroupFiles = static_cast<std::size_t>(kChunkRuns);

/// The sums of one group of files, in chunks of kChunkRuns runs, or why there are none (Stopped among them).
struct Group {
  std::vector<Evidence> chunks;
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
  EvidenceRecorder sums;
  try {
    for (const std::filesystem::path& file : files) {
      read(file, sums, [&](std::int64_t more) { bytes.advance(more); });
      for (Evidence& chunk : sums.take_chunks()) group.chunks.push_back(std::move(chunk));
    }
    group.chunks.push_back(sums.take());
  } catch (...) {
    group.error = std::current_exception();
  }
  group.files = files.size();
  return group;
}

}  // namespace

void read_own_log(const std::filesystem::path& file, EvidenceRecorder& sums,
                  const std::function<void(std::int64_t)>& advance) {
  constexpr std::int64_t kRowsBetween = 4096;
  FilterLogReader reader(file);
  sums.begin_file(file, reader.layout());
  Step row;
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
  ByteCount bytes(options);
  LogJudgeResult result;
  std::mutex mutex;
  std::condition_variable turn;
  std::int64_t merged = 0;  // groups
  bool failed = false;
  const auto groups = static_cast<std::int64_t>((files.size() + kGroupFiles - 1) / kGroupFiles);
  for_each_task(groups, options.threads, options.stop, [&](std::int64_t i) {
    const std::size_t first = static_cast<std::size_t>(i) * kGroupFiles;
    Group group = read_group(files.subspan(first, std::min(kGroupFiles, files.size() - first)), read, bytes);
    // Groups are begun in their order, so all before this one are being read or merged.
    std::unique_lock lock(mutex);
    turn.wait(lock, [&] { return merged == i || failed; });
    if (failed) return;
    failed = group.error != nullptr;
    turn.notify_all();
    if (failed) std::rethrow_exception(group.error);
    for (Evidence& chunk : group.chunks) result.evidence.merge(std::move(chunk));
    result.files += static_cast<std::int64_t>(group.files);
    ++merged;
    turn.notify_all();
  });
  result.complete = merged == groups;
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
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    const auto one = std::filesystem::canonical(file, error);
    if (!error && !seen.insert(one).second) {
      throw DataError(file, "", "is named twice: its runs would be counted twice");
    }
  }
  return files;
}

}  // namespace credence
