#include "datasets/logs/read_ahead.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// Writes down all that it is told, and on which thread.
class Diary final : public RowSink {
 public:
  std::vector<std::string> told;
  std::int64_t most = 1'000'000;  ///< rows that it takes
  std::vector<std::thread::id> threads;

  void begin_run(const std::filesystem::path& file, const RunLayout& layout,
                 const std::string& name) override {
    write("{} of {} states of {}", name, layout.states.size(), file.string());
  }
  void rename_run(const std::string& name) override { write("it is {}", name); }
  void add(const NormalisedRow& row) override {
    if (rows_ == most) throw std::runtime_error("full");
    ++rows_;
    write("step {} line {} error {} P {} travelled {}{}", row.step, row.line, row.normalised.error.sum(),
          row.normalised.P.size(), row.travelled_m, row.problem);
  }
  void end_run(Outcome outcome, std::int64_t step) override { write("{} at {}", to_string(outcome), step); }

 private:
  template <class... Values>
  void write(fmt::format_string<Values...> text, Values&&... values) {
    told.push_back(fmt::format(text, std::forward<Values>(values)...));
    threads.push_back(std::this_thread::get_id());
  }

  std::int64_t rows_ = 0;
};

void add_row(RowSink& rows, std::int64_t number, Index n) {
  NormalisedRow& row = rows.room();
  row.step = number;
  row.line = number + 1;
  row.problem = number % 11 == 0 ? " is wrong" : "";
  row.normalised.error = Vector::Constant(n, static_cast<double>(number));
  row.normalised.P = Matrix::Identity(n, n);
  row.travelled_m = 0.5 * static_cast<double>(number);
  rows.add(row);
}

/// All that can be told, and more rows than are kept.
void tell_all(RowSink& rows) {
  RunLayout layout;
  layout.states = {"x", "y"};
  for (int run = 0; run < 3; ++run) {
    rows.begin_run("log.csv", layout, fmt::format("run {}", run));
    for (std::int64_t k = 1; k <= 2000; ++k) add_row(rows, k, k % 500 == 0 ? 200 : 2);
    rows.add({.step = 2001});         // not written where it goes
    layout.states.emplace_back("z");  // of the next one
    rows.end_run(Outcome::diverged, 2002);
    rows.rename_run("alone");
  }
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
  read_ahead(diary, nullptr, [&](RowSink& /*rows*/) { reader = std::this_thread::get_id(); });
  EXPECT_NE(reader, std::this_thread::get_id());
  EXPECT_TRUE(diary.told.empty());
}

TEST(ReadAhead, WhoReadsKnowsWhetherItsRowsAreWaitedFor) {
  Diary diary;
  EXPECT_FALSE(diary.waits());
  bool waits = false;
  read_ahead(diary, nullptr, [&](RowSink& rows) {
    for (std::int64_t k = 1; k < diary.most && !waits; ++k) {
      add_row(rows, k, 2);
      waits = rows.waits();
      if (k % 512 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  EXPECT_TRUE(waits);
}

TEST(ReadAhead, ErrorOfTheReaderComesAfterAllThatItTold) {
  Diary diary;
  const auto broken = [](RowSink& rows) {
    tell_all(rows);
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
  const auto endless = [&](RowSink& rows) {
    for (std::int64_t k = 1;; ++k) {
      add_row(rows, k, 2);
      ++told;
    }
  };
  EXPECT_THROW(read_ahead(diary, nullptr, endless), std::runtime_error);
  EXPECT_EQ(diary.told.size(), 10U);
  EXPECT_LE(told, 512 * 6);  // what is kept and not taken
}

TEST(ReadAhead, StopPointsOfTheReaderAskTheFlag) {
  Diary diary;
  const std::atomic<bool> stop = true;
  EXPECT_THROW(read_ahead(diary, &stop, [](RowSink& /*rows*/) { stop_point(); }), Stopped);
}

}  // namespace
}  // namespace credence::internal
