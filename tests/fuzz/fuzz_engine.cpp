#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "montecarlo/engine/packed_bytes.h"
#include "montecarlo/engine/rank_messages.h"
#include "montecarlo/engine/result_store.h"
#include "montecarlo/engine/study_statistics.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/scenario/sweep_plan_values.h"

/// @file
/// The entry of libFuzzer for what CREDENCE_FUZZ_TARGET names: any bytes give a value, which written and read
/// again is the same, or one error of the kind that a user may see; everything else is a finding.

namespace credence::internal {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void fuzz_scenario(std::string_view text) {
  const Scenario scenario = load_scenario_text(text, "fuzz.toml");
  const std::string canonical = canonical_toml(scenario);
  require(canonical_toml(load_scenario_text(canonical, "fuzz.toml")) == canonical);
}

void fuzz_override(std::string_view text) {
  const std::vector<std::string> overrides{std::string(text)};
  load_scenario_text("[world]\nmodel = \"planar\"\n", "fuzz.toml", overrides);
}

void fuzz_sweep(std::string_view text) { require(expand_sweep_list(text).size() <= 1'000'000); }

/// What reads bytes and writes them again.
void fuzz_bytes(std::string_view target, std::span<const std::byte> bytes) {
  if (target == "chunk") {
    const std::vector<std::byte> again = to_bytes(statistics_from_bytes(bytes));
    require(to_bytes(statistics_from_bytes(again)) == again);
  } else if (target == "message") {
    const std::vector<std::byte> again = to_bytes(rank_message_from_bytes(bytes));
    require(to_bytes(rank_message_from_bytes(again)) == again);
  } else {
    const std::vector<std::byte> content = unpacked(bytes);
    require(unpacked(packed(content)) == content);
  }
}

/// The file as a store: all of it is looked at.
void fuzz_store(std::span<const std::byte> bytes) {
  static const std::filesystem::path folder =
      std::filesystem::path("/dev/shm") / ("credence-fuzz-" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  for (const char* rest : {"results.sqlite-wal", "results.sqlite-shm"})
    std::filesystem::remove(folder / rest);
  std::ofstream(folder / "results.sqlite", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const ResultStore store = ResultStore::open_to_read(folder);
  for (const std::string& id : store.configurations()) {
    store.configuration(id);
    for (const ChunkKey& key : store.chunks(id)) store.get_chunk(key);
  }
}

void fuzz(std::string_view target, const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto bytes = std::as_bytes(std::span(data, size));
  if (target == "scenario") return fuzz_scenario(text);
  if (target == "override") return fuzz_override(text);
  if (target == "sweep") return fuzz_sweep(text);
  if (target == "store") return fuzz_store(bytes);
  fuzz_bytes(target, bytes);
}

}  // namespace
}  // namespace credence::internal

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace credence;
  using namespace credence::internal;
  try {
    fuzz(CREDENCE_FUZZ_TARGET, data, size);
  } catch (const std::invalid_argument&) {  // ScenarioError among them
  } catch (const std::runtime_error&) {     // StoreError, and bytes that are none of ours
  }
  return 0;
}
