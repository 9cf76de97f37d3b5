#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

/// @file
/// As much of SQLite as the result store needs. Every failure is a StoreError that names the file.

namespace credence::internal {

class SqliteDatabase;

/// What the names of the files of a database end with: itself, and what SQLite keeps beside it.
inline constexpr std::array<const char*, 4> kDatabaseFiles = {"", "-journal", "-wal", "-shm"};

/// One prepared statement; parameters count from 1, columns from 0.
class SqliteStatement {
 public:
  SqliteStatement(const SqliteDatabase& database, std::string_view sql);

  SqliteStatement& bind(int parameter, std::int64_t value);
  SqliteStatement& bind(int parameter, std::string_view text);
  SqliteStatement& bind(int parameter, std::span<const std::byte> blob);

  /// Goes to the next row; false when there is none.
  bool step();
  /// Runs a statement that returns no rows.
  void run() {
    while (step()) {
    }
  }

  std::int64_t integer(int column) const;
  std::string text(int column) const;
  std::vector<std::byte> blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  const SqliteDatabase& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

class SqliteDatabase {
 public:
  enum class Mode {
    create,     ///< read and write, made where missing
    read,       ///< beside a writer
    immutable,  ///< of a directory that cannot be written to: no lock, no shared memory, no log
  };
  SqliteDatabase(const std::filesystem::path& file, Mode mode);

  void execute(const std::string& sql) const;
  std::int64_t integer(std::string_view sql) const;  ///< the first column of the first row
  std::string text(std::string_view sql) const;
  bool in_transaction() const;

  /// Throws where the file is no longer found under its name.
  void require_in_place() const;

  /// Throws the StoreError of the result code that SQLite returned.
  [[noreturn]] void fail(int code) const;

  sqlite3* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::string file_;
  std::unique_ptr<sqlite3, Close> handle_;
};

}  // namespace credence::internal
