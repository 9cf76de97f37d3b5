#include "datasets/logs/autopilot/dataflash.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr std::uint8_t kFirstMark = 0xa3, kSecondMark = 0x95, kFormatType = 0x80;
constexpr std::uint64_t kMarks = 3, kFormatBody = 86;

/// IEEE 754.
double half_precision(ByteCursor& from) {
  const auto bits = from.take<std::uint16_t>();
  const int exponent = (bits >> 10U) & 0x1f, mantissa = bits & 0x3ff;
  const double sign = (bits & 0x8000U) != 0 ? -1.0 : 1.0;
  if (exponent == 0) return sign * std::ldexp(mantissa, -24);
  if (exponent == 31) return mantissa == 0 ? sign * HUGE_VAL : std::nan("");
  return sign * std::ldexp(1024 + mantissa, exponent - 25);
}

/// What a letter of FMT stands for.
struct FieldType {
  char letter;
  std::uint64_t size;             ///< bytes
  double (*number)(ByteCursor&);  ///< null: no number
  double unit = 1.0;
};
constexpr FieldType kFieldTypes[] = {{'a', 64, nullptr},
                                     {'b', 1, take_double<std::int8_t>},
                                     {'B', 1, take_double<std::uint8_t>},
                                     {'c', 2, take_double<std::int16_t>, 0.01},
                                     {'C', 2, take_double<std::uint16_t>, 0.01},
                                     {'d', 8, take_double<double>},
                                     {'e', 4, take_double<std::int32_t>, 0.01},
                                     {'E', 4, take_double<std::uint32_t>, 0.01},
                                     {'f', 4, take_double<float>},
                                     {'g', 2, half_precision},
                                     {'h', 2, take_double<std::int16_t>},
                                     {'H', 2, take_double<std::uint16_t>},
                                     {'i', 4, take_double<std::int32_t>},
                                     {'I', 4, take_double<std::uint32_t>},
                                     {'L', 4, take_double<std::int32_t>, 1e-7},
                                     {'M', 1, take_double<std::uint8_t>},
                                     {'n', 4, nullptr},
                                     {'N', 16, nullptr},
                                     {'q', 8, take_double<std::int64_t>},
                                     {'Q', 8, take_double<std::uint64_t>},
                                     {'Z', 64, nullptr}};

/// Null for a letter that is not known.
const FieldType* field_type(char letter) {
  const auto* const found = std::ranges::find(kFieldTypes, letter, &FieldType::letter);
  return found == std::end(kFieldTypes) ? nullptr : found;
}

/// Letters up to the first zero.
std::string_view zero_ended(std::string_view text) { return text.substr(0, text.find('\0')); }

class DataflashReader {
 public:
  DataflashReader(const std::filesystem::path& file, const DataflashVisitor& visitor)
      : file_(file), visitor_(visitor) {
    topics_[kFormatType] = {.name = "FMT", .size = kFormatBody, .fields = {}};
    known_[kFormatType] = true;
  }

  void read() {
    std::uint64_t told = 0;
    if (file_.size() == 0) file_.fail(0, "is empty");
    for (std::uint64_t at = 0; at < file_.size();) {
      stop_point();
      ByteCursor head = file_.cursor(at, kMarks, "a message header");
      if (head.take<std::uint8_t>() != kFirstMark || head.take<std::uint8_t>() != kSecondMark) {
        file_.fail(at, "no message begins here (a3 95): corrupted");
      }
      const auto type = head.take<std::uint8_t>();
      if (!known_[type]) file_.fail(at, fmt::format("a message of type {} that no FMT describes", type));
      const std::uint64_t size = topics_[type].size;
      const ByteCursor body = file_.cursor(at + kMarks, size, topics_[type].name);
      if (type == kFormatType) describe(body);
      visitor_.message(type, body);
      at += kMarks + size;
      if (at - told >= 1'000'000 || at == file_.size()) {
        visitor_.advance(static_cast<std::int64_t>(at - told));
        told = at;
      }
    }
  }

 private:
  void describe(ByteCursor body) {
    const std::uint64_t position = body.position();
    const auto type = body.take<std::uint8_t>();
    const std::uint64_t length = body.take<std::uint8_t>();
    DataflashTopic topic;
    topic.name = zero_ended(body.take_text(4));
    const std::string letters(zero_ended(body.take_text(16)));
    const std::string_view names = zero_ended(body.take_text(64));
    if (type == kFormatType) return;  // of itself, known from the start
    std::uint64_t offset = 0;
    std::string_view rest = names;
    for (const char letter : letters) {
      const FieldType* const type_of_field = field_type(letter);
      if (type_of_field == nullptr) {
        body.fail_at(position, fmt::format("{}: a field of type {:#04x} that is not known", topic.name,
                                           static_cast<unsigned char>(letter)));
      }
      const std::size_t comma = rest.find(',');
      if (!rest.empty()) topic.fields.push_back({std::string(rest.substr(0, comma)), letter, offset});
      rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
      offset += type_of_field->size;
    }
    if (length != kMarks + offset) {
      body.fail_at(position, fmt::format("{}: fields of {} bytes in messages of {}: corrupted", topic.name,
                                         kMarks + offset, length));
    }
    topic.size = offset;
    topics_[type] = topic;
    known_[type] = true;
    visitor_.topic(type, topic);
  }

  BinaryFile file_;
  const DataflashVisitor& visitor_;
  std::array<DataflashTopic, 256> topics_;
  std::array<bool, 256> known_{};
};

}  // namespace

const DataflashTopic::Field* DataflashTopic::field(std::string_view wanted) const {
  const auto found = std::ranges::find(fields, wanted, &Field::name);
  return found == fields.end() ? nullptr : &*found;
}

double dataflash_number(ByteCursor body, const DataflashTopic::Field& field) {
  body.skip(field.offset);
  const FieldType* const type = field_type(field.type);
  if (type == nullptr || type->number == nullptr) {
    body.fail(fmt::format("field {} is of type '{}' where a number is expected", field.name, field.type));
  }
  return type->unit * type->number(body);
}

std::string dataflash_text(ByteCursor body, const DataflashTopic::Field& field) {
  if (field.type != 'n' && field.type != 'N' && field.type != 'Z') return "";
  body.skip(field.offset);
  return std::string(zero_ended(body.take_text(field_type(field.type)->size)));
}

bool begins_as_dataflash(std::string_view beginning) {
  return beginning.starts_with(std::string_view("\xa3\x95\x80", kMarks));
}

void read_dataflash(const std::filesystem::path& file, const DataflashVisitor& visitor) {
  DataflashReader(file, visitor).read();
}

}  // namespace credence::internal
