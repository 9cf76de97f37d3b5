#include "datasets/logs/autopilot/ulog.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr std::string_view kUlogMagic("\x55\x4c\x6f\x67\x01\x12\x35", 7);
constexpr std::uint64_t kUlogHeader = 16, kMessageHeader = 3;
// Formats may hold formats; deeper than this they hold themselves.
constexpr int kDeepest = 8;
constexpr std::uint64_t kLargestMessage = 65535;

/// A type that holds no other.
struct PlainType {
  std::string_view name;
  std::uint64_t size;             ///< bytes
  double (*number)(ByteCursor&);  ///< null: a letter
};
constexpr PlainType kPlainTypes[] = {
    {"int8_t", 1, take_double<std::int8_t>},     {"uint8_t", 1, take_double<std::uint8_t>},
    {"bool", 1, take_double<std::uint8_t>},      {"char", 1, nullptr},
    {"int16_t", 2, take_double<std::int16_t>},   {"uint16_t", 2, take_double<std::uint16_t>},
    {"int32_t", 4, take_double<std::int32_t>},   {"float", 4, take_double<float>},
    {"uint32_t", 4, take_double<std::uint32_t>}, {"int64_t", 8, take_double<std::int64_t>},
    {"uint64_t", 8, take_double<std::uint64_t>}, {"double", 8, take_double<double>}};

/// Null for the name of a format.
const PlainType* plain_type(std::string_view name) {
  const auto* const found = std::ranges::find(kPlainTypes, name, &PlainType::name);
  return found == std::end(kPlainTypes) ? nullptr : found;
}

/// The messages of a file, one after another.
class UlogReader {
 public:
  UlogReader(const std::filesystem::path& file, const UlogVisitor& visitor)
      : file_(file), visitor_(visitor) {}

  void read() {
    const Bytes header = file_.view(0, kUlogHeader, "the header of a ULog");
    if (!begins_as_ulog({reinterpret_cast<const char*>(header.data()), header.size()})) {
      file_.fail(0, "is no ULog: it does not begin with 55 4c 6f 67 01 12 35");
    }
    std::uint64_t at = kUlogHeader, told = 0;
    while (at < file_.size()) {
      stop_point();
      // What was being written when the log was cut off to append to it is no message.
      if (appended_ && at != *appended_) {
        ByteCursor cut = file_.cursor(at, std::min(kMessageHeader, file_.size() - at), "a message header");
        if (at > *appended_ || cut.left() < kMessageHeader ||
            at + kMessageHeader + cut.take<std::uint16_t>() > *appended_) {
          at = *appended_;
        }
      }
      if (appended_ && at == *appended_) appended_ = next_appended();
      ByteCursor start = file_.cursor(at, kMessageHeader, "a message header");
      const auto size = start.take<std::uint16_t>();
      const auto type = static_cast<char>(start.take<std::uint8_t>());
      message(type, file_.cursor(at + kMessageHeader, size, "a message"));
      at += kMessageHeader + size;
      if (at - told >= 1'000'000 || at == file_.size()) {
        visitor_.advance(static_cast<std::int64_t>(at - told));
        told = at;
      }
    }
  }

 private:
  void message(char type, ByteCursor body) {
    switch (type) {
      case 'B': return flags(body);
      case 'F': return format(body);
      case 'A': return subscription(body);
      case 'D': return data(body);
      case 'P': return parameter(body);
      case 'O': return visitor_.dropout(1e-3 * body.take<std::uint16_t>());
      default: return;  // information, texts: nothing that is judged
    }
  }

  void flags(ByteCursor body) {
    constexpr std::uint8_t kAppended = 1;
    body.skip(8);  // what a reader may ignore
    for (int i = 0; i < 8; ++i) {
      const auto flag = body.take<std::uint8_t>();
      if ((i == 0 ? flag & ~kAppended : flag) != 0) {
        body.fail(fmt::format("a flag {:#x} that is not known: written by a later version of ULog", flag));
      }
    }
    for (int i = 0; i < 3; ++i) {
      const auto offset = body.take<std::uint64_t>();
      if (offset == 0) continue;
      if (offset > file_.size() || offset <= body.position() ||
          (!offsets_.empty() && offset <= offsets_.back())) {
        body.fail(fmt::format("data appended at byte {} of {}: corrupted", offset, file_.size()));
      }
      offsets_.push_back(offset);
    }
    appended_ = next_appended();
  }

  std::optional<std::uint64_t> next_appended() {
    if (next_offset_ == offsets_.size()) return std::nullopt;
    return offsets_[next_offset_++];
  }

  /// "float NAME" or "int32_t NAME" and the value.
  void parameter(ByteCursor body) {
    if (!visitor_.parameter) return;
    const auto size = body.take<std::uint8_t>();
    const std::string_view key = body.take_text(size);
    const std::string_view name = key.substr(std::min(key.find(' '), key.size()));
    if (name.empty()) return;
    if (key.starts_with("float "))
      visitor_.parameter(name.substr(1), static_cast<double>(body.take<float>()));
    if (key.starts_with("int32_t ")) visitor_.parameter(name.substr(1), body.take<std::int32_t>());
  }

  /// "name:type field;type[n] field;…"
  void format(ByteCursor body) {
    const std::uint64_t position = body.position();
    const std::string_view text = body.take_text(body.left());
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) body.fail_at(position, "a format without a name: corrupted");
    std::vector<UlogField> fields;
    for (std::string_view rest = text.substr(colon + 1); !rest.empty();) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      const std::string_view one = rest.substr(0, end);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (one.empty()) continue;
      const std::size_t space = one.find(' ');
      if (space == std::string_view::npos) body.fail_at(position, "a field without a type: corrupted");
      UlogField field{.name = std::string(one.substr(space + 1)), .type = std::string(one.substr(0, space))};
      if (const std::size_t bracket = field.type.find('['); bracket != std::string::npos) {
        const char* const first = field.type.data() + bracket + 1;
        const char* const last = field.type.data() + field.type.size();
        const auto [stop, error] = std::from_chars(first, last, field.count);
        if (error != std::errc() || stop == last || *stop != ']' || field.count > kLargestMessage) {
          body.fail_at(position, fmt::format("a field of type '{}': corrupted", field.type));
        }
        field.type.resize(bracket);
      }
      fields.push_back(std::move(field));
    }
    formats_[std::string(text.substr(0, colon))] = std::move(fields);
  }

  /// Bytes of a type that another field may have; `position` of who asks.
  std::uint64_t size_of(const ByteCursor& body, const std::string& type, int depth) {
    if (const PlainType* const plain = plain_type(type); plain != nullptr) return plain->size;
    if (const auto known = sizes_.find(type); known != sizes_.end()) return known->second;
    const auto found = formats_.find(type);
    if (found == formats_.end() || depth > kDeepest) {
      body.fail(fmt::format("a format '{}' that nobody described: corrupted", type));
    }
    std::uint64_t total = 0;
    for (const UlogField& field : found->second) {
      total += field.count * size_of(body, field.type, depth + 1);
      if (total > kLargestMessage) body.fail(fmt::format("a format '{}' beyond 64 KB: corrupted", type));
    }
    sizes_.emplace(type, total);
    return total;
  }

  void subscription(ByteCursor body) {
    UlogTopic topic;
    topic.instance = body.take<std::uint8_t>();
    const auto id = body.take<std::uint16_t>();
    topic.name = body.take_text(body.left());
    size_of(body, topic.name, 0);
    const auto format = formats_.find(topic.name);
    if (format == formats_.end()) body.fail(fmt::format("topic '{}' is no message: corrupted", topic.name));
    topic.fields = format->second;
    std::uint64_t offset = 0;
    for (UlogField& field : topic.fields) {
      field.size = size_of(body, field.type, 0);
      field.offset = offset;
      offset += field.count * field.size;
    }
    topics_[id] = count_;
    visitor_.topic(count_++, topic);
  }

  void data(ByteCursor body) {
    const auto id = body.take<std::uint16_t>();
    const auto topic = topics_.find(id);
    if (topic == topics_.end()) body.fail(fmt::format("data of topic {} that nobody announced", id));
    visitor_.message(topic->second, body.part(body.left()));
  }

  BinaryFile file_;
  const UlogVisitor& visitor_;
  std::map<std::string, std::vector<UlogField>> formats_;
  std::map<std::string, std::uint64_t> sizes_;   ///< of formats, as far as anybody has asked
  std::map<std::uint16_t, std::size_t> topics_;  ///< by the number that messages carry
  std::size_t count_ = 0;
  std::vector<std::uint64_t> offsets_;  ///< where data were appended to a log that was closed
  std::size_t next_offset_ = 0;
  std::optional<std::uint64_t> appended_;  ///< the next of them
};

}  // namespace

const UlogField* UlogTopic::field(std::string_view wanted) const {
  const auto found = std::ranges::find(fields, wanted, &UlogField::name);
  return found == fields.end() ? nullptr : &*found;
}

double ulog_number(ByteCursor message, const UlogField& field, std::uint64_t entry) {
  message.skip(field.offset + entry * field.size);
  const PlainType* const type = plain_type(field.type);
  if (type == nullptr || type->number == nullptr) {
    message.fail(
        fmt::format("field '{}' is of type '{}' where a number is expected", field.name, field.type));
  }
  return type->number(message);
}

bool begins_as_ulog(std::string_view beginning) { return beginning.starts_with(kUlogMagic); }

double ulog_time_s(const UlogTopic& topic, const ByteCursor& message) {
  const UlogField* const sampled = topic.field("timestamp_sample");
  const UlogField* const sent = topic.field("timestamp");
  if (sampled == nullptr && sent == nullptr)
    message.fail(fmt::format("topic {} without a timestamp", topic.name));
  const double sampled_us = sampled == nullptr ? 0.0 : ulog_number(message, *sampled);
  return 1e-6 * (sampled_us > 0.0 || sent == nullptr ? sampled_us : ulog_number(message, *sent));
}

void read_ulog(const std::filesystem::path& file, const UlogVisitor& visitor) {
  UlogReader(file, visitor).read();
}

}  // namespace credence::internal
