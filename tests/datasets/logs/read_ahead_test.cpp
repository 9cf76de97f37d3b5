#include "datasets/logs/read_ahead.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// Writes down all that it is told, and on which thread.
class Diary final : public LogSink {
 public:
  std::vector<std::string> told;
  std::int64_t most = 1'000'000;  ///< steps that it takes
  std::vector<std::thread::id> threads;

  void begin_run(const RunLayout& layout) override { write("run of {}", layout.states.size()); }
  void add(const Step& step) override {
    if (steps_ == most) throw std::runtime_error("full");
    ++steps_;
    write("step {} error {} P {}", step.step, step.error.sum(), step.P.size());
  }
  void travelled(double distance_m) override { write("travelled {}", distance_m); }
  void at(double time_s) override { write("at {}", time_s); }
  void end_run(Outcome outcome, std::int64_t step) override { write("{} at {}", to_string(outcome), step); }
  void remark(std::string sentence) override { write("remark {}", sentence); }
  void hint(std::string sentence) override { write("hint {}", sentence); }
  void mistake(std::string sentence) override { write("mistake {}", sentence); }
  void unexplained() override { write("unexplained"); }
  void charts(ChartFindings findings) override { write("chart {}", findings.declared); }
  void time_offset(TimeOffset offset) override { write("offset {}", offset.value_s); }
  void truth_fit(TruthFit fit) override { write("fit {}", static_cast<int>(fit)); }
  void unmatched(std::int64_t rows) override { write("unmatched {}", rows); }
  void advance(std::int64_t bytes) override { write("advance {}", bytes); }

 private:
  template <class... Values>
  void write(fmt::format_string<Values...> text, Values&&... values) {
    told.push_back(fmt::format(text, std::forward<Values>(values)...));
    threads.push_back(std::this_thread::get_id());
  }

  std::int64_t steps_ = 0;
};

Step step_of(std::int64_t number, Index n) {
  return {.step = number,
          .states = {},
          .error = Vector::Constant(n, static_cast<double>(number)),
          .P = Matrix::Identity(n, n)};
}

/// All that can be told, and more steps than are kept.
void tell_all(LogSink& sink) {
  RunLayout layout;
  layout.states = {"x", "y"};
  sink.remark("begins");
  for (int run = 0; run < 3; ++run) {
    sink.begin_run(layout);
    for (std::int64_t k = 1; k <= 2000; ++k) {
      if (k % 3 == 0) sink.travelled(0.5 * static_cast<double>(k));
      if (k % 7 == 0) sink.at(static_cast<double>(k));
      sink.add(step_of(k, k % 500 == 0 ? 200 : 2));
      if (k % 512 == 0) sink.advance(k);
    }
    layout.states.emplace_back("z");  // of the next one
    sink.end_run(Outcome::diverged, 2001);
  }
  sink.hint("may be");
  sink.mistake("is");
  sink.unexplained();
  sink.charts({.declared = "fixed"});
  sink.time_offset({.value_s = 0.25});
  sink.truth_fit(TruthFit::none);
  sink.unmatched(7);
}

TEST(ReadAhead, TellsTheSameInTheSameOrderOnTheThreadOfTheSink) {
  Diary direct, ahead;
  tell_all(direct);
  read_ahead(ahead, nullptr, tell_all);
  EXPECT_EQ(ahead.told, direct.told);
  EXPECT_GT(ahead.told.size(), 6000U);
  for (const std::thread::id& thread : ahead.threads) EXPECT_EQ(thread, std::this_thread::get_id());
}

TEST(ReadAhead, ReadsOnAnotherThread) {
  Diary diary;
  std::thread::id reader;
  read_ahead(diary, nullptr, [&](LogSink& /*sink*/) { reader = std::this_thread::get_id(); });
  EXPECT_NE(reader, std::this_thread::get_id());
  EXPECT_TRUE(diary.told.empty());
}

TEST(ReadAhead, ErrorOfTheReaderComesAfterAllThatItTold) {
  Diary diary;
  const auto broken = [](LogSink& sink) {
    tell_all(sink);
    throw std::runtime_error("cut off");
  };
  EXPECT_THROW(read_ahead(diary, nullptr, broken), std::runtime_error);
  Diary direct;
  tell_all(direct);
  EXPECT_EQ(diary.told, direct.told);
}

TEST(ReadAhead, ErrorOfTheSinkEndsTheReader) {
  Diary diary;
  diary.most = 10;
  std::atomic<std::int64_t> told = 0;
  const auto endless = [&](LogSink& sink) {
    for (std::int64_t k = 1;; ++k) {
      sink.add(step_of(k, 2));
      ++told;
    }
  };
  EXPECT_THROW(read_ahead(diary, nullptr, endless), std::runtime_error);
  EXPECT_EQ(diary.told.size(), 10U);
  EXPECT_LE(told, 128 * 6);  // what is kept and not taken
}

TEST(ReadAhead, StopPointsOfTheReaderAskTheFlag) {
  Diary diary;
  const std::atomic<bool> stop = true;
  EXPECT_THROW(read_ahead(diary, &stop, [](LogSink& /*sink*/) { stop_point(); }), Stopped);
}

}  // namespace
}  // namespace credence::internal
