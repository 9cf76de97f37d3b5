#include "datasets/logs/ros/ros2_sqlite.h"

#include <gmock/gmock.h>
#include <sqlite3.h>

#include "datasets/data_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kBagTables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT, serialization_format TEXT, "
    "offered_qos_profiles TEXT);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";

/// A database of statements, read as a bag.
class Ros2Sqlite : public ::testing::Test {
 protected:
  void write(const std::string& statements) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file().c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  void scan() {
    scan_ros2_sqlite(file(), {.topic =
                                  [&](std::size_t i, const RosTopic& topic) {
                                    EXPECT_EQ(i, topics_.size());
                                    topics_.push_back(topic);
                                  },
                              .message =
                                  [&](std::size_t i, double time_s, ByteCursor message) {
                                    of_.push_back(i);
                                    times_.push_back(time_s);
                                    bytes_.emplace_back(message.take_text(message.left()));
                                  },
                              .advance = [&](std::int64_t count) { advanced_ += count; }});
  }

  void expect_error(const std::string& problem) {
    EXPECT_THAT([&] { scan(); }, ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
  }

  std::filesystem::path file() const { return folder_ / "log.db3"; }

  TemporaryFolder folder_;
  std::vector<RosTopic> topics_;
  std::vector<std::size_t> of_;
  std::vector<double> times_;
  std::vector<std::string> bytes_;
  std::int64_t advanced_ = 0;
};

TEST_F(Ros2Sqlite, messages_come_in_the_order_of_their_times) {
  write(std::string(kBagTables) +
        "INSERT INTO topics VALUES (40, '/odom', 'nav_msgs/msg/Odometry', 'cdr', ''), "
        "(3, '/words', 'std_msgs/msg/String', 'json', '');"
        "INSERT INTO messages VALUES (1, 40, 3000000000, x'0001'), (2, 3, 1500000000, x''), "
        "(3, 40, 2000000000, x'ff00ff'), (4, 40, -500000000, NULL);");
  scan();
  ASSERT_EQ(topics_.size(), 2U);
  EXPECT_EQ(topics_[0].name, "/words");
  EXPECT_EQ(topics_[0].encoding, RosTopic::Encoding::other);
  EXPECT_EQ(topics_[1].name, "/odom");
  EXPECT_EQ(topics_[1].type, "nav_msgs/Odometry");
  EXPECT_EQ(topics_[1].encoding, RosTopic::Encoding::cdr);
  EXPECT_THAT(of_, ElementsAre(1U, 0U, 1U, 1U));
  EXPECT_THAT(times_, ElementsAre(-0.5, 1.5, 2.0, 3.0));
  EXPECT_THAT(bytes_, ElementsAre("", "", std::string("\xff\0\xff", 3), std::string("\0\x01", 2)));
  EXPECT_EQ(advanced_, 5);
}

TEST_F(Ros2Sqlite, texts_that_are_missing_are_empty) {
  write(std::string(kBagTables) + "INSERT INTO topics VALUES (1, '/t', NULL, NULL, NULL);");
  scan();
  ASSERT_EQ(topics_.size(), 1U);
  EXPECT_EQ(topics_[0].type, "");
  EXPECT_EQ(topics_[0].encoding, RosTopic::Encoding::other);
}

TEST_F(Ros2Sqlite, a_message_of_a_topic_that_is_not_there_is_named) {
  write(std::string(kBagTables) + "INSERT INTO messages VALUES (17, 2, 0, x'00');");
  expect_error("log.db3: message 17 is of a topic that is not there");
}

TEST_F(Ros2Sqlite, a_view_without_an_end_is_refused) {
  write(
      "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE VIEW messages AS WITH RECURSIVE r(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM r) "
      "SELECT id, id AS topic_id, id AS timestamp, x'00' AS data FROM r;");
  expect_error("messages is a view");
}

TEST_F(Ros2Sqlite, what_is_no_bag_says_what_a_bag_has) {
  const std::string has = "(a bag of ROS 2 has tables topics and messages)";
  expect_error("there is no such file");
  write("CREATE TABLE other(x);");
  expect_error("no such table: topics " + has);
  write("CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT);");
  expect_error("no such table: messages " + has);
  write("CREATE TABLE messages(id INTEGER, topic_id INTEGER, data BLOB);");
  expect_error("no such column: timestamp " + has);
  folder_.write("log.db3", "");
  expect_error("no such table: topics " + has);
  folder_.write("log.db3", std::string("SQLite format 3\0", 16) + "and nothing that fits");
  expect_error(has);
}

TEST_F(Ros2Sqlite, damage_is_told_with_what_saves_the_rest) {
  const std::string damaged = "log.db3: is damaged: what can still be read of it is saved by `sqlite3 OLD";
  write(std::string(kBagTables) + "INSERT INTO topics VALUES (1, '/t', '', 'cdr', '');");
  std::string bytes = folder_.read("log.db3");
  bytes[bytes.find("CREATE TABLE")] ^= 1;  // a schema that is malformed
  folder_.write("log.db3", bytes);
  expect_error(damaged);
  folder_.write("log.db3", bytes.substr(0, bytes.size() / 2));
  expect_error(damaged);
  folder_.write("log.db3", std::string("SQLite format 3\0", 16) + "and nothing that fits");
  expect_error(damaged);
}

TEST_F(Ros2Sqlite, the_file_is_not_changed) {
  write(std::string(kBagTables) + "INSERT INTO topics VALUES (1, '/t', '', 'cdr', '');");
  const std::string before = folder_.read("log.db3");
  scan();
  EXPECT_EQ(folder_.read("log.db3"), before);
  EXPECT_EQ(folder_.entries(), 1);
}

TEST_F(Ros2Sqlite, a_page_of_other_bytes_is_an_error_or_another_bag) {
  write(std::string(kBagTables) +
        "INSERT INTO topics VALUES (1, '/t', 'a/msg/B', 'cdr', '');"
        "INSERT INTO messages VALUES (1, 1, 5, x'00112233'), (2, 1, 6, x'44');");
  const std::string whole = folder_.read("log.db3");
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); at += 13) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x9d);
    folder_.write("log.db3", flipped);
    topics_.clear();
    try {
      scan();
    } catch (const DataError& error) {
      EXPECT_EQ(error.file(), file());
      ++refused;
    }
  }
  EXPECT_GT(refused, 3);
}

TEST(Ros2SqliteMagic, is_that_of_a_database) {
  EXPECT_TRUE(begins_as_sqlite(std::string_view("SQLite format 3\0...", 19)));
  EXPECT_FALSE(begins_as_sqlite("SQLite format 3"));
}

}  // namespace
}  // namespace credence::internal
