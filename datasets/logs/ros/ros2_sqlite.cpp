#include "datasets/logs/ros/ros2_sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <map>
#include <memory>

#include "core/stop_point.h"
#include "datasets/data_error.h"

namespace credence::internal {
namespace {

constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

class Database {
 public:
  explicit Database(const std::filesystem::path& file) : file_(file) {
    sqlite3* raw = nullptr;
    const int status = sqlite3_open_v2(file.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(raw);
    if (status != SQLITE_OK) fail();
  }

  [[noreturn]] void fail() const {
    const int kind = sqlite3_errcode(database_.get());
    const bool damaged = kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB;
    fail(damaged ? "is damaged: what can still be read of it is saved by `sqlite3 OLD .recover | sqlite3 NEW`"
                 : sqlite3_errmsg(database_.get()));
  }
  [[noreturn]] void fail(const std::string& problem) const {
    throw DataError(file_, "", fmt::format("{} (a bag of ROS 2 has tables topics and messages)", problem));
  }

  /// Calls `row` with each row of an answer.
  template <class Row>
  void query(const char* sql, Row row) const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &raw, nullptr) != SQLITE_OK) fail();
    const std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> statement(raw, sqlite3_finalize);
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(raw)) == SQLITE_ROW) {
      stop_point();
      row(raw);
    }
    if (status != SQLITE_DONE) fail();
  }

 private:
  std::filesystem::path file_;
  std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database_{nullptr, sqlite3_close};
};

std::string text(sqlite3_stmt* row, int column) {
  const unsigned char* const value = sqlite3_column_text(row, column);
  return value == nullptr ? "" : reinterpret_cast<const char*>(value);
}

}  // namespace

bool begins_as_sqlite(std::string_view beginning) { return beginning.starts_with(kSqliteMagic); }

void scan_ros2_sqlite(const std::filesystem::path& file, const RosVisitor& visitor) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw DataError(file, "", "there is no such file");
  const Database database(file);
  // A view may give rows for ever, and none before all are sorted.
  database.query("SELECT name FROM sqlite_master WHERE type = 'view' AND name IN ('topics', 'messages')",
                 [&](sqlite3_stmt* row) { database.fail(text(row, 0) + " is a view"); });
  std::map<std::int64_t, std::size_t> topics;
  database.query(
      "SELECT id, name, type, serialization_format FROM topics ORDER BY id", [&](sqlite3_stmt* row) {
        RosTopic topic{.name = text(row, 1), .type = type_of_ros_1(text(row, 2))};
        if (text(row, 3) == "cdr") topic.encoding = RosTopic::Encoding::cdr;
        const auto [place, is_new] = topics.try_emplace(sqlite3_column_int64(row, 0), topics.size());
        if (is_new) visitor.topic(place->second, topic);
      });
  database.query("SELECT topic_id, timestamp, data, id FROM messages ORDER BY timestamp",
                 [&](sqlite3_stmt* row) {
                   const auto topic = topics.find(sqlite3_column_int64(row, 0));
                   const std::int64_t id = sqlite3_column_int64(row, 3);
                   if (topic == topics.end())
                     database.fail(fmt::format("message {} is of a topic that is not there", id));
                   const auto* const data = static_cast<const std::uint8_t*>(sqlite3_column_blob(row, 2));
                   const auto size = static_cast<std::size_t>(sqlite3_column_bytes(row, 2));
                   const ByteOrigin origin{file, fmt::format("message {}", id)};
                   visitor.message(topic->second, 1e-9 * static_cast<double>(sqlite3_column_int64(row, 1)),
                                   ByteCursor(Bytes(data, size), origin, 0));
                   visitor.advance(static_cast<std::int64_t>(size));
                 });
}

}  // namespace credence::internal
