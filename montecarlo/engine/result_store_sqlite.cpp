#include "montecarlo/engine/result_store_sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cstring>

#include "montecarlo/engine/result_store_disk.h"
#include "montecarlo/engine/result_store_error.h"

namespace credence::internal {
namespace {

/// How long to wait for another program that writes to the file, a browser of databases or a backup: long,
/// since what it holds up may be days of work.
constexpr int kBusyMilliseconds = 30'000;

std::string uri(const std::filesystem::path& file) {
  std::string text = "file:";
  for (const char c : file.string()) {
    if (c == '%' || c == '?' || c == '#') {
      text += fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      text += c;
    }
  }
  return text + "?immutable=1";
}

std::string reason(sqlite3* database, int code) {
  const int system = database == nullptr ? 0 : sqlite3_system_errno(database);
  if (system != 0) return std::strerror(system);
  return database == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(database);
}

std::string explain(sqlite3* database, int code) {
  switch (code & 0xFF) {  // the upper bits give the kind of the kind
    case SQLITE_FULL: return std::string(kDiskIsFull);
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return "is locked by another process";
    case SQLITE_NOTADB: return fmt::format("is no result store, or one that is damaged: {}", kDamageAdvice);
    case SQLITE_CORRUPT: return fmt::format("is damaged: {}", kDamageAdvice);
    case SQLITE_ERROR:  // our statements are right, and the tables not those that they name
      return fmt::format("is damaged ({}): {}", reason(database, code), kDamageAdvice);
    case SQLITE_READONLY:
    case SQLITE_PERM: return "cannot be written to (it is read-only)";
    case SQLITE_CANTOPEN: return fmt::format("cannot be opened ({})", reason(database, code));
    case SQLITE_IOERR:
      return fmt::format("cannot be read or written ({}); what is stored is kept", reason(database, code));
    default: return reason(database, code);
  }
}

}  // namespace

void SqliteStatement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

SqliteStatement::SqliteStatement(const SqliteDatabase& database, std::string_view sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code =
      sqlite3_prepare_v2(database.handle(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  if (code != SQLITE_OK) database_.fail(code);
  statement_.reset(statement);
}

SqliteStatement& SqliteStatement::bind(int parameter, std::int64_t value) {
  const int code = sqlite3_bind_int64(statement_.get(), parameter, value);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int parameter, std::string_view text) {
  // A null pointer would be NULL, not the empty text. SQLite copies: the argument may be a temporary.
  const char* data = text.empty() ? "" : text.data();
  const int code =
      sqlite3_bind_text64(statement_.get(), parameter, data, text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int parameter, std::span<const std::byte> blob) {
  const void* data = blob.empty() ? static_cast<const void*>("") : blob.data();
  const int code = sqlite3_bind_blob64(statement_.get(), parameter, data, blob.size(), SQLITE_TRANSIENT);
  if (code != SQLITE_OK) database_.fail(code);
  return *this;
}

bool SqliteStatement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_.fail(code);
  return false;
}

std::int64_t SqliteStatement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string SqliteStatement::text(int column) const {
  const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return data == nullptr ? std::string() : std::string(data, size);
}

std::vector<std::byte> SqliteStatement::blob(int column) const {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return data == nullptr ? std::vector<std::byte>() : std::vector<std::byte>(data, data + size);
}

void SqliteDatabase::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

SqliteDatabase::SqliteDatabase(const std::filesystem::path& file, Mode mode) : file_(file.string()) {
  for (const char* part : kDatabaseFiles) require_regular_file(file_ + part);
  // Absolute, since a relative name might begin with "file:" and be taken for a URI.
  const std::filesystem::path absolute = std::filesystem::absolute(file);
  const bool immutable = mode == Mode::immutable;
  // Who reads beside a writer opens to write, where it may: SQLite then removes its log and its shared memory
  // when the last one closes.
  const int access = mode == Mode::create ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                     : mode == Mode::read ? SQLITE_OPEN_READWRITE
                                          : SQLITE_OPEN_READONLY;
  const int flags = access | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE | (immutable ? SQLITE_OPEN_URI : 0);
  sqlite3* database = nullptr;
  const std::string name = immutable ? uri(absolute) : absolute.string();
  const int code = sqlite3_open_v2(name.c_str(), &database, flags, nullptr);
  handle_.reset(database);
  if (code != SQLITE_OK) fail(code);
  sqlite3_busy_timeout(database, kBusyMilliseconds);
  if (mode == Mode::read) execute("PRAGMA query_only=ON");
}

void SqliteDatabase::execute(const std::string& sql) const {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

std::int64_t SqliteDatabase::integer(std::string_view sql) const {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::string SqliteDatabase::text(std::string_view sql) const {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.text(0) : std::string();
}

bool SqliteDatabase::in_transaction() const { return sqlite3_get_autocommit(handle_.get()) == 0; }

void SqliteDatabase::require_in_place() const {
  int moved = 0;
  sqlite3_file_control(handle_.get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  if (moved == 0) return;
  throw StoreError(
      fmt::format("{}: was moved or removed while results were written to it; they are not there", file_));
}

void SqliteDatabase::fail(int code) const {
  throw StoreError(fmt::format("{}: {}", file_, explain(handle_.get(), code)));
}

}  // namespace credence::internal
