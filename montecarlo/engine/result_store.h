#pragma once

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/engine/result_store_error.h"
#include "montecarlo/engine/result_store_lock.h"
#include "montecarlo/engine/result_store_sqlite.h"

namespace credence::internal {

/// Names a chunk: runs [first_run, first_run + runs) of a configuration.
struct ChunkKey {
  std::string configuration;  ///< configuration_id
  std::int64_t first_run = 0;
  std::int64_t runs = 0;

  auto operator<=>(const ChunkKey&) const = default;
};

/// The results of one scenario or sweep, in DIR/results.sqlite: chunks of runs as opaque bytes, each packed,
/// under its key and with a checksum, beside the canonical text of what they are results of.
///
/// One process writes at a time, any number read meanwhile. A chunk is there as a whole or not at all, and
/// what was committed survives the end of the process, of whatever kind. Not to be used by two threads at
/// once. All members throw StoreError.
class ResultStore {
 public:
  static constexpr double kMostChunkBytes = 1e9 - 1000;  ///< SQLite takes a row of 10^9 bytes

  /// Opens the store of a directory to write, making both where missing. `tool_version` is kept in a new
  /// store, and beside others in one that it adds chunks to. Refuses a file that is no store, is damaged, or
  /// comes from a newer version, and touches none of them.
  static ResultStore open_to_write(const std::filesystem::path& directory, std::string_view tool_version);

  /// Removes the store of a directory, if there is one, of whatever state; refused while another process
  /// writes to it, and where what is there is no store.
  static void discard(const std::filesystem::path& directory);

  /// Takes a store back that open_to_write has made here, lock and all, while nobody else can write to it;
  /// one that was there before stays. Nothing can be done with it afterwards.
  void take_back();

  /// Opens an existing store to read, also in a directory that cannot be written to.
  static ResultStore open_to_read(const std::filesystem::path& directory);

  ResultStore(ResultStore&&) noexcept = default;
  ResultStore& operator=(ResultStore&&) = delete;
  ~ResultStore();  ///< commits; call commit() to learn whether that succeeds

  /// Whether there is a store in a directory.
  static bool exists(const std::filesystem::path& directory);

  /// The process that writes to the store of a directory now, as far as the system tells.
  static std::optional<std::int64_t> writer(const std::filesystem::path& directory);

  /// What the study is called in reports; empty before the first set_name, and in stores of versions without
  /// it.
  std::string name() const;
  void set_name(std::string_view name);

  /// The canonical text whose results these are; empty before the first require_same_scenario.
  std::string scenario() const;

  /// The tool_versions of all processes that have added chunks, each once, in their order: "0.1.0, 0.2.0".
  std::string tool_version() const;

  /// Makes sure that the store belongs to this canonical text (of a Scenario or SweepPlan), or takes it when
  /// there is none yet. Throws with the difference, key by key, when anything but study.runs,
  /// study.stop or study.confidence differs; these are taken over.
  void require_same_scenario(std::string_view canonical);

  /// Adds a configuration, once; again with the same text it does nothing.
  void put_configuration(std::string_view id, std::string_view canonical);

  /// The ids of all configurations, ascending.
  std::vector<std::string> configurations() const;

  /// The canonical text of a configuration; nothing if it is not there.
  std::optional<std::string> configuration(std::string_view id) const;

  /// Adds a chunk of a configuration that was put before (else std::invalid_argument). Again with the same
  /// bytes it does nothing; with others it throws naming configuration and runs, since the same runs must
  /// have the same bits. Commits by itself unless the last commit is less than half a second ago.
  void put_chunk(const ChunkKey& key, std::span<const std::byte> payload);

  /// The same with packed(payload), which whoever made the payload had time for.
  void put_chunk(const ChunkKey& key, std::span<const std::byte> payload, std::span<const std::byte> frame);

  /// The bytes of a chunk, nothing if it is not there; throws if they fail their checksum.
  std::optional<std::vector<std::byte>> get_chunk(const ChunkKey& key) const;

  /// Throws what tells that a chunk is damaged, to whoever reads its bytes, too; `damage`: in what.
  [[noreturn]] void refuse(const ChunkKey& key, const std::string& damage) const;

  /// Adds what is kept beside a chunk: nothing that a result depends on, so that it may be missing, and once
  /// there it stays. Committed with the next chunk; to be put before its chunk, then.
  void put_companion(const ChunkKey& key, std::span<const std::byte> payload,
                     std::span<const std::byte> frame);

  /// Its bytes, nothing if there are none; throws if they fail their checksum.
  std::optional<std::vector<std::byte>> get_companion(const ChunkKey& key) const;

  /// The keys of all chunks of a configuration, ascending by first run and count. Throws where the runs of
  /// two overlap that do not begin with the same run, or no study has so many.
  std::vector<ChunkKey> chunks(std::string_view configuration) const;

  /// Makes everything put so far permanent. Throws where the file was moved or removed meanwhile.
  void commit();

  struct MergeCount {
    std::int64_t added = 0, already_there = 0;
  };

  /// Adds all configurations and chunks of another store of the same scenario: all of them or, when one
  /// contradicts what is here, none.
  MergeCount merge_from(const ResultStore& other);

 private:
  ResultStore(std::filesystem::path directory, SqliteDatabase::Mode mode);

  void create_tables(std::string_view tool_version);
  void check_kind();
  std::string meta(std::string_view name) const;
  void set_meta(std::string_view name, std::string_view value);
  void require_no_failure() const;
  void add_versions(std::string_view versions);
  bool add_chunk(const ChunkKey& key, std::span<const std::byte> payload, std::span<const std::byte> frame);
  void insert(const char* table, const ChunkKey& key, std::span<const std::byte> payload,
              std::span<const std::byte> frame);
  std::optional<std::vector<std::byte>> payload_of(const char* table, const ChunkKey& key) const;
  template <class Work>
  void write(Work work);
  template <class Work>
  void or_fail(Work work);

  std::filesystem::path directory_;
  std::unique_ptr<ResultStoreLock> lock_;  ///< none when reading; outlives the database
  std::unique_ptr<SqliteDatabase> database_;
  std::chrono::steady_clock::time_point last_commit_{};
  std::string writes_as_;       ///< the version of chunks that are added; empty once it is told
  bool is_new_ = false;         ///< made by open_to_write
  bool packs_ = true;           ///< payloads are packed; not in stores of a version that did not
  bool has_companions_ = true;  ///< not in stores of a version without
  std::string failure_;  ///< why a write failed: what was not committed is gone, and nothing more is taken
};

}  // namespace credence::internal
