#include "montecarlo/engine/shared_tasks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "montecarlo/engine/engine.h"
#include "montecarlo/engine/rank_messages.h"
#include "montecarlo/worlds/registry.h"
#include "tests/montecarlo/engine/thread_ranks.h"

namespace credence::internal {
namespace {

Scenario small_monobot(std::int64_t runs) {
  Scenario s = default_scenario("monobot");
  s.study.runs = runs;
  s.study.steps = 20;
  return s;
}

/// As the program does: a helper tells what went wrong, and all wait for the end. Returns what rank 0 threw.
std::string joined(int count, const std::function<void(ThreadRanks&)>& work) {
  std::string thrown;
  on_ranks(count, [&](ThreadRanks& ranks) {
    try {
      work(ranks);
    } catch (const RanksEnded&) {
    } catch (const std::exception& error) {
      if (is_helper(&ranks)) {
        report_failure(ranks, error.what());
      } else {
        thrown = error.what();
      }
    }
    finish_ranks(ranks);
  });
  return thrown;
}

TEST(SharedTasks, BitsDoNotDependOnTheNumberOfRanks) {
  const Scenario scenario = small_monobot(1500);
  const auto experiment = make_experiment(scenario);
  StudyTask early{"early", experiment.get(), scenario.study.runs};
  early.enough = [](const StudyStatistics&, const StudyStatistics& prefix) { return prefix.runs == 640; };
  const StudyTask tasks[] = {{"whole", experiment.get(), scenario.study.runs}, early};
  const std::vector<StudyResult> alone = run_studies(tasks, {.threads = 1});
  ASSERT_EQ(alone[1].statistics.runs, 640);
  for (const int count : {1, 2, 3, 8}) {
    for (const int threads : {1, 2}) {
      const std::string thrown = joined(count, [&](ThreadRanks& ranks) {
        const auto results = run_studies(tasks, {.threads = threads, .ranks = &ranks});
        if (is_helper(&ranks)) {
          EXPECT_EQ(results[0].statistics.runs, 0);
          return;
        }
        for (std::size_t i = 0; i < 2; ++i) {
          EXPECT_EQ(results[i].statistics, alone[i].statistics)
              << count << " ranks, " << threads << " threads";
          EXPECT_TRUE(results[i].complete);
        }
      });
      EXPECT_EQ(thrown, "");
    }
  }
}

/// Tasks of which each must be taken once, whoever did it.
struct Counted {
  explicit Counted(std::int64_t count) : taken(static_cast<std::size_t>(count)) {
    tasks.count = count;
    tasks.here = [this](std::int64_t i) { ++taken[static_cast<std::size_t>(i)]; };
    tasks.there = [](std::int64_t i) {
      return std::vector<std::byte>(sizeof i, static_cast<std::byte>(i % 251));
    };
    tasks.take = [this](std::int64_t i, std::span<const std::byte> bytes) {
      EXPECT_EQ(bytes.front(), static_cast<std::byte>(i % 251));
      ++taken[static_cast<std::size_t>(i)];
    };
  }
  bool once_each() const {
    return std::ranges::all_of(taken, [](const std::atomic<int>& times) { return times == 1; });
  }
  std::vector<std::atomic<int>> taken;
  SharedTasks tasks;
};

TEST(SharedTasks, ARankThatIsAskedToEndGivesBackWhatItHas) {
  Counted counted(300);
  std::atomic<int> done = 0;  // by rank 2
  const std::string thrown = joined(3, [&](ThreadRanks& ranks) {
    std::atomic<bool> stop = false;
    SharedTasks tasks = counted.tasks;
    tasks.here = [&](std::int64_t i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the others come in time
      counted.tasks.here(i);
    };
    if (ranks.rank() == 2) {
      tasks.there = [&](std::int64_t i) {
        stop = ++done >= 3;
        return counted.tasks.there(i);
      };
    }
    for_each_shared_task(tasks, 1, &stop, &ranks);
  });
  EXPECT_EQ(thrown, "");
  EXPECT_GE(done, 3);
  EXPECT_TRUE(counted.once_each());
}

TEST(SharedTasks, AFailureElsewhereEndsTheStudyWithItsReason) {
  Counted counted(10000);
  const std::string thrown = joined(3, [&](ThreadRanks& ranks) {
    SharedTasks tasks = counted.tasks;
    const auto in_time = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };  // for rank 2
    tasks.here = [&](std::int64_t i) {
      in_time();
      counted.tasks.here(i);
    };
    tasks.there = [&](std::int64_t i) {
      in_time();
      return counted.tasks.there(i);
    };
    if (ranks.rank() == 2) {
      tasks.there = [](std::int64_t) -> std::vector<std::byte> { throw std::runtime_error("no disk here"); };
    }
    for_each_shared_task(tasks, 2, nullptr, &ranks);
    for_each_shared_task(tasks, 2, nullptr, &ranks);  // of those that are well, until rank 0 ends
  });
  EXPECT_EQ(thrown, "rank 2: no disk here");
}

TEST(SharedTasks, RanksThatDoNotFitTogetherAreRefused) {
  Counted counted(1000);
  const auto refused = [&](const std::function<void(ThreadRanks&, SharedTasks&)>& spoil) {
    return joined(2, [&](ThreadRanks& ranks) {
      SharedTasks tasks = counted.tasks;
      if (is_helper(&ranks)) {
        spoil(ranks, tasks);
      } else {
        tasks.here = [](std::int64_t) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
      }
      for_each_shared_task(tasks, 1, nullptr, &ranks);
    });
  };
  EXPECT_EQ(refused([](ThreadRanks&, SharedTasks& tasks) { tasks.identity = "another scenario"; }),
            "rank 1 works on another study, or is another version");
  EXPECT_EQ(refused([](ThreadRanks& ranks, SharedTasks&) {
              ranks.send(0, to_bytes(RankMessage{.kind = RankMessage::Kind::records,
                                                 .records = {{.task = 999, .bytes = {}}}}));
            }),
            "rank 1 sent the result of a task that it was not given");
  EXPECT_EQ(refused([](ThreadRanks& ranks, SharedTasks&) { ranks.send(0, {}); }),
            "a message of another rank ends too early");
}

TEST(SharedTasks, AnExceptionOfRankZeroEndsTheOthers) {
  Counted counted(1000);
  const std::string thrown = joined(3, [&](ThreadRanks& ranks) {
    SharedTasks tasks = counted.tasks;
    tasks.here = [](std::int64_t) { throw std::runtime_error("the store is full"); };
    for_each_shared_task(tasks, 1, nullptr, &ranks);
  });
  EXPECT_EQ(thrown, "the store is full");
}

TEST(RankMessages, ComeBackAsTheyWereAndDamagedOnesAreRefused) {
  RankMessage message{
      .kind = RankMessage::Kind::records, .phase = 3, .identity = 7, .range = {5, 6}, .text = "x"};
  for (std::int64_t task : {4, 9})
    message.records.push_back({task, std::vector<std::byte>(20, std::byte{42})});
  const std::vector<std::byte> bytes = to_bytes(message);
  const RankMessage back = rank_message_from_bytes(bytes);
  EXPECT_EQ(back.phase, 3U);
  EXPECT_EQ(back.range.count, 6);
  ASSERT_EQ(back.records.size(), 2U);
  EXPECT_EQ(back.records[1].task, 9);
  EXPECT_EQ(back.records[1].bytes, message.records[1].bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(rank_message_from_bytes(std::span(bytes).first(size)), std::runtime_error) << size;
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back({});
  EXPECT_THROW(rank_message_from_bytes(longer), std::runtime_error);
  std::vector<std::byte> other = bytes;
  other[0] ^= std::byte{1};
  EXPECT_THROW(rank_message_from_bytes(other), std::runtime_error) << "another version";
  std::vector<std::byte> damaged = bytes;
  damaged.back() ^= std::byte{1};
  EXPECT_THROW(rank_message_from_bytes(damaged), std::runtime_error) << "checksum";
}

}  // namespace
}  // namespace credence::internal
