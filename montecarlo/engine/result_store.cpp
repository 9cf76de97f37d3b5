#include "montecarlo/engine/result_store.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/append_item.h"
#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/engine/result_store_disk.h"
#include "montecarlo/scenario/scenario_difference.h"
#include "montecarlo/scenario/scenario_hash.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kApplication = 0x43726564;  // "Cred", tells the file from any other SQLite database
constexpr std::int64_t kSchema = 2;
constexpr std::int64_t kPackedSince = 2;  // the schema from which on payloads are packed
constexpr std::chrono::milliseconds kCommitInterval{500};
constexpr const char* kFileName = "results.sqlite";

constexpr const char* kTables = R"(
CREATE TABLE meta(name TEXT PRIMARY KEY, value BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE configurations(id TEXT PRIMARY KEY, canonical BLOB NOT NULL) WITHOUT ROWID;
)";

/// The statement that makes a table of payloads by chunk, where it is missing.
std::string payload_table(std::string_view name) {
  return fmt::format(R"(
CREATE TABLE IF NOT EXISTS {}(
  configuration TEXT NOT NULL REFERENCES configurations(id),
  first_run INTEGER NOT NULL,
  runs INTEGER NOT NULL,
  payload BLOB NOT NULL,
  checksum INTEGER NOT NULL,
  PRIMARY KEY(configuration, first_run, runs));
)",
                     name);
}

std::filesystem::path made_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw StoreError(fmt::format("{}: cannot be made ({})", directory.string(), error.message()));
  return directory;
}

std::filesystem::path lock_file(const std::filesystem::path& directory) {
  return (directory / kFileName) += ".lock";
}

void remove_database(const std::filesystem::path& directory) {
  std::error_code error;
  for (const char* suffix : kDatabaseFiles) {
    const std::filesystem::path file = directory / (std::string(kFileName) + suffix);
    std::filesystem::remove(file, error);
    if (error) throw StoreError(fmt::format("{}: cannot be removed ({})", file.string(), error.message()));
  }
}

/// Whether a file begins as a store of results does, or as one that was hardly begun: by its head alone,
/// since SQLite refuses one that is damaged or cut, which is to be removed all the same.
bool begins_as_store(const std::filesystem::path& file) {
  constexpr std::size_t kPagesAt = 28, kApplicationAt = 68, kHead = 72;  // big-endian, as SQLite has them
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return false;
  const auto size = std::filesystem::file_size(file, error);
  if (size == 0) return true;
  std::array<char, kHead> head{};
  std::ifstream(file, std::ios::binary).read(head.data(), kHead);
  if (std::string_view(head.data(), kMagic.size()) != kMagic) return false;
  const auto number_at = [&head](std::size_t place) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = number << 8U | static_cast<unsigned char>(head[place + i]);
    return number;
  };
  const bool has_no_tables = number_at(kPagesAt) <= 1;
  const std::uint32_t application = number_at(kApplicationAt);
  return application == kApplication || (application == 0 && has_no_tables);
}

/// Whether SQLite must be told that nobody writes: it cannot make its shared memory, in a folder that is not
/// ours or on a full disk, and there is no log to read.
bool is_frozen(const std::filesystem::path& directory) {
  if (access(directory.c_str(), W_OK) == 0 && has_room(directory / kFileName)) return false;
  std::error_code error;
  const auto log_size = std::filesystem::file_size(directory / (std::string(kFileName) + "-wal"), error);
  return error || log_size == 0;
}

std::string describe(const ChunkKey& key) {
  return fmt::format("runs {} to {} of configuration {}", key.first_run, key.first_run + key.runs - 1,
                     key.configuration);
}

/// Covers the key too, so that a payload under a wrong key is found.
std::int64_t checksum(const ChunkKey& key, std::span<const std::byte> payload) {
  const std::string_view bytes(reinterpret_cast<const char*>(payload.data()), payload.size());
  return static_cast<std::int64_t>(stable_hash(bytes, stable_hash(describe(key))));
}

// Far beyond what a study may have, and so small that sums of two are no overflow.
constexpr std::int64_t kLargestRun = 1'000'000'000'000;

bool is_possible(const ChunkKey& key) {
  return key.first_run >= 0 && key.first_run <= kLargestRun && key.runs >= 1 && key.runs <= kLargestRun;
}

void check_key(const ChunkKey& key) {
  if (is_possible(key)) return;
  throw std::invalid_argument(
      fmt::format("a chunk of {} runs from run {}: needs first_run >= 0, runs >= 1, "
                  "and both to be at most {}",
                  key.runs, key.first_run, kLargestRun));
}

/// Throws StoreError for keys that no study has stored, of one configuration in their order. Chunks of the
/// same first run may be there with fewer and with more runs, as the last one of a study that was extended.
void require_apart(const std::string& file, std::span<const ChunkKey> keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!is_possible(keys[i])) {
      throw StoreError(fmt::format("{}: holds a chunk of {} runs from run {}, which no study has", file,
                                   keys[i].runs, keys[i].first_run));
    }
    if (i == 0) continue;
    const ChunkKey &key = keys[i], &before = keys[i - 1];
    const bool follows = key.first_run >= before.first_run + before.runs;
    if (follows || (key.first_run == before.first_run && key.runs > before.runs)) continue;
    throw StoreError(fmt::format("{}: runs {} to {} and {} overlap, as those of no study do", file,
                                 before.first_run, before.first_run + before.runs - 1, describe(key)));
  }
}

}  // namespace

ResultStore::ResultStore(std::filesystem::path directory, SqliteDatabase::Mode mode)
    : directory_(std::move(directory)),
      lock_(mode == SqliteDatabase::Mode::create ? std::make_unique<ResultStoreLock>(lock_file(directory_))
                                                 : nullptr),
      database_(std::make_unique<SqliteDatabase>(directory_ / kFileName, mode)) {}

ResultStore ResultStore::open_to_write(const std::filesystem::path& directory,
                                       std::string_view tool_version) {
  const std::filesystem::path made = made_directory(directory);
  require_room(made / kFileName);
  ResultStore store(made, SqliteDatabase::Mode::create);
  store.writes_as_ = tool_version;
  store.is_new_ = store.database_->integer("PRAGMA application_id") == 0 &&
                  store.database_->integer("SELECT count(*) FROM sqlite_master") == 0;
  if (store.is_new_) {
    store.create_tables(tool_version);
  } else {
    store.check_kind();
  }
  // Each commit is on the disk when it returns; readers go on meanwhile.
  store.database_->execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON");
  store.database_->execute(payload_table("companions"));
  store.has_companions_ = true;
  reserve_shared_memory(directory / kFileName);
  return store;
}

void ResultStore::discard(const std::filesystem::path& directory) {
  if (!exists(directory)) return;
  if (!begins_as_store(directory / kFileName)) {
    throw StoreError(
        fmt::format("{}: is no store of results, and is not removed: name another folder, or "
                    "remove it by hand",
                    (directory / kFileName).string()));
  }
  const ResultStoreLock lock(lock_file(directory));
  remove_database(directory);
}

void ResultStore::take_back() {
  if (!is_new_) return;
  database_.reset();
  remove_database(directory_);
  std::error_code none;
  std::filesystem::remove(lock_file(directory_), none);
  lock_.reset();
}

bool ResultStore::exists(const std::filesystem::path& directory) {
  std::error_code error;
  return std::filesystem::exists(directory / kFileName, error);
}

std::optional<std::int64_t> ResultStore::writer(const std::filesystem::path& directory) {
  return lock_holder(lock_file(directory));
}

ResultStore ResultStore::open_to_read(const std::filesystem::path& directory) {
  if (!exists(directory)) {
    throw StoreError(fmt::format("{}: holds no results (there is no {})", directory.string(), kFileName));
  }
  ResultStore store(directory,
                    is_frozen(directory) ? SqliteDatabase::Mode::immutable : SqliteDatabase::Mode::read);
  if (store.database_->integer("SELECT count(*) FROM sqlite_master") == 0) {
    throw StoreError(fmt::format("{}: holds no results yet", directory.string()));
  }
  store.check_kind();
  return store;
}

ResultStore::~ResultStore() {
  if (!database_ || !failure_.empty()) return;
  try {
    commit();
  } catch (const StoreError&) {  // a destructor cannot report it: commit() is there for who wants to know
  }
}

void ResultStore::create_tables(std::string_view tool_version) {
  database_->execute("BEGIN IMMEDIATE");
  database_->execute(kTables);
  database_->execute(payload_table("chunks"));
  database_->execute(fmt::format("PRAGMA application_id={}; PRAGMA user_version={}", kApplication, kSchema));
  set_meta("tool_version", tool_version);
  database_->execute("COMMIT");
}

void ResultStore::check_kind() {
  const std::string file = (directory_ / kFileName).string();
  if (database_->integer("PRAGMA application_id") != kApplication) {
    throw StoreError(fmt::format("{}: is a database of another program: name another folder", file));
  }
  const std::int64_t schema = database_->integer("PRAGMA user_version");
  packs_ = schema >= kPackedSince;
  has_companions_ = database_->integer("SELECT count(*) FROM sqlite_master WHERE name = 'companions'") > 0;
  if (schema > kSchema) {
    throw StoreError(fmt::format("{}: was written by a newer version (layout {}, this one knows up to {})",
                                 file, schema, kSchema));
  }
  if (database_->text("PRAGMA integrity_check(1)") != "ok") database_->fail(SQLITE_CORRUPT);
}

std::string ResultStore::meta(std::string_view name) const {
  SqliteStatement statement(*database_, "SELECT value FROM meta WHERE name = ?");
  statement.bind(1, name);
  return statement.step() ? statement.text(0) : std::string();
}

void ResultStore::set_meta(std::string_view name, std::string_view value) {
  SqliteStatement(*database_, "INSERT OR REPLACE INTO meta VALUES(?, ?)").bind(1, name).bind(2, value).run();
}

std::string ResultStore::name() const { return meta("name"); }

void ResultStore::set_name(std::string_view name) {
  if (name == this->name()) return;
  write([&] { set_meta("name", name); });
  commit();
}

std::string ResultStore::scenario() const { return meta("scenario"); }

std::string ResultStore::tool_version() const { return meta("tool_version"); }

void ResultStore::require_same_scenario(std::string_view canonical) {
  const std::string stored = scenario();
  if (stored == canonical) return;
  const std::string difference = stored.empty() ? "" : scenario_difference(stored, canonical);
  if (!difference.empty()) {
    throw StoreError(fmt::format(
        "{}: holds results of another scenario (- stored, + asked):\n{}use another --out, or discard "
        "them to start anew (run: --fresh; else delete that directory)",
        directory_.string(), difference));
  }
  if (lock_) {
    write([&] { set_meta("scenario", canonical); });
    commit();
  } else if (stored.empty()) {
    throw StoreError(fmt::format("{}: does not say of what scenario its results are", directory_.string()));
  }
}

void ResultStore::put_configuration(std::string_view id, std::string_view canonical) {
  const std::optional<std::string> stored = configuration(id);
  if (stored && *stored != canonical) {
    throw StoreError(fmt::format("{}: configuration {} is another one here (- stored, + asked):\n{}",
                                 directory_.string(), id, scenario_difference(*stored, canonical)));
  }
  if (stored) return;
  write([&] {
    SqliteStatement(*database_, "INSERT INTO configurations VALUES(?, ?)")
        .bind(1, id)
        .bind(2, canonical)
        .run();
  });
}

std::vector<std::string> ResultStore::configurations() const {
  std::vector<std::string> ids;
  SqliteStatement statement(*database_, "SELECT id FROM configurations ORDER BY id");
  while (statement.step()) ids.push_back(statement.text(0));
  return ids;
}

std::optional<std::string> ResultStore::configuration(std::string_view id) const {
  SqliteStatement statement(*database_, "SELECT canonical FROM configurations WHERE id = ?");
  statement.bind(1, id);
  if (!statement.step()) return std::nullopt;
  return statement.text(0);
}

bool ResultStore::add_chunk(const ChunkKey& key, std::span<const std::byte> payload,
                            std::span<const std::byte> frame) {
  check_key(key);
  require_no_failure();  // a write that fails takes its whole transaction with it, configurations included
  if (const auto stored = get_chunk(key)) {
    if (std::equal(stored->begin(), stored->end(), payload.begin(), payload.end())) return false;
    throw StoreError(
        fmt::format("{}: {} are there with other bits; the same runs must have the same result, so one "
                    "of the two was made by another program or machine",
                    directory_.string(), describe(key)));
  }
  if (!configuration(key.configuration)) {
    throw std::invalid_argument(fmt::format("{}: the configuration was not put before", describe(key)));
  }
  insert("chunks", key, payload, frame);
  return true;
}

void ResultStore::add_versions(std::string_view versions) {
  constexpr std::string_view kBetween = ", ";
  if (versions.empty()) return;
  std::string all = tool_version();
  const std::size_t before = all.size();
  while (!versions.empty()) {
    const std::size_t end = std::min(versions.find(kBetween), versions.size());
    const std::string_view version = versions.substr(0, end);
    versions.remove_prefix(std::min(end + kBetween.size(), versions.size()));
    const bool known = fmt::format(", {}, ", all).find(fmt::format(", {}, ", version)) != std::string::npos;
    if (!known) append_item(all, version);
  }
  if (all.size() > before) write([&] { set_meta("tool_version", all); });
}

void ResultStore::insert(const char* table, const ChunkKey& key, std::span<const std::byte> payload,
                         std::span<const std::byte> frame) {
  write([&] {
    SqliteStatement(*database_, fmt::format("INSERT OR IGNORE INTO {} VALUES(?, ?, ?, ?, ?)", table))
        .bind(1, key.configuration)
        .bind(2, key.first_run)
        .bind(3, key.runs)
        .bind(4, packs_ ? frame : payload)
        .bind(5, checksum(key, payload))
        .run();
  });
}

void ResultStore::put_companion(const ChunkKey& key, std::span<const std::byte> payload,
                                std::span<const std::byte> frame) {
  check_key(key);
  insert("companions", key, payload, frame);
}

std::optional<std::vector<std::byte>> ResultStore::get_companion(const ChunkKey& key) const {
  return has_companions_ ? payload_of("companions", key) : std::nullopt;
}

void ResultStore::put_chunk(const ChunkKey& key, std::span<const std::byte> payload) {
  put_chunk(key, payload, packed(payload));
}

void ResultStore::put_chunk(const ChunkKey& key, std::span<const std::byte> payload,
                            std::span<const std::byte> frame) {
  if (add_chunk(key, payload, frame)) add_versions(std::exchange(writes_as_, {}));
  if (std::chrono::steady_clock::now() - last_commit_ >= kCommitInterval) commit();
}

std::optional<std::vector<std::byte>> ResultStore::get_chunk(const ChunkKey& key) const {
  return payload_of("chunks", key);
}

std::optional<std::vector<std::byte>> ResultStore::payload_of(const char* table, const ChunkKey& key) const {
  SqliteStatement statement(
      *database_,
      fmt::format("SELECT payload, checksum FROM {} WHERE configuration = ? AND first_run = ? AND runs = ?",
                  table));
  statement.bind(1, key.configuration).bind(2, key.first_run).bind(3, key.runs);
  if (!statement.step()) return std::nullopt;
  std::vector<std::byte> payload = statement.blob(0);
  std::string damage;
  try {
    if (packs_) payload = unpacked(payload);
    if (statement.integer(1) != checksum(key, payload)) damage = "their checksum does not fit";
  } catch (const std::runtime_error& error) {
    damage = error.what();
  }
  if (!damage.empty()) refuse(key, damage);
  return payload;
}

void ResultStore::refuse(const ChunkKey& key, const std::string& damage) const {
  throw StoreError(fmt::format("{}: {} are damaged ({}): {}", (directory_ / kFileName).string(),
                               describe(key), damage, kDamageAdvice));
}

std::vector<ChunkKey> ResultStore::chunks(std::string_view configuration) const {
  std::vector<ChunkKey> keys;
  SqliteStatement statement(
      *database_, "SELECT first_run, runs FROM chunks WHERE configuration = ? ORDER BY first_run, runs");
  statement.bind(1, configuration);
  while (statement.step()) {
    keys.push_back({std::string(configuration), statement.integer(0), statement.integer(1)});
  }
  require_apart((directory_ / kFileName).string(), keys);
  return keys;
}

void ResultStore::require_no_failure() const {
  if (failure_.empty()) return;
  throw StoreError(fmt::format("{}: takes no more since a write failed ({})", directory_.string(), failure_));
}

template <class Work>
void ResultStore::or_fail(Work work) {
  try {
    work();
  } catch (const StoreError& error) {
    failure_ = error.what();
    throw;
  }
}

template <class Work>
void ResultStore::write(Work work) {
  if (!lock_) throw StoreError(fmt::format("{}: was opened to read", directory_.string()));
  require_no_failure();
  if (!database_->in_transaction()) database_->execute("BEGIN IMMEDIATE");
  or_fail(work);
}

void ResultStore::commit() {
  if (!lock_) return;
  or_fail([&] {
    if (database_->in_transaction()) database_->execute("COMMIT");
    database_->require_in_place();
  });
  last_commit_ = std::chrono::steady_clock::now();
}

ResultStore::MergeCount ResultStore::merge_from(const ResultStore& other) {
  require_same_scenario(other.scenario());
  commit();
  MergeCount count;
  try {
    for (const std::string& id : other.configurations()) {
      put_configuration(id, other.configuration(id).value_or(""));
      for (const ChunkKey& key : other.chunks(id)) {
        const std::vector<std::byte> payload = other.get_chunk(key).value_or(std::vector<std::byte>());
        const bool added = add_chunk(key, payload, packed(payload));
        ++(added ? count.added : count.already_there);
        const auto companion = other.get_companion(key);
        if (added && companion) put_companion(key, *companion, packed(*companion));
      }
      chunks(id);  // those of both together
    }
    if (count.added > 0) add_versions(other.tool_version());
    commit();
  } catch (...) {
    if (database_->in_transaction()) database_->execute("ROLLBACK");
    throw;
  }
  return count;
}

}  // namespace credence::internal
