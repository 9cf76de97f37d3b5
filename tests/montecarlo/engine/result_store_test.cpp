#include "montecarlo/engine/result_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "montecarlo/scenario/scenario_difference.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"

namespace credence::internal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Bytes = std::vector<std::byte>;
constexpr const char* kVersion = "0.1.0";

/// A directory of the test's own, gone with it.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "credence_store_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~ScratchDirectory() {
    std::error_code error;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, error);
    std::filesystem::remove_all(path_, error);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  std::filesystem::path operator/(const char* name) const { return path_ / name; }
  std::filesystem::path database(const char* name) const { return path_ / name / "results.sqlite"; }

 private:
  std::filesystem::path path_;
};

/// Bytes that depend on a number, of any length, in which nothing repeats.
Bytes payload(int number, std::size_t size = 100) {
  Bytes bytes(size);
  std::mt19937 generator(static_cast<unsigned>(number) + 1U);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(generator() & 0xffU);
  return bytes;
}

ChunkKey chunk(int number, const std::string& configuration = "c1") {
  return {configuration, 64 * number, 64};
}

std::string scenario_text(const std::vector<std::string>& overrides = {}) {
  return canonical_toml(load_scenario_text("[world]\nmodel = \"monobot\"\n", "x.toml", overrides));
}

ResultStore filled(const std::filesystem::path& directory, int first, int last) {
  ResultStore store = ResultStore::open_to_write(directory, kVersion);
  store.require_same_scenario(scenario_text());
  store.put_configuration("c1", "text of c1");
  for (int i = first; i < last; ++i) store.put_chunk(chunk(i), payload(i));
  store.commit();
  return store;
}

std::string said_by(const std::function<void()>& action) {
  try {
    action();
  } catch (const StoreError& error) {
    return error.what();
  }
  return "nothing";
}

void run_sql(const std::filesystem::path& file, const char* sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  sqlite3_close(database);
}

TEST(ResultStore, GivesBackWhatWasPut) {
  const ScratchDirectory scratch;
  {
    ResultStore store = ResultStore::open_to_write(scratch / "new/deep", kVersion);
    EXPECT_EQ(store.scenario(), "");
    store.require_same_scenario(scenario_text());
    store.put_configuration("c2", "text of c2");
    store.put_configuration("c1", "text of c1");
    store.put_configuration("c1", "text of c1");
    store.put_chunk({"c1", 128, 64}, payload(2));
    store.put_chunk({"c1", 0, 64}, payload(0, 300'000));
    store.put_chunk({"c1", 128, 8}, payload(3));
    store.put_chunk({"c2", 0, 64}, {});
    EXPECT_EQ(store.get_chunk({"c1", 128, 64}), payload(2)) << "before the commit";
  }
  const ResultStore store = ResultStore::open_to_read(scratch / "new/deep");
  EXPECT_EQ(store.scenario(), scenario_text());
  EXPECT_EQ(store.tool_version(), kVersion);
  EXPECT_THAT(store.configurations(), ElementsAre("c1", "c2"));
  EXPECT_EQ(store.configuration("c1"), "text of c1");
  EXPECT_EQ(store.configuration("c3"), std::nullopt);
  EXPECT_THAT(store.chunks("c1"),
              ElementsAre(ChunkKey{"c1", 0, 64}, ChunkKey{"c1", 128, 8}, ChunkKey{"c1", 128, 64}));
  EXPECT_EQ(store.get_chunk({"c1", 0, 64}), payload(0, 300'000));
  EXPECT_EQ(store.get_chunk({"c1", 128, 8}), payload(3));
  EXPECT_EQ(store.get_chunk({"c2", 0, 64}), Bytes());
  EXPECT_EQ(store.get_chunk({"c1", 0, 63}), std::nullopt);
}

TEST(ResultStore, TheSameChunkTwiceIsFineWithOtherBitsAnError) {
  const ScratchDirectory scratch;
  ResultStore store = filled(scratch / "a", 0, 3);
  store.put_chunk(chunk(1), payload(1));
  Bytes other = payload(1);
  other.back() ^= std::byte{1};
  const std::string said = said_by([&] { store.put_chunk(chunk(1), other); });
  EXPECT_THAT(said, AllOf(HasSubstr("runs 64 to 127 of configuration c1"), HasSubstr("other bits")));
  EXPECT_THAT(said_by([&] { store.put_chunk(chunk(1), payload(1, 99)); }), HasSubstr("other bits"));
  EXPECT_EQ(store.get_chunk(chunk(1)), payload(1)) << "what was there stays";
  store.put_chunk(chunk(3), payload(3));  // and the store goes on
  EXPECT_EQ(store.chunks("c1").size(), 4U);
  EXPECT_THAT(said_by([&] { store.put_configuration("c1", "text"); }), HasSubstr("configuration c1"));
}

TEST(ResultStore, RefusesKeysThatMakeNoSense) {
  const ScratchDirectory scratch;
  ResultStore store = filled(scratch / "a", 0, 1);
  EXPECT_THROW(store.put_chunk({"c1", -1, 64}, payload(1)), std::invalid_argument);
  EXPECT_THROW(store.put_chunk({"c1", 0, 0}, payload(1)), std::invalid_argument);
  EXPECT_THROW(store.put_chunk({"unknown", 0, 64}, payload(1)), std::invalid_argument);
  store.put_chunk(chunk(1), payload(1));
  EXPECT_EQ(store.chunks("c1").size(), 2U);
}

TEST(ResultStore, RefusesAnotherScenarioShowingTheDifference) {
  const ScratchDirectory scratch;
  ResultStore store = filled(scratch / "a", 0, 1);
  store.require_same_scenario(scenario_text());
  const std::string said = said_by([&] {
    store.require_same_scenario(scenario_text({"world.landmarks=3", "filter.inflation=map", "study.runs=9"}));
  });
  EXPECT_THAT(said, HasSubstr((scratch / "a").string()));
  EXPECT_THAT(said,
              HasSubstr("- filter.inflation = \"none\"\n+ filter.inflation = \"map\"\n"
                        "+ filter.solution = \"pairwise\"\n- world.landmarks = 2\n+ world.landmarks = 3\n"));
  EXPECT_THAT(said, Not(HasSubstr("runs")));
  EXPECT_THAT(said, HasSubstr("--fresh"));
  EXPECT_EQ(store.scenario(), scenario_text()) << "nothing was written over";
}

TEST(ResultStore, MoreRunsAndAnotherConfidenceExtendAStudy) {
  const ScratchDirectory scratch;
  ResultStore store = filled(scratch / "a", 0, 1);
  const std::string more = scenario_text({"study.runs=1000", "study.confidence=0.99"});
  store.require_same_scenario(more);
  EXPECT_EQ(store.scenario(), more);
}

TEST(ScenarioDifference, ListsKeysOnceEachSide) {
  EXPECT_EQ(scenario_difference("[a]\nx = 1\n", "[a]\nx = 1\n"), "");
  EXPECT_EQ(scenario_difference("[a]\nx = 1\n[b]\nx = 1\n", "[a]\nx = 1\n[b]\nx = 2\ny = 3"),
            "- b.x = 1\n+ b.x = 2\n+ b.y = 3\n");
  EXPECT_EQ(scenario_difference("[sweep]\nworld.landmarks = [1, 2]\n", ""),
            "- sweep.world.landmarks = [1, 2]\n");
  EXPECT_EQ(scenario_difference("[study]\nruns = 1\nseed = 1\n", "[study]\nruns = 2\nseed = 1\n"), "");
}

TEST(ResultStore, OneProcessWritesWhileOthersRead) {
  const ScratchDirectory scratch;
  ResultStore writer = filled(scratch / "a", 0, 2);
  EXPECT_THAT(said_by([&] { ResultStore::open_to_write(scratch / "a", kVersion); }),
              AllOf(HasSubstr("is writing there"), HasSubstr("pid " + std::to_string(getpid()))));
  const ResultStore reader = ResultStore::open_to_read(scratch / "a");
  EXPECT_EQ(reader.chunks("c1").size(), 2U);
  writer.put_chunk(chunk(2), payload(2));
  writer.commit();
  EXPECT_EQ(reader.chunks("c1").size(), 3U) << "a reader follows";
}

/// The write lock of a database, held by another program.
class ForeignWriter {
 public:
  explicit ForeignWriter(const std::filesystem::path& file) {
    EXPECT_EQ(sqlite3_open(file.c_str(), &database_), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  ~ForeignWriter() { sqlite3_close(database_); }
  ForeignWriter(const ForeignWriter&) = delete;
  ForeignWriter& operator=(const ForeignWriter&) = delete;

 private:
  sqlite3* database_ = nullptr;
};

TEST(ResultStore, SaysThatAnotherProgramHoldsTheFile) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 1); }
  const SqliteDatabase database(scratch.database("a"), SqliteDatabase::Mode::create);
  database.execute("PRAGMA busy_timeout = 1");
  const ForeignWriter other(scratch.database("a"));
  EXPECT_THAT(said_by([&] { database.execute("BEGIN IMMEDIATE"); }), HasSubstr("locked by another process"));
}

TEST(ResultStore, WaitsForAnotherProgramThatHoldsTheFile) {
  const ScratchDirectory scratch;
  {
    ResultStore store = filled(scratch / "a", 0, 1);
    auto other = std::make_optional<ForeignWriter>(scratch.database("a"));
    std::jthread release([&] {
      usleep(1'000'000);
      other.reset();
    });
    store.put_chunk(chunk(1), payload(1));
  }
  EXPECT_EQ(ResultStore::open_to_read(scratch / "a").chunks("c1").size(), 2U);
}

TEST(ResultStore, IsNotDiscardedWhileAProcessWritesToIt) {
  const ScratchDirectory scratch;
  {
    ResultStore writer = filled(scratch / "a", 0, 2);
    EXPECT_THAT(said_by([&] { ResultStore::discard(scratch / "a"); }), HasSubstr("is writing there"));
    writer.put_chunk(chunk(2), payload(2));
  }
  EXPECT_EQ(ResultStore::open_to_read(scratch / "a").chunks("c1").size(), 3U);
  const std::string journal = scratch.database("a").string() + "-journal";
  std::ofstream(journal) << "of a process that was killed";
  ResultStore::discard(scratch / "a");
  EXPECT_FALSE(std::filesystem::exists(scratch.database("a")));
  EXPECT_FALSE(std::filesystem::exists(journal));
  ResultStore::discard(scratch / "a");  // and where there is none
  ResultStore::discard(scratch / "nowhere");
}

TEST(ResultStore, DiscardsNothingThatIsNoStore) {
  const ScratchDirectory scratch;
  const auto refused = [&](const char* folder) {
    EXPECT_THAT(said_by([&] { ResultStore::discard(scratch / folder); }),
                HasSubstr("is no store of results"));
    EXPECT_TRUE(std::filesystem::exists(scratch.database(folder)));
  };
  for (const char* folder : {"other", "text", "folder", "empty", "begun"})
    std::filesystem::create_directories(scratch / folder);
  {
    SqliteDatabase other(scratch.database("other"), SqliteDatabase::Mode::create);
    other.execute("CREATE TABLE precious(x)");
  }
  refused("other");
  std::ofstream(scratch.database("text"))
      << "a letter, and no database at all, of more than seventy-two characters";
  refused("text");
  std::filesystem::create_directory(scratch.database("folder"));
  refused("folder");
  // Of a process that was killed before it had made a table.
  std::ofstream(scratch.database("empty")) << "";
  ResultStore::discard(scratch / "empty");
  EXPECT_FALSE(std::filesystem::exists(scratch.database("empty")));
  {
    SqliteDatabase begun(scratch.database("begun"), SqliteDatabase::Mode::create);
    begun.execute("PRAGMA user_version=1");
  }
  ResultStore::discard(scratch / "begun");
  EXPECT_FALSE(std::filesystem::exists(scratch.database("begun")));
}

TEST(ResultStore, KnowsAllVersionsThatHaveAdded) {
  const ScratchDirectory scratch;
  filled(scratch / "a", 0, 2);
  {
    ResultStore other = ResultStore::open_to_write(scratch / "a", "9.9");
    EXPECT_EQ(other.tool_version(), kVersion) << "nothing is added yet";
    other.put_chunk(chunk(2), payload(2));
    EXPECT_EQ(other.tool_version(), std::string(kVersion) + ", 9.9");
    other.put_chunk(chunk(3), payload(3));
    EXPECT_EQ(other.tool_version(), std::string(kVersion) + ", 9.9");
  }
  ResultStore joined = filled(scratch / "b", 4, 5);
  joined.merge_from(ResultStore::open_to_read(scratch / "a"));
  EXPECT_EQ(joined.tool_version(), std::string(kVersion) + ", 9.9");
}

TEST(ResultStore, IsTakenBackOnlyWhereItIsNew) {
  const ScratchDirectory scratch;
  {
    ResultStore made = filled(scratch / "a", 0, 2);
    made.take_back();
    EXPECT_TRUE(std::filesystem::is_empty(scratch / "a")) << "its lock is gone as well";
    filled(scratch / "a", 0, 3);  // and it is free
  }
  ResultStore again = filled(scratch / "a", 0, 1);
  again.take_back();
  EXPECT_EQ(again.chunks("c1").size(), 3U) << "it was there before";
}

TEST(ResultStore, SaysThatItWasTakenAway) {
  const ScratchDirectory scratch;
  const auto take_away = [&](const std::function<void()>& action) {
    ResultStore store = filled(scratch / "a", 0, 2);
    action();
    const std::string said = said_by([&] {
      store.put_chunk(chunk(2), payload(2));
      store.commit();
    });
    std::filesystem::remove_all(scratch / "a");
    return said;
  };
  EXPECT_THAT(take_away([&] { std::filesystem::remove(scratch.database("a")); }),
              AllOf(HasSubstr("results.sqlite"), HasSubstr("moved or removed")));
  EXPECT_THAT(take_away([&] { std::filesystem::rename(scratch / "a", scratch / "b"); }),
              HasSubstr("moved or removed"));
  EXPECT_EQ(ResultStore::open_to_read(scratch / "b").chunks("c1").size(), 3U)
      << "it went where the file went";
  EXPECT_THAT(take_away([&] {
                std::filesystem::remove_all(scratch / "a");
                filled(scratch / "a", 0, 1);
              }),
              HasSubstr("moved or removed"))
      << "another store in its place";
}

TEST(ResultStore, AStoreOpenedToReadTakesNothing) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 1); }
  ResultStore store = ResultStore::open_to_read(scratch / "a");
  EXPECT_THAT(said_by([&] { store.put_chunk(chunk(1), payload(1)); }), HasSubstr("opened to read"));
  store.require_same_scenario(scenario_text({"study.runs=9"}));
  EXPECT_EQ(store.scenario(), scenario_text());
  EXPECT_THAT(said_by([&] { store.require_same_scenario(scenario_text({"study.seed=9"})); }),
              HasSubstr("study.seed"));
}

/// Runs `body` in a process of its own, which is killed by signal 9 once it has reported `reports` numbers.
/// Returns how many it had reported when it died.
int killed_after(int reports, const std::function<void(const std::function<void()>&)>& body) {
  int ends[2] = {};
  if (pipe(ends) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    try {
      body([&] {
        if (write(ends[1], "x", 1) != 1) _exit(1);
      });
    } catch (...) {
      _exit(2);
    }
    _exit(0);
  }
  close(ends[1]);
  int count = 0;
  char byte = 0;
  while (count < reports && read(ends[0], &byte, 1) == 1) ++count;
  kill(child, SIGKILL);
  while (read(ends[0], &byte, 1) == 1) ++count;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return count;
}

// Every chunk that the killed process knew to be committed is there with its bits, and the work goes on.
TEST(ResultStore, LosesNothingCommittedWhenKilled) {
  const ScratchDirectory scratch;
  int known = 0;
  for (const int reports : {1, 2, 7, 20, 40}) {
    const int committed = killed_after(reports, [&](const std::function<void()>& report) {
      ResultStore store = ResultStore::open_to_write(scratch / "a", kVersion);
      store.require_same_scenario(scenario_text());
      store.put_configuration("c1", "text of c1");
      for (int i = 0; i < 10'000; ++i) {
        if (store.get_chunk(chunk(i))) continue;
        store.put_chunk(chunk(i), payload(i, 5000));
        store.commit();
        report();
      }
    });
    ASSERT_GE(committed, reports);
    known += committed;
    const ResultStore store = ResultStore::open_to_read(scratch / "a");
    const std::vector<ChunkKey> keys = store.chunks("c1");
    ASSERT_GE(keys.size(), static_cast<std::size_t>(known));
    ASSERT_LE(keys.size(), static_cast<std::size_t>(known) + 5) << "at most one a kill was not yet reported";
    for (std::size_t i = 0; i < keys.size(); ++i) {
      EXPECT_EQ(keys[i], chunk(static_cast<int>(i)));
      EXPECT_EQ(store.get_chunk(keys[i]), payload(static_cast<int>(i), 5000));
    }
  }
  ResultStore store = filled(scratch / "a", 10'000, 10'001);
  EXPECT_EQ(store.get_chunk(chunk(10'000)), payload(10'000));
}

TEST(ResultStore, ShowsNothingOfWhatWasNotCommittedWhenKilled) {
  const ScratchDirectory scratch;
  killed_after(1, [&](const std::function<void()>& report) {
    ResultStore store = filled(scratch / "a", 0, 3);  // the commit is less than half a second ago: these wait
    for (int i = 3; i < 6; ++i) store.put_chunk(chunk(i), payload(i));
    report();
    pause();
  });
  EXPECT_EQ(ResultStore::open_to_read(scratch / "a").chunks("c1").size(), 3U);
}

TEST(ResultStore, CommitsByItselfAfterHalfASecond) {
  const ScratchDirectory scratch;
  ResultStore writer = filled(scratch / "a", 0, 1);
  usleep(510'000);
  writer.put_chunk(chunk(1), payload(1));
  EXPECT_EQ(ResultStore::open_to_read(scratch / "a").chunks("c1").size(), 2U);
}

// A limit on the size of files stands for the full disk, which a test cannot make.
TEST(ResultStore, KeepsWhatWasSavedWhenThereIsNoRoom) {
  const ScratchDirectory scratch;
  const int committed = killed_after(1'000'000, [&](const std::function<void()>& report) {
    ResultStore store = filled(scratch / "a", 0, 1);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{300'000, 300'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string said = said_by([&] {
      for (int i = 1; i < 1000; ++i) {
        store.put_chunk(chunk(i), payload(i, 5000));
        store.commit();
        report();
      }
    });
    const bool clear =
        said.find("results.sqlite: ") != std::string::npos && said.find("is kept") != std::string::npos;
    if (clear &&
        said_by([&] { store.put_chunk(chunk(2000), payload(1)); }).find("no more") != std::string::npos) {
      report();  // one more, for the messages
    }
  });
  ASSERT_GT(committed, 10);
  const ResultStore store = ResultStore::open_to_read(scratch / "a");
  EXPECT_EQ(store.chunks("c1").size(), static_cast<std::size_t>(committed))
      << "first chunk and messages cancel";
  for (int i = 1; i < committed; ++i) EXPECT_EQ(store.get_chunk(chunk(i)), payload(i, 5000));
}

TEST(ResultStore, SaysThatTheDiskIsFull) {
  const ScratchDirectory scratch;
  std::filesystem::create_directories(scratch / "a");
  const SqliteDatabase database(scratch.database("a"), SqliteDatabase::Mode::create);
  database.execute("PRAGMA max_page_count = 4; CREATE TABLE t(x BLOB)");
  const std::string said = said_by(
      [&] { SqliteStatement(database, "INSERT INTO t VALUES(?)").bind(1, payload(0, 50'000)).run(); });
  EXPECT_THAT(said, AllOf(HasSubstr("results.sqlite"), HasSubstr("the disk is full")));
}

TEST(ResultStore, ChunksArePackedAndThoseOfOlderStoresAreNot) {
  const ScratchDirectory scratch;
  const Bytes zeros(100'000);
  const auto bytes_of = [&](const char* name) {
    const SqliteDatabase database(scratch.database(name), SqliteDatabase::Mode::read);
    return database.integer("SELECT length(payload) FROM chunks WHERE first_run = 640");
  };
  {
    ResultStore store = filled(scratch / "old", 0, 1);
    store.put_chunk(chunk(10), zeros);
    store.commit();
  }
  EXPECT_LT(bytes_of("old"), 1000);
  {
    const SqliteDatabase database(scratch.database("old"), SqliteDatabase::Mode::create);
    for (const int i : {0, 10}) {
      SqliteStatement(database, "UPDATE chunks SET payload = ? WHERE first_run = ?")
          .bind(1, i == 0 ? std::span<const std::byte>(payload(0)) : std::span<const std::byte>(zeros))
          .bind(2, std::int64_t{64} * i)
          .run();
    }
    database.execute("PRAGMA user_version = 1");
  }
  {
    ResultStore old = ResultStore::open_to_write(scratch / "old", kVersion);
    EXPECT_EQ(old.get_chunk(chunk(0)), payload(0));
    old.put_chunk(chunk(10), zeros);
    old.put_chunk(chunk(1), payload(1));
    EXPECT_EQ(old.get_chunk(chunk(1)), payload(1));
  }
  EXPECT_EQ(bytes_of("old"), 100'000);
  ResultStore joined = filled(scratch / "new", 0, 2);
  EXPECT_EQ(joined.merge_from(ResultStore::open_to_read(scratch / "old")).already_there, 2);
  EXPECT_EQ(joined.get_chunk(chunk(10)), zeros);
  EXPECT_LT(bytes_of("new"), 1000);
}

// SQLite rolls the whole transaction back, and with it configurations that were put before.
TEST(ResultStore, EveryLaterWriteTellsWhyTheFirstFailed) {
  const ScratchDirectory scratch;
  const int told = killed_after(1'000'000, [&](const std::function<void()>& report) {
    ResultStore store = ResultStore::open_to_write(scratch / "a", kVersion);
    store.require_same_scenario(scenario_text());
    store.put_configuration("c1", "text of c1");
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{100'000, 100'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string first = said_by([&] {
      store.put_chunk(chunk(1), payload(1, 1'000'000));
      store.commit();
    });
    if (first.find("results.sqlite: ") == std::string::npos) return;
    const std::string second = said_by([&] { store.put_chunk(chunk(2), payload(2)); });
    if (second.find(first) != std::string::npos) report();
  });
  EXPECT_EQ(told, 1);
}

TEST(ResultStore, FindsDamage) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 200); }
  const auto size = std::filesystem::file_size(scratch.database("a"));
  std::filesystem::create_directories(scratch / "b");
  for (const std::uintmax_t kept : {size - 4096, size / 2, std::uintmax_t{4096}, std::uintmax_t{100}}) {
    std::filesystem::copy_file(scratch.database("a"), scratch.database("b"),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(scratch.database("b"), kept);
    for (const bool writing : {false, true}) {
      const std::string said = said_by([&] {
        writing ? ResultStore::open_to_write(scratch / "b", kVersion)
                : ResultStore::open_to_read(scratch / "b");
      });
      EXPECT_THAT(said,
                  AllOf(HasSubstr("results.sqlite: is "), HasSubstr("damaged: delete or move the file")))
          << kept << " of " << size;
      EXPECT_EQ(std::filesystem::file_size(scratch.database("b")), kept) << "left as it was";
    }
  }
}

// SQLite reads the file, and says that there is "no such column".
TEST(ResultStore, DamageInTheTextOfTheTablesIsToldInOurWords) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 2); }
  std::ostringstream whole;
  whole << std::ifstream(scratch.database("a"), std::ios::binary).rdbuf();
  const std::string bytes = whole.str();
  const auto use = [&](bool writing) {
    ResultStore store = writing ? ResultStore::open_to_write(scratch / "b", kVersion)
                                : ResultStore::open_to_read(scratch / "b");
    store.configuration("c1");
    for (const ChunkKey& key : store.chunks("c1")) store.get_chunk(key);
    store.get_companion(chunk(0));
    if (!writing) return;
    store.set_name("another");
    store.put_configuration("c2", "text of c2");
    store.put_companion(chunk(5), payload(5), payload(6));
    store.put_chunk(chunk(5), payload(5));
    store.commit();
  };
  constexpr std::size_t kPage = 4096;
  int complaints = 0;
  for (std::size_t at = bytes.find("CREATE TABLE"); at < kPage; at += 3) {
    for (const bool writing : {false, true}) {
      if (writing && at % 10 != 0) continue;
      std::filesystem::remove_all(scratch / "b");
      std::filesystem::create_directories(scratch / "b");
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ 1);
      std::ofstream(scratch.database("b"), std::ios::binary) << damaged;
      const std::string said = said_by([&] { use(writing); });
      if (said == "nothing") continue;
      ++complaints;
      EXPECT_THAT(said, AllOf(HasSubstr("b/results.sqlite: is damaged"), HasSubstr(kDamageAdvice))) << at;
    }
  }
  EXPECT_GT(complaints, 50);
}

// One byte of the file is changed: the store complains, or what it gives is right.
TEST(ResultStore, NeverGivesWrongBits) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 100); }
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(scratch.database("a")));
  int complaints = 0;
  for (std::streamoff at = 24; at < size; at += 709) {
    std::fstream file(scratch.database("a"), std::ios::in | std::ios::out | std::ios::binary);
    const auto flip = [&] {
      file.seekg(at);
      const auto byte = static_cast<char>(file.get());
      file.seekp(at);
      file.put(static_cast<char>(byte ^ 0x10)).flush();
    };
    flip();
    const std::string said = said_by([&] {
      const ResultStore store = ResultStore::open_to_read(scratch / "a");
      for (const ChunkKey& key : store.chunks("c1")) {
        EXPECT_EQ(store.get_chunk(key), payload(static_cast<int>(key.first_run / 64))) << "byte " << at;
      }
    });
    complaints += said == "nothing" ? 0 : 1;
    EXPECT_EQ(said.find("database"), std::string::npos) << "words of SQLite: " << said;
    flip();
  }
  EXPECT_GT(complaints, 10);
}

TEST(ResultStore, FindsAChangedPayload) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 3); }
  run_sql(scratch.database("a"), "UPDATE chunks SET payload = zeroblob(100) WHERE first_run = 64");
  run_sql(scratch.database("a"), "UPDATE chunks SET runs = 32 WHERE first_run = 128");
  const ResultStore store = ResultStore::open_to_read(scratch / "a");
  EXPECT_EQ(store.get_chunk(chunk(0)), payload(0));
  EXPECT_THAT(said_by([&] { store.get_chunk(chunk(1)); }),
              AllOf(HasSubstr("a/results.sqlite: runs 64 to 127 of configuration c1 are damaged ("),
                    HasSubstr("delete or move the file")));
  EXPECT_THAT(said_by([&] { store.get_chunk({"c1", 128, 32}); }), HasSubstr("damaged"));
}

// With checksums of their own, such chunks are what no study has stored.
TEST(ResultStore, ChunksThatOverlapAreRefusedByTheirRuns) {
  const ScratchDirectory scratch;
  const auto complaint = [&](std::int64_t first_run, std::int64_t runs) {
    std::filesystem::remove_all(scratch / "a");
    ResultStore store = filled(scratch / "a", 0, 2);
    store.put_chunk({"c1", first_run, runs}, payload(9));
    return said_by([&] { store.chunks("c1"); });
  };
  EXPECT_THAT(
      complaint(32, 64),
      HasSubstr("a/results.sqlite: runs 0 to 63 and runs 32 to 95 of configuration c1 overlap, as those "
                "of no study do"));
  EXPECT_THAT(complaint(10, 1), HasSubstr("runs 0 to 63 and runs 10 to 10 of configuration c1 overlap"));
  EXPECT_THAT(complaint(0, 100), HasSubstr("runs 0 to 99 and runs 64 to 127 of configuration c1 overlap"));
  for (const auto& [first_run, runs] : {std::pair{0, 32}, {64, 36}, {64, 80}, {128, 64}, {192, 1}})
    EXPECT_EQ(complaint(first_run, runs), "nothing") << first_run << " and " << runs;
}

TEST(ResultStore, RefusesRunsThatNoStudyHas) {
  const ScratchDirectory scratch;
  { filled(scratch / "a", 0, 2); }
  for (const auto& [change, chunk] :
       {std::pair{"first_run = -64", "64 runs from run -64"},
        std::pair{"first_run = 9223372036854775800", "64 runs from run 9223372036854775800"},
        std::pair{"first_run = 64, runs = 9223372036854775807", "9223372036854775807 runs from run 64"},
        std::pair{"runs = 0", "0 runs from run 64"}}) {
    run_sql(scratch.database("a"), fmt::format("UPDATE chunks SET {} WHERE first_run <> 0", change).c_str());
    const ResultStore store = ResultStore::open_to_read(scratch / "a");
    EXPECT_THAT(said_by([&] { store.chunks("c1"); }),
                AllOf(HasSubstr("a/results.sqlite: holds a chunk of "), HasSubstr(chunk)));
    run_sql(scratch.database("a"), "UPDATE chunks SET first_run = 64, runs = 64 WHERE first_run <> 0");
  }
  ResultStore store = ResultStore::open_to_write(scratch / "a", kVersion);
  EXPECT_THROW(store.put_chunk({"c1", 1'000'000'000'000'000, 64}, payload(1)), std::invalid_argument);
}

TEST(ResultStore, MergesNothingThatOverlapsWhatIsThere) {
  const ScratchDirectory scratch;
  ResultStore whole = filled(scratch / "a", 0, 2), other = filled(scratch / "b", 4, 5);
  other.put_chunk({"c1", 96, 64}, payload(3));
  EXPECT_THAT(said_by([&] { whole.merge_from(other); }),
              HasSubstr("a/results.sqlite: runs 64 to 127 and runs 96 to 159 of configuration c1 overlap"));
  EXPECT_THAT(whole.chunks("c1"), ElementsAre(chunk(0), chunk(1)));
}

TEST(ResultStore, RefusesFilesThatAreNoStoreAndLeavesThem) {
  const ScratchDirectory scratch;
  std::filesystem::create_directories(scratch / "text");
  std::ofstream(scratch.database("text")) << "this is a text of more than sixteen bytes\n";
  std::filesystem::create_directories(scratch / "foreign");
  run_sql(scratch.database("foreign"), "CREATE TABLE addresses(name TEXT)");
  { filled(scratch / "newer", 0, 1); }
  run_sql(scratch.database("newer"), "PRAGMA user_version = 3");
  for (const bool writing : {false, true}) {
    const auto open = [&](const char* name) {
      return said_by([&] {
        writing ? ResultStore::open_to_write(scratch / name, kVersion)
                : ResultStore::open_to_read(scratch / name);
      });
    };
    EXPECT_THAT(open("text"), AllOf(HasSubstr("text/results.sqlite"), HasSubstr("no result store")));
    EXPECT_THAT(open("foreign"), HasSubstr("another program"));
    EXPECT_THAT(open("newer"), HasSubstr("newer version (layout 3"));
  }
  std::string word;
  std::ifstream(scratch.database("text")) >> word;
  EXPECT_EQ(word, "this");
}

TEST(ResultStore, RefusesDirectoriesItCannotUse) {
  const ScratchDirectory scratch;
  EXPECT_THAT(said_by([&] { ResultStore::open_to_read(scratch / "missing"); }),
              AllOf(HasSubstr("missing: "), HasSubstr("no results")));
  EXPECT_FALSE(std::filesystem::exists(scratch / "missing"));
  std::ofstream(scratch / "file") << "x";
  EXPECT_THAT(said_by([&] { ResultStore::open_to_write(scratch / "file", kVersion); }), HasSubstr("file: "));
  EXPECT_THAT(said_by([&] { ResultStore::open_to_write(scratch / "file/below", kVersion); }),
              HasSubstr("below: "));
  EXPECT_THAT(said_by([&] { ResultStore::open_to_write("/proc/credence", kVersion); }),
              HasSubstr("/proc/credence: "));
  std::filesystem::create_directories(scratch / "empty");
  std::ofstream(scratch.database("empty")).flush();
  EXPECT_THAT(said_by([&] { ResultStore::open_to_read(scratch / "empty"); }), HasSubstr("no results yet"));
}

TEST(ResultStore, ReadsWhereItCannotWrite) {
  const ScratchDirectory scratch;
  { filled(scratch / "odd ?name#%20", 0, 2); }
  const auto directory = scratch / "odd ?name#%20";
  std::filesystem::permissions(directory,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const bool is_root = access(directory.c_str(), W_OK) == 0;  // whom no permission stops
  EXPECT_EQ(ResultStore::open_to_read(directory).chunks("c1").size(), 2U);
  if (!is_root) {
    std::filesystem::remove(directory / "results.sqlite.lock");
    EXPECT_THAT(said_by([&] { ResultStore::open_to_write(directory, kVersion); }),
                HasSubstr("cannot be written"));
  }
  std::filesystem::permissions(directory, std::filesystem::perms::owner_all);
  const SqliteDatabase frozen(directory / "results.sqlite", SqliteDatabase::Mode::immutable);
  EXPECT_EQ(frozen.integer("SELECT count(*) FROM chunks"), 2);
}

TEST(ResultStore, WhoReadsLeavesNothingBehind) {
  const ScratchDirectory scratch;
  filled(scratch / "a", 0, 3);
  const auto files = [&] {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(scratch / "a"))
      names.insert(entry.path().filename().string());
    return names;
  };
  const std::set<std::string> before = files();
  {
    const ResultStore first = ResultStore::open_to_read(scratch / "a"),
                      second = ResultStore::open_to_read(scratch / "a");
    EXPECT_EQ(first.chunks("c1").size(), 3U);
    EXPECT_EQ(second.chunks("c1").size(), 3U);
  }
  EXPECT_EQ(files(), before);
}

TEST(ResultStore, MergesShards) {
  const ScratchDirectory scratch;
  const ResultStore first = filled(scratch / "a", 0, 5);
  const ResultStore second = filled(scratch / "b", 3, 8);
  ResultStore whole = ResultStore::open_to_write(scratch / "out", kVersion);
  const auto one = whole.merge_from(first), two = whole.merge_from(second), again = whole.merge_from(second);
  EXPECT_EQ(one.added, 5);
  EXPECT_EQ(two.added, 3);
  EXPECT_EQ(two.already_there, 2);
  EXPECT_EQ(again.added, 0);
  EXPECT_EQ(whole.scenario(), scenario_text());
  ASSERT_EQ(whole.chunks("c1").size(), 8U);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(whole.get_chunk(chunk(i)), payload(i));
}

TEST(ResultStore, MergesAllOfAShardOrNothing) {
  const ScratchDirectory scratch;
  ResultStore whole = filled(scratch / "a", 4, 5);
  {
    ResultStore other = filled(scratch / "b", 0, 3);
    other.put_chunk(chunk(4), payload(99));
  }
  const ResultStore contradicting = ResultStore::open_to_read(scratch / "b");
  EXPECT_THAT(said_by([&] { whole.merge_from(contradicting); }),
              AllOf(HasSubstr("runs 256 to 319"), HasSubstr("other bits")));
  EXPECT_THAT(whole.chunks("c1"), ElementsAre(chunk(4)));
  whole.put_chunk(chunk(5), payload(5));  // and the store goes on
  EXPECT_EQ(whole.chunks("c1").size(), 2U);
  ResultStore foreign = ResultStore::open_to_write(scratch / "c", kVersion);
  foreign.require_same_scenario(scenario_text({"study.seed=2"}));
  EXPECT_THAT(said_by([&] { whole.merge_from(foreign); }), HasSubstr("- study.seed = 1\n+ study.seed = 2"));
}

TEST(ResultStore, ANameIsKeptAndReadByOthers) {
  const ScratchDirectory scratch;
  EXPECT_FALSE(ResultStore::exists(scratch / "a"));
  ResultStore store = ResultStore::open_to_write(scratch / "a", kVersion);
  EXPECT_TRUE(ResultStore::exists(scratch / "a"));
  EXPECT_EQ(store.name(), "") << "as in stores of versions without it";
  store.set_name("loop");
  store.set_name("planar loop");
  const ResultStore reader = ResultStore::open_to_read(scratch / "a");
  EXPECT_EQ(reader.name(), "planar loop");
}

TEST(ResultStore, TheWriterIsToldAsLongAsThereIsOne) {
  if (!std::filesystem::exists("/proc/locks")) GTEST_SKIP() << "the system does not tell";
  const ScratchDirectory scratch;
  EXPECT_EQ(ResultStore::writer(scratch / "a"), std::nullopt);
  {
    const ResultStore store = ResultStore::open_to_write(scratch / "a", kVersion);
    EXPECT_EQ(ResultStore::writer(scratch / "a"), getpid());
    const ResultStore reader = ResultStore::open_to_read(scratch / "a");
    EXPECT_EQ(ResultStore::writer(scratch / "a"), getpid());
  }
  EXPECT_EQ(ResultStore::writer(scratch / "a"), std::nullopt)
      << "the file stays, and means nothing by itself";
}

}  // namespace
}  // namespace credence::internal
