#include "montecarlo/engine/rank_messages.h"

#include <string_view>

#include "montecarlo/engine/byte_stream.h"
#include "montecarlo/scenario/scenario_hash.h"

namespace credence::internal {
namespace {

constexpr std::uint32_t kMessageFormat = 0x43725201;  // "CrR", version 1

/// Covers the number too, so that a result under a wrong one is found.
std::uint64_t record_checksum(std::int64_t task, std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return stable_hash(text, static_cast<std::uint64_t>(task) * 0x9e3779b97f4a7c15U);
}

}  // namespace

std::vector<std::byte> to_bytes(const RankMessage& m) {
  ByteWriter w;
  w.put(kMessageFormat);
  w.put(m.kind);
  w.put(m.phase);
  w.put(m.identity);
  w.put(m.range);
  w.put(m.text);
  w.put(static_cast<std::uint64_t>(m.records.size()));
  for (const TaskRecord& record : m.records) {
    w.put(record.task);
    w.put(record_checksum(record.task, record.bytes));
    w.put(std::span<const std::byte>(record.bytes));
  }
  return w.take();
}

RankMessage rank_message_from_bytes(std::span<const std::byte> bytes) {
  ByteReader r(bytes, "a message of another rank");
  if (r.get<std::uint32_t>() != kMessageFormat) r.refuse("has another format");
  RankMessage m;
  r.get(m.kind);
  if (m.kind > RankMessage::Kind::bye) r.refuse("is of an unknown kind");
  r.get(m.phase);
  r.get(m.identity);
  r.get(m.range);
  r.get(m.text);
  m.records.resize(r.get_count(3 * sizeof(std::uint64_t)));
  for (TaskRecord& record : m.records) {
    r.get(record.task);
    const auto checksum = r.get<std::uint64_t>();
    const auto content = r.get_bytes();
    record.bytes.assign(content.begin(), content.end());
    if (checksum != record_checksum(record.task, record.bytes)) r.refuse("is damaged");
  }
  r.require_end();
  return m;
}

}  // namespace credence::internal
