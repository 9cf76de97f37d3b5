#include "datasets/logs/ros/ros1_bag.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <vector>

#include "core/stop_point.h"
#include "datasets/logs/bytes/binary_file.h"
#include "datasets/logs/bytes/decompress.h"

namespace credence::internal {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
/// What a record is.
struct Operation {
  enum : std::uint8_t { kMessage = 0x02, kBagHeader = 0x03, kChunk = 0x05, kConnection = 0x07 };
};

/// The fields "name=value" of a header, each with its length before it.
class RecordHeader {
 public:
  explicit RecordHeader(ByteCursor fields) : begin_(fields) {
    while (!fields.done()) {
      ByteCursor field = fields.part(fields.take<std::uint32_t>());
      const ByteCursor start = field;
      const std::string_view text = field.take_text(field.left());
      const std::size_t equals = text.find('=');
      if (equals == std::string_view::npos) start.fail("a header field without '=': corrupted");
      ByteCursor value = start;
      value.skip(equals + 1);
      values_.insert_or_assign(text.substr(0, equals), value);
    }
  }

  template <class T>
  T number(std::string_view name) const {
    return value(name).template take<T>();
  }
  std::string_view text(std::string_view name) const {
    ByteCursor field = value(name);
    return field.take_text(field.left());
  }
  bool has(std::string_view name) const { return values_.contains(name); }

 private:
  ByteCursor value(std::string_view name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) begin_.fail(fmt::format("a header without '{}': corrupted", name));
    return found->second;
  }

  ByteCursor begin_;
  std::map<std::string_view, ByteCursor> values_;
};

class Ros1BagReader {
 public:
  Ros1BagReader(const std::filesystem::path& file, const RosVisitor& visitor)
      : file_(file), visitor_(visitor) {}

  void read() {
    ByteCursor magic = file_.cursor(0, kBagMagic.size(), "the first line of a bag");
    if (magic.take_text(kBagMagic.size()) != kBagMagic) file_.fail(0, "is no bag of version 2.0");
    for (std::uint64_t at = kBagMagic.size(); at < file_.size();) {
      stop_point();
      const std::uint64_t begin = at;
      const std::uint64_t header_size = length(at);
      const std::uint64_t header_at = at + 4;
      const std::uint64_t data_size = length(header_at + header_size);
      const std::uint64_t data_at = header_at + header_size + 4;
      if (data_size > file_.size() - data_at) {
        file_.fail(at, fmt::format("a record of {} bytes begins here and the file ends at byte {}: cut off, "
                                   "or corrupted",
                                   header_size + data_size + 8, file_.size()));
      }
      outer_record(at, header_size, data_size);
      at = data_at + data_size;
      visitor_.advance(static_cast<std::int64_t>(at - begin));
    }
  }

 private:
  std::uint64_t length(std::uint64_t at) {
    return file_.cursor(at, 4, "the length of a record").take<std::uint32_t>();
  }

  void outer_record(std::uint64_t at, std::uint64_t header_size, std::uint64_t data_size) {
    const std::uint64_t data_at = at + 8 + header_size;
    const RecordHeader header(file_.cursor(at + 4, header_size, "the header of a record"));
    const auto operation = header.number<std::uint8_t>("op");
    if (operation == Operation::kBagHeader && header.has("encryptor") && !header.text("encryptor").empty()) {
      file_.fail(at, "an encrypted bag: it is not read");
    }
    if (operation != Operation::kChunk && operation != Operation::kConnection &&
        operation != Operation::kMessage)
      return;
    // The view of the header ends where that of the whole record begins.
    ByteCursor whole = file_.cursor(at + 4, header_size + 4 + data_size, "a record");
    const RecordHeader again(whole.part(header_size));
    whole.skip(4);
    if (operation == Operation::kChunk) return chunk(again, whole, data_at);
    record(operation, again, whole);
  }

  void chunk(const RecordHeader& header, ByteCursor packed, std::uint64_t at) {
    const std::string_view name = header.text("compression");
    std::optional<Compression> compression;
    if (name == "none") compression = Compression::none;
    if (name == "bz2") compression = Compression::bz2;
    if (name == "lz4") compression = Compression::lz4;
    if (!compression) packed.fail(fmt::format("a chunk packed with '{}'; read are none, bz2 and lz4", name));
    decompress(*compression, packed, header.number<std::uint32_t>("size"), unpacked_);
    const ByteOrigin origin{file_.path(), fmt::format("the chunk at byte {}", at)};
    ByteCursor records(unpacked_, origin, 0);
    while (!records.done()) {
      const RecordHeader inner(records.part(records.take<std::uint32_t>()));
      const ByteCursor data = records.part(records.take<std::uint32_t>());
      record(inner.number<std::uint8_t>("op"), inner, data);
    }
  }

  void record(std::uint8_t operation, const RecordHeader& header, const ByteCursor& data) {
    if (operation == Operation::kConnection) {
      const auto [place, is_new] = topics_.try_emplace(header.number<std::uint32_t>("conn"), topics_.size());
      if (!is_new) return;
      const RecordHeader connection(data);
      visitor_.topic(place->second, {.name = std::string(header.text("topic")),
                                     .type = std::string(connection.text("type")),
                                     .encoding = RosTopic::Encoding::ros1});
    } else if (operation == Operation::kMessage) {
      const auto id = header.number<std::uint32_t>("conn");
      const auto time = header.number<std::uint64_t>("time");
      const auto topic = topics_.find(id);
      if (topic == topics_.end()) {
        data.fail(fmt::format("a message of connection {} that nobody announced", id));
      }
      // Seconds in the lower half, nanoseconds in the upper.
      const double seconds =
          static_cast<double>(time & 0xffffffffU) + 1e-9 * static_cast<double>(time >> 32U);
      visitor_.message(topic->second, seconds, data);
    }
  }

  BinaryFile file_;
  const RosVisitor& visitor_;
  std::map<std::uint32_t, std::size_t> topics_;  ///< by connection
  std::vector<std::uint8_t> unpacked_;
};

}  // namespace

bool begins_as_ros1_bag(std::string_view beginning) { return beginning.starts_with(kBagMagic); }

void scan_ros1_bag(const std::filesystem::path& file, const RosVisitor& visitor) {
  Ros1BagReader(file, visitor).read();
}

}  // namespace credence::internal
