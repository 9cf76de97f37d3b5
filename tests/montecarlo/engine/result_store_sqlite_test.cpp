#include "montecarlo/engine/result_store_sqlite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "montecarlo/engine/result_store_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using DatabaseMode = SqliteDatabase::Mode;

template <class Action>
std::string database_refusal(const Action& action) {
  try {
    action();
  } catch (const StoreError& error) {
    return error.what();
  }
  return "done";
}

TEST(SqliteStatement, gives_back_every_value_that_was_bound) {
  const TemporaryFolder folder;
  const SqliteDatabase database(folder / "a.sqlite", DatabaseMode::create);
  database.execute("CREATE TABLE t(i INTEGER, s TEXT NOT NULL, b BLOB NOT NULL)");
  const std::string text("null\0inside, ä", 15);
  const std::vector<std::byte> bytes = {std::byte{0}, std::byte{255}, std::byte{0}};
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  SqliteStatement(database, "INSERT INTO t VALUES(?, ?, ?)")
      .bind(1, kLeast)
      .bind(2, text)
      .bind(3, bytes)
      .run();
  SqliteStatement(database, "INSERT INTO t VALUES(?, ?, ?)")
      .bind(1, std::int64_t{1})
      .bind(2, std::string_view())
      .bind(3, std::span<const std::byte>())
      .run();
  SqliteStatement rows(database, "SELECT i, s, b FROM t ORDER BY i");
  ASSERT_TRUE(rows.step());
  EXPECT_EQ(rows.integer(0), kLeast);
  EXPECT_EQ(rows.text(1), text);
  EXPECT_EQ(rows.blob(2), bytes);
  ASSERT_TRUE(rows.step());
  EXPECT_EQ(rows.text(1), "") << "empty is not NULL";
  EXPECT_TRUE(rows.blob(2).empty());
  EXPECT_FALSE(rows.step());
}

TEST(SqliteStatement, an_argument_may_be_gone_when_it_runs) {
  const TemporaryFolder folder;
  const SqliteDatabase database(folder / "a.sqlite", DatabaseMode::create);
  SqliteStatement statement(database, "SELECT ?");
  {
    std::string text(1000, 'a');
    statement.bind(1, text);
    text.assign(1000, 'b');
  }
  ASSERT_TRUE(statement.step());
  EXPECT_EQ(statement.text(0), std::string(1000, 'a'));
}

TEST(SqliteDatabase, names_its_file_in_every_failure) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "a.sqlite";
  const SqliteDatabase database(file, DatabaseMode::create);
  const auto named = StartsWith(file.string() + ": ");
  EXPECT_THAT(database_refusal([&] { database.execute("NO SQL"); }), AllOf(named, HasSubstr("syntax error")));
  EXPECT_THAT(database_refusal([&] { SqliteStatement(database, "SELECT * FROM none"); }),
              AllOf(named, HasSubstr("no such table")));
  EXPECT_THAT(database_refusal([&] { SqliteStatement(database, "SELECT ?").bind(2, std::int64_t{1}); }),
              named);
  database.execute("CREATE TABLE t(x INTEGER PRIMARY KEY); INSERT INTO t VALUES(1)");
  EXPECT_THAT(database_refusal([&] { SqliteStatement(database, "INSERT INTO t VALUES(1)").run(); }),
              AllOf(named, HasSubstr("UNIQUE constraint failed")));
}

TEST(SqliteDatabase, says_what_to_do_about_damage_in_words_of_its_own) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("a.sqlite", std::string(5000, 'x'));
  const auto refusal = [&] {
    return database_refusal(
        [&] { SqliteDatabase(file, DatabaseMode::read).integer("SELECT count(*) FROM sqlite_master"); });
  };
  const std::string advice =
      "delete or move the file, and its runs are played again by the command that stored them";
  EXPECT_EQ(refusal(), file.string() + ": is no result store, or one that is damaged: " + advice);
  std::filesystem::remove(file);
  SqliteDatabase(file, DatabaseMode::create).execute("CREATE TABLE t(x)");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_EQ(refusal(), file.string() + ": is damaged: " + advice);
  std::filesystem::remove(file);
  const SqliteDatabase database(file, DatabaseMode::create);
  database.execute("CREATE TABLE t(x)");
  EXPECT_EQ(database_refusal([&] { database.integer("SELECT y FROM t"); }),
            file.string() + ": is damaged (no such column: y): " + advice);
}

TEST(SqliteDatabase, waits_for_no_pipe_in_place_of_a_file_of_its_own) {
  for (const char* part : {"", "-journal", "-wal", "-shm"}) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "a.sqlite", pipe = file.string() + part;
    if (pipe != file) SqliteDatabase(file, DatabaseMode::create).execute("CREATE TABLE t(x)");
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const DatabaseMode mode : {DatabaseMode::create, DatabaseMode::read})
      EXPECT_THAT(database_refusal([&] { const SqliteDatabase database(file, mode); }),
                  StartsWith(pipe.string() + ": is no regular file"));
  }
}

TEST(SqliteDatabase, the_first_number_or_text_of_nothing_is_nothing) {
  const TemporaryFolder folder;
  const SqliteDatabase database(folder / "a.sqlite", DatabaseMode::create);
  database.execute("CREATE TABLE t(x)");
  EXPECT_EQ(database.integer("SELECT x FROM t"), 0);
  EXPECT_EQ(database.text("SELECT x FROM t"), "");
  database.execute("INSERT INTO t VALUES(7), (8)");
  EXPECT_EQ(database.integer("SELECT x FROM t"), 7);
  EXPECT_EQ(database.text("SELECT 'a'"), "a");
}

TEST(SqliteDatabase, knows_whether_it_is_in_a_transaction) {
  const TemporaryFolder folder;
  const SqliteDatabase database(folder / "a.sqlite", DatabaseMode::create);
  EXPECT_FALSE(database.in_transaction());
  database.execute("BEGIN");
  EXPECT_TRUE(database.in_transaction());
  database.execute("ROLLBACK");
  EXPECT_FALSE(database.in_transaction());
}

TEST(SqliteDatabase, what_is_read_is_made_by_nobody_and_changed_by_nobody) {
  const TemporaryFolder folder;
  for (const DatabaseMode mode : {DatabaseMode::read, DatabaseMode::immutable}) {
    EXPECT_THAT(database_refusal([&] {
                  const SqliteDatabase database(folder / "none.sqlite", mode);
                  database.integer("SELECT count(*) FROM sqlite_master");
                }),
                HasSubstr("none.sqlite: cannot be opened"));
  }
  EXPECT_EQ(folder.entries(), 0);
  { SqliteDatabase(folder / "a.sqlite", DatabaseMode::create).execute("CREATE TABLE t(x)"); }
  for (const DatabaseMode mode : {DatabaseMode::read, DatabaseMode::immutable}) {
    const SqliteDatabase database(folder / "a.sqlite", mode);
    EXPECT_THAT(database_refusal([&] { database.execute("INSERT INTO t VALUES(1)"); }),
                HasSubstr("read-only"));
  }
}

// Signs of a URI mean themselves: "?" begins its options, "%" an escape, and "file:" the URI itself.
TEST(SqliteDatabase, a_name_is_no_uri) {
  const TemporaryFolder folder;
  for (const char* name : {"a?mode=memory", "b%41", "c#d", "file:e", "ä ü"}) {
    const std::filesystem::path file = folder / name;
    { SqliteDatabase(file, DatabaseMode::create).execute("CREATE TABLE t(x); INSERT INTO t VALUES(5)"); }
    EXPECT_TRUE(std::filesystem::exists(file)) << name;
    for (const DatabaseMode mode : {DatabaseMode::read, DatabaseMode::immutable}) {
      EXPECT_EQ(SqliteDatabase(file, mode).integer("SELECT x FROM t"), 5) << name;
    }
  }
}

TEST(SqliteDatabase, says_that_its_file_went_away) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "a.sqlite";
  const SqliteDatabase database(file, DatabaseMode::create);
  database.execute("CREATE TABLE t(x)");
  EXPECT_EQ(database_refusal([&] { database.require_in_place(); }), "done");
  std::filesystem::rename(file, folder / "b.sqlite");
  EXPECT_THAT(database_refusal([&] { database.require_in_place(); }),
              AllOf(HasSubstr("a.sqlite: "), HasSubstr("moved or removed")));
}

}  // namespace
}  // namespace credence::internal
