#include "datasets/logs/ros/mcap.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <vector>

#include "core/stop_point.h"
#include "datasets/logs/bytes/binary_file.h"
#include "datasets/logs/bytes/decompress.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kMcapRecordHeader = 9;
std::string_view text(ByteCursor& from) { return from.take_text(from.take<std::uint32_t>()); }

class McapReader {
 public:
  McapReader(const std::filesystem::path& file, const RosVisitor& visitor) : file_(file), visitor_(visitor) {}

  void read() {
    ByteCursor magic = file_.cursor(0, kMcapMagic.size(), "the magic of an MCAP");
    if (magic.take_text(kMcapMagic.size()) != kMcapMagic)
      file_.fail(0, "is no MCAP: it does not begin with its magic");
    std::uint64_t at = kMcapMagic.size();
    bool ended = false;
    while (!ended) {
      stop_point();
      ByteCursor header = file_.cursor(at, kMcapRecordHeader, "a record header");
      const auto opcode = header.take<std::uint8_t>();
      const auto size = header.take<std::uint64_t>();
      const std::uint64_t body = at + kMcapRecordHeader;
      if (size > file_.size() - body) {
        file_.fail(at, fmt::format("a record of {} bytes begins here and the file ends at byte {}: cut off, "
                                   "or corrupted",
                                   size, file_.size()));
      }
      ended = opcode == McapOpcode::kDataEnd || opcode == McapOpcode::kFooter;
      if (opcode == McapOpcode::kDataEnd)
        require_checksum(file_.cursor(body, size, "the end of the data").take<std::uint32_t>(), at);
      if (is_read(opcode)) record(opcode, file_.cursor(body, size, "a record"), true);
      at = body + size;
      visitor_.advance(static_cast<std::int64_t>(size + kMcapRecordHeader));
    }
  }

 private:
  /// The others, an attachment of a gigabyte among them, are passed over.
  static bool is_read(std::uint8_t opcode) {
    return opcode >= McapOpcode::kSchema && opcode <= McapOpcode::kChunk;
  }

  /// Of all bytes before the end of the data, the magic among them; 0: there is none.
  void require_checksum(std::uint32_t checksum, std::uint64_t end) {
    constexpr std::uint64_t kAtOnce = std::uint64_t{1} << 20;
    if (checksum == 0) return;
    uLong own = 0;
    for (std::uint64_t at = 0; at < end; at += kAtOnce) {
      const Bytes part = file_.view(at, std::min(kAtOnce, end - at), "the data");
      own = crc32_z(own, part.data(), part.size());
    }
    if (own != checksum) file_.fail(end, "data with a checksum that is not their own: corrupted");
  }

  void record(std::uint8_t opcode, ByteCursor body, bool outside) {
    if (opcode == McapOpcode::kMessage) return message(body);
    if (opcode == McapOpcode::kSchema) return schema(body);
    if (opcode == McapOpcode::kChannel) return channel(body);
    if (opcode != McapOpcode::kChunk) return;
    if (!outside) body.fail("a chunk within a chunk: corrupted");
    chunk(body);
  }

  void schema(ByteCursor body) {
    const auto id = body.take<std::uint16_t>();
    types_[id] = type_of_ros_1(std::string(text(body)));
  }

  void channel(ByteCursor body) {
    const auto id = body.take<std::uint16_t>();
    const auto schema = body.take<std::uint16_t>();
    RosTopic topic;
    topic.name = text(body);
    const std::string_view encoding = text(body);
    topic.encoding = encoding == "cdr"    ? RosTopic::Encoding::cdr
                     : encoding == "ros1" ? RosTopic::Encoding::ros1
                                          : RosTopic::Encoding::other;
    if (const auto type = types_.find(schema); type != types_.end()) topic.type = type->second;
    const auto [place, is_new] = topics_.try_emplace(id, topics_.size());
    if (is_new) visitor_.topic(place->second, topic);
  }

  void message(ByteCursor body) {
    const auto id = body.take<std::uint16_t>();
    body.skip(4);  // a number in sequence
    const auto log_time = body.take<std::uint64_t>();
    body.skip(8);  // when it was published
    const auto topic = topics_.find(id);
    if (topic == topics_.end()) body.fail(fmt::format("a message of channel {} that nobody announced", id));
    visitor_.message(topic->second, 1e-9 * static_cast<double>(log_time), body);
  }

  void chunk(ByteCursor body) {
    const std::uint64_t begin = body.position();
    body.skip(16);  // times of its first and last message
    const auto size = body.take<std::uint64_t>();
    const auto checksum = body.take<std::uint32_t>();
    const std::string_view name = text(body);
    const Compression compression = name.empty()    ? Compression::none
                                    : name == "lz4" ? Compression::lz4
                                                    : Compression::zstd;
    if (compression == Compression::zstd && name != "zstd") {
      body.fail(fmt::format("a chunk packed with '{}'; read are lz4 and zstd", name));
    }
    const auto packed_size = body.take<std::uint64_t>();
    decompress(compression, body.part(packed_size), size, unpacked_);
    if (checksum != 0 && crc32_z(0, unpacked_.data(), unpacked_.size()) != checksum) {
      body.fail_at(begin, "a chunk with a checksum that is not its own: corrupted");
    }
    const ByteOrigin origin{file_.path(), fmt::format("the chunk at byte {}", begin)};
    ByteCursor records(unpacked_, origin, 0);
    while (!records.done()) {
      const auto opcode = records.take<std::uint8_t>();
      const auto length = records.take<std::uint64_t>();
      record(opcode, records.part(length), false);
    }
  }

  BinaryFile file_;
  const RosVisitor& visitor_;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, std::size_t> topics_;  ///< by channel
  std::vector<std::uint8_t> unpacked_;
};

}  // namespace

bool begins_as_mcap(std::string_view beginning) { return beginning.starts_with(kMcapMagic); }

void scan_mcap(const std::filesystem::path& file, const RosVisitor& visitor) {
  McapReader(file, visitor).read();
}

}  // namespace credence::internal
