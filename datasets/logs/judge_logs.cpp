#include "datasets/logs/judge_logs.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <iterator>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/evidence/sums/run_innovations.h"
#include "analysis/laws/shape/coverage.h"
#include "core/append_item.h"
#include "core/nan.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "datasets/data_error.h"
#include "datasets/logs/conventions/reading_fit.h"
#include "datasets/logs/conventions/step_conventions.h"
#include "datasets/logs/read_ahead.h"
#include "datasets/logs/run_fingerprints.h"
#include "datasets/logs/run_name.h"
#include "montecarlo/engine/engine.h"

namespace credence::internal {
namespace {

constexpr std::size_t kGroupFiles = static_cast<std::size_t>(kChunkRuns);

/// The states of a file, but those of landmarks, of which each run may see others; in order.
struct FileStates {
  std::filesystem::path file;
  std::vector<std::string> names;
};

std::vector<std::string> states_of_every_run(const RunLayout& layout) {
  std::vector<bool> is_landmark(layout.states.size(), false);
  for (const Block& block : layout.blocks) {
    if (block.part != Part::landmark && block.part != Part::map) continue;
    for (const Index i : block.states) is_landmark[static_cast<std::size_t>(i)] = true;
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < layout.states.size(); ++i) {
    if (!is_landmark[i]) names.push_back(layout.states[i]);
  }
  std::ranges::sort(names);
  return names;
}

/// What tells that one file has other states than another.
std::string unlike_sentence(const FileStates& one, const FileStates& other) {
  constexpr std::size_t kTold = 3;
  std::vector<std::string> has, lacks;
  std::ranges::set_difference(other.names, one.names, std::back_inserter(has));
  std::ranges::set_difference(one.names, other.names, std::back_inserter(lacks));
  std::string differs = has.empty() ? "" : "has " + first_items(has, kTold);
  if (!lacks.empty()) differs += (has.empty() ? "lacks " : " and lacks ") + first_items(lacks, kTold);
  return fmt::format(
      "{} {}, compared with {}: files of one filter have the same states, and each state is judged by those "
      "that have it.",
      other.file.string(), differs, one.file.string());
}

/// The sums of one group of files, in chunks of kChunkRuns runs, or why there are none (Stopped among them).
struct Group {
  std::vector<Evidence> chunks;
  std::vector<LogRemark> remarks;
  std::vector<LogPoses> poses;
  CalibrationRecorder calibration;
  std::vector<std::string> run_names;
  JudgedStates judged;
  StepTimes times;
  RunFingerprints fingerprints;
  std::vector<FileStates> states;  ///< of the first file, and of each with others than the one before
  Said said;  ///< of the first group, what its files together look like (StepConventions)
  std::int64_t unmatched = 0, unexplained = 0;
  TruthFit truth_fit = TruthFit::none;
  std::size_t files = 0;  ///< that were begun
  bool interrupted = false, swapped_axes = false;
  std::exception_ptr error;
};

/// How many bytes all workers have read.
class ByteCount {
 public:
  explicit ByteCount(const LogJudgeOptions& options) : options_(options) {}

  void advance(std::int64_t bytes) {
    bytes_ += bytes;
    if (!options_.progress) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock) options_.progress(bytes_);
  }

 private:
  const LogJudgeOptions& options_;
  std::atomic<std::int64_t> bytes_{0};
  std::mutex mutex_;
};

/// Tells those who wait once the scope is left, however.
class NotifyingScope {
 public:
  explicit NotifyingScope(std::condition_variable& waited_for) : waited_for_(waited_for) {}
  ~NotifyingScope() { waited_for_.notify_all(); }
  NotifyingScope(const NotifyingScope&) = delete;
  NotifyingScope& operator=(const NotifyingScope&) = delete;

 private:
  std::condition_variable& waited_for_;
};

/// Adds rows up.
class GroupSums final : public RowSink {
 public:
  explicit GroupSums(CalibrationRecorder& calibration) : calibration_(calibration) {}

  void begin_run(const std::filesystem::path& file, const RunLayout& layout,
                 const std::string& name) override {
    sums_.begin_file(file, layout);
    sums_.begin_run();
    calibration_.begin_run(layout, name);
  }
  void rename_run(const std::string& name) override { calibration_.rename_run(name); }
  void add(const NormalisedRow& row) override {
    if (row.left) {
      if (sums_.add(row.state)) calibration_.add(row.state, row.travelled_m, sums_.factored());
      return;
    }
    if (!row.problem.empty()) return sums_.reject(row.step, row.line, row.problem);
    sums_.add(row.normalised);
    if (row.factored) return calibration_.add({&row.factor, &row.normalised}, row.travelled_m);
    calibration_.add(row.state, row.travelled_m);
  }
  void end_run(Outcome outcome, std::int64_t step) override {
    sums_.end_run(outcome, step);
    if (outcome != Outcome::ok) calibration_.drop_run();
  }

  EvidenceRecorder& sums() { return sums_; }

 private:
  EvidenceRecorder sums_;
  CalibrationRecorder& calibration_;
};

/// Looks at what comes, and hands its rows on.
class GroupSink final : public LogSink {
 public:
  /// together: looks whether the files together would fit with a mistake of units undone, as one file is.
  GroupSink(Group& group, ByteCount& bytes, bool together) : group_(group), bytes_(bytes), said_(group.said) {
    if (together) together_.emplace(said_);
  }

  void begin_file(const std::filesystem::path& file) {
    file_ = file;
    steps_ = 0;
    number_.begin_file();
    group_.fingerprints.begin_file(file);
  }
  /// The file ends in the middle of a run.
  void interrupt() {
    end_file();
    group_.judged.failed();  // that it ends before the others tells nothing
    remark(fmt::format("interrupted: its first {} rows are judged", steps_));
  }
  /// A run that is alone in its file has no number.
  void end_file() {
    if (!number_.alone()) return;
    group_.fingerprints.name_by_file();
    group_.judged.rename_run(file_.string());
    group_.run_names.back() = file_.stem().string();
    rows_->rename_run(group_.run_names.back());
  }
  /// The rows that come are handed on to these.
  LogSink& to(RowSink& rows) {
    rows_ = &rows;
    return *this;
  }
  std::int64_t steps() const { return steps_; }

  void begin_run(const RunLayout& layout) override {
    require_sensors(layout);
    if (layout != layout_) {
      layout_ = layout;
      places_ = {};
      std::vector<std::string> names = states_of_every_run(layout);
      if (group_.states.empty() || group_.states.back().names != names)
        group_.states.push_back({file_, std::move(names)});
    }
    calibrated_ = CalibrationRecorder::takes(layout);
    const std::string number = number_.next();
    group_.fingerprints.begin_run(number);
    group_.times.begin_run();
    group_.judged.begin_run(run_name(file_.string(), number), layout);
    // The same file in another folder or format is another filter's log of these runs.
    group_.run_names.push_back(run_name(file_.stem().string(), number));
    rows_->begin_run(file_, layout, group_.run_names.back());
    if (!layout.componentwise) together_.reset();  // poses have conventions of their own
    if (together_) together_->begin_run(layout);
  }
  /// After the last file.
  void finish() {
    if (together_) together_->finish();
  }
  void run_number(const std::string& number) override { number_.tell(number); }
  void add(const Step& step) override {
    stop_point();
    ++steps_;
    NormalisedRow& row = rows_->room();
    normalise(step, row);
    rows_->add(row);
    group_.judged.add(step);
    if (together_) together_->add(step);
    group_.fingerprints.add(step);
    group_.times.add(step.step, std::exchange(time_s_, kNaN));
  }
  void travelled(double distance_m) override { travelled_m_ = distance_m; }
  void at(double time_s) override { time_s_ = time_s; }
  void end_run(Outcome outcome, std::int64_t step) override {
    rows_->end_run(outcome, step);
    group_.judged.failed();
  }
  void remark(std::string sentence) override { group_.remarks.push_back({file_, std::move(sentence)}); }
  void hint(std::string sentence) override {
    group_.remarks.push_back({file_, std::move(sentence), LogRemark::Kind::hint});
  }
  void misfit(std::string sentence) override {
    group_.remarks.push_back({file_, std::move(sentence), LogRemark::Kind::misfit});
  }
  void mistake(std::string sentence) override {
    group_.remarks.push_back({file_, std::move(sentence), LogRemark::Kind::mistake});
  }
  void swapped_axes(std::string sentence) override {
    group_.swapped_axes = true;
    mistake(std::move(sentence));
  }
  void unexplained() override { ++group_.unexplained; }
  void charts(ChartFindings findings) override { poses().charts = std::move(findings); }
  void time_offset(TimeOffset offset) override { poses().time_offset = std::move(offset); }
  void truth_fit(TruthFit fit) override { group_.truth_fit = std::max(group_.truth_fit, fit); }
  void unmatched(std::int64_t rows) override { group_.unmatched += rows; }
  void advance(std::int64_t bytes) override { bytes_.advance(bytes); }

 private:
  void require_sensors(const RunLayout& layout) {
    constexpr Index kMostSensors = 1000;
    const Index sensors = std::ssize(layout.sensors);
    if (sensors > kMostSensors) {
      throw DataError(
          file_, "",
          fmt::format("has {} sensors, of innovations or of NIS; at most {} are judged together: give "
                      "what one sensor measures one name (innovation.NAME.1, innovation.NAME.2, …), "
                      "or judge some at a time",
                      sensors, kMostSensors));
    }
    if (sensors > kMostPairedSensors && !number_.any()) {
      remark(
          fmt::format("Whether innovations of two sensors are correlated is not tested: {} sensors are more "
                      "than {}.",
                      sensors, kMostPairedSensors));
    }
  }

  LogPoses& poses() {
    if (group_.poses.empty() || group_.poses.back().file != file_) group_.poses.push_back({.file = file_});
    return group_.poses.back();
  }

  void normalise(const Step& step, NormalisedRow& row) {
    row.travelled_m = std::exchange(travelled_m_, kNaN);
    row.left = rows_->waits();
    if (row.left) {
      row.state = step;
      return;
    }
    row.step = step.step;
    row.line = step.line;
    if (!step.states.empty()) places_.find(step.states, layout_);
    row.problem = normaliser_.normalise(step, layout_, places_, row.normalised);
    row.factored = false;
    if (!row.problem.empty() || !calibrated_) return;
    const SmallCholesky* const factor = normaliser_.factor_of_state();
    row.factored = factor != nullptr;
    if (row.factored) {
      row.factor = *factor;
    } else {
      row.state.problem = {};
      row.state.states = step.states;
      row.state.error = step.error;
      row.state.P = step.P;
    }
  }

  Group& group_;
  ByteCount& bytes_;
  RowSink* rows_ = nullptr;
  RunLayout layout_;  ///< of the run
  bool calibrated_ = false;
  StepPlaces places_;
  StepNormaliser normaliser_;
  std::filesystem::path file_;
  std::int64_t steps_ = 0;  ///< of the file
  RunNumber number_;
  double travelled_m_ = kNaN, time_s_ = kNaN;  ///< of the next step
  SaidSink said_;
  std::optional<StepConventions> together_{};
};

/// Reads one file after the other, and hands their rows on to `rows`. An interruption ends it after the rows
/// that were read.
void read_files(std::span<const std::filesystem::path> files, const LogFileReader& read, bool partial,
                Group& group, GroupSink& sink, RowSink& rows) {
  for (const std::filesystem::path& file : files) {
    ++group.files;
    sink.begin_file(file);
    try {
      read(file, sink.to(rows));
      sink.end_file();
    } catch (const DataError& error) {
      if (!partial || sink.steps() == 0) throw;
      sink.end_file();
      sink.remark(fmt::format("only a part could be read: {}", error.what()));
    } catch (const Stopped&) {
      group.interrupted = true;
      if (sink.steps() > 0) return sink.interrupt();
      if (--group.files == 0) throw;
      return;
    }
  }
}

Group read_group(std::span<const std::filesystem::path> files, const LogFileReader& read, ByteCount& bytes,
                 const LogJudgeOptions& options, bool ahead, bool together) {
  Group group;
  GroupSums sums(group.calibration);
  GroupSink sink(group, bytes, together);
  const auto read_all = [&](RowSink& rows) { read_files(files, read, options.partial, group, sink, rows); };
  try {
    if (ahead) {
      read_ahead(sums, options.stop, read_all);
    } else {
      read_all(sums);
    }
    group.chunks = sums.sums().take_chunks();
    group.chunks.push_back(sums.sums().take());
    group.judged.end_run();
    sink.finish();
  } catch (...) {
    group.error = std::current_exception();
  }
  return group;
}

/// Keeps one hint where more files have one than chance explains and than misfit without: a mistake of who
/// wrote the logs is in most of those that it can be seen in.
void leave_out_chance(LogJudgeResult& result, std::int64_t unexplained) {
  const std::int64_t hints = std::ranges::count_if(result.remarks, &LogRemark::may_be_chance);
  if (hints == 0) return;
  constexpr double kRounding = 1e-12;
  const bool chance = hints <= unexplained || binomial_upper_tail(hints, result.files, ReadingFit::kLevel) >
                                                  ReadingFit::kLevel + kRounding;
  bool told = false;
  std::erase_if(result.remarks, [&](LogRemark& remark) {
    if (!remark.may_be_chance()) return false;
    const bool drop = chance || std::exchange(told, true);
    if (!drop && result.files > 1) {
      remark.sentence +=
          fmt::format(" (So {}, and likewise {} of {} files.)", remark.file.string(), hints, result.files);
    }
    return drop;
  });
}

}  // namespace

bool LogJudgeResult::explained() const {
  return std::ranges::any_of(remarks,
                             [](const LogRemark& remark) { return remark.kind != LogRemark::Kind::remark; });
}

LogJudgeResult judge_logs(std::span<const std::filesystem::path> files, const LogFileReader& read,
                          const LogJudgeOptions& options) {
  ByteCount bytes(options);
  LogJudgeResult result;
  RunFingerprints fingerprints;
  std::optional<FileStates> states;  // of the first file
  bool alike = true;
  std::vector<std::string> together;  // misfits of the first group
  std::mutex mutex;
  std::condition_variable turn;
  std::int64_t merged = 0;       // groups
  std::int64_t unexplained = 0;  // files
  bool failed = false, interrupted = false;
  const auto groups = static_cast<std::int64_t>((files.size() + kGroupFiles - 1) / kGroupFiles);
  const bool ahead = groups < thread_count(options.threads);  // else all threads have a group
  for_each_task(groups, options.threads, options.stop, [&](std::int64_t i) {
    const std::size_t first = static_cast<std::size_t>(i) * kGroupFiles;
    Group group = read_group(files.subspan(first, std::min(kGroupFiles, files.size() - first)), read, bytes,
                             options, ahead, i == 0 && files.size() > 1);
    // Groups are begun in their order, so all before this one are being read or merged.
    std::unique_lock lock(mutex);
    turn.wait(lock, [&] { return merged == i || failed; });
    if (failed) return;
    failed = true;  // unless it comes to its end
    const NotifyingScope tell(turn);
    if (group.error) std::rethrow_exception(group.error);
    for (Evidence& chunk : group.chunks) result.evidence.merge(std::move(chunk));
    std::ranges::move(group.remarks, std::back_inserter(result.remarks));
    std::ranges::move(group.poses, std::back_inserter(result.poses));
    result.calibration.append(group.calibration);
    std::ranges::move(group.run_names, std::back_inserter(result.run_names));
    result.times.merge(group.times);
    result.judged.merge(group.judged);
    fingerprints.append(std::move(group.fingerprints));
    for (FileStates& of_file : group.states) {
      if (!states) states = of_file;
      if (!alike || of_file.names == states->names) continue;
      alike = false;
      result.remarks.push_back({of_file.file, unlike_sentence(*states, of_file)});
    }
    std::ranges::move(group.said.misfits, std::back_inserter(together));
    result.unmatched_rows += group.unmatched;
    result.truth_fit = std::max(result.truth_fit, group.truth_fit);
    unexplained += group.unexplained;
    result.swapped_axes = result.swapped_axes || group.swapped_axes;
    result.files += static_cast<std::int64_t>(group.files);
    interrupted = interrupted || group.interrupted;
    ++merged;
    failed = false;
  });
  fingerprints.require_distinct();
  for (RunFingerprints::Likeness& likeness : fingerprints.likenesses())
    result.remarks.push_back({std::move(likeness.file), std::move(likeness.sentence)});
  result.copies = fingerprints.copies();
  result.complete = merged == groups && !interrupted;
  leave_out_chance(result, unexplained);
  if (!result.explained() && !together.empty())
    result.remarks.push_back({{}, std::move(together.front()), LogRemark::Kind::misfit});
  return result;
}

}  // namespace credence::internal
