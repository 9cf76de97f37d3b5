#include "datasets/logs/arrays/mat_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "datasets/data_error.h"
#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/bytes/binary_file.h"
#include "datasets/logs/bytes/decompress.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kMatHeader = 128;
constexpr std::uint64_t kMostInMemory = std::uint64_t{2} << 30;

/// Types of data.
struct MatType {
  enum : std::uint32_t {
    kInt8 = 1,
    kUint8 = 2,
    kInt16 = 3,
    kUint16 = 4,
    kInt32 = 5,
    kUint32 = 6,
    kSingle = 7,
    kDouble = 9,
    kInt64 = 12,
    kUint64 = 13,
    kMatrix = 14,
    kCompressed = 15,
  };
};
/// Classes of arrays.
struct MatClass {
  enum : std::uint32_t { kStructure = 2, kFirstNumeric = 6, kLastNumeric = 15 };
};

/// Bytes of a number; 0 for what is none.
std::uint64_t number_size(std::uint32_t type) {
  switch (type) {
    case MatType::kInt8:
    case MatType::kUint8:
      return 1;
    case MatType::kInt16:
    case MatType::kUint16:
      return 2;
    case MatType::kInt32:
    case MatType::kUint32:
    case MatType::kSingle:
      return 4;
    case MatType::kDouble:
    case MatType::kInt64:
    case MatType::kUint64:
      return 8;
    default:
      return 0;
  }
}

double take_number(ByteCursor& from, std::uint32_t type) {
  switch (type) {
    case MatType::kInt8:
      return from.take<std::int8_t>();
    case MatType::kUint8:
      return from.take<std::uint8_t>();
    case MatType::kInt16:
      return from.take<std::int16_t>();
    case MatType::kUint16:
      return from.take<std::uint16_t>();
    case MatType::kInt32:
      return from.take<std::int32_t>();
    case MatType::kUint32:
      return from.take<std::uint32_t>();
    case MatType::kSingle:
      return static_cast<double>(from.take<float>());
    case MatType::kInt64:
      return static_cast<double>(from.take<std::int64_t>());
    case MatType::kUint64:
      return static_cast<double>(from.take<std::uint64_t>());
    default:
      return from.take<double>();
  }
}

/// A part of a variable: its type and its bytes.
struct Element {
  std::uint32_t type;
  ByteCursor data;
};

/// Takes the next element, in its long form or its short one (data within the tag), and its padding.
Element take_element(ByteCursor& from) {
  const auto first = from.take<std::uint32_t>();
  if (first >> 16U != 0) {
    const std::uint32_t size = first >> 16U;
    if (size > 4) from.fail(fmt::format("a short element of {} bytes: corrupted", size));
    ByteCursor whole = from.part(4);
    return {first & 0xffffU, whole.part(size)};
  }
  const auto size = from.take<std::uint32_t>();
  const ByteCursor data = from.part(size);
  from.skip(std::min<std::uint64_t>((8 - size % 8) % 8, from.left()));
  return {first, data};
}

class MatArrays final : public ArrayFile {
 public:
  explicit MatArrays(const std::filesystem::path& file) : file_(file) {
    const std::endian order = read_header();
    for (std::uint64_t at = kMatHeader; at < file_.size();) {
      ByteCursor tag = file_.cursor(at, 8, "a variable", order);
      const auto type = tag.take<std::uint32_t>(), size = tag.take<std::uint32_t>();
      if (type != MatType::kMatrix && type != MatType::kCompressed)
        file_.fail(at, "no variable begins here: corrupted");
      variable(type, file_.cursor(at + 8, size, "a variable", order), at, order);
      at += 8 + std::uint64_t{size};
    }
  }

  const std::filesystem::path& path() const override { return file_.path(); }
  const std::vector<ArrayShape>& arrays() const override { return arrays_; }

  void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) override {
    out.resize(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = numbers_[i][static_cast<std::size_t>(column_major_place(arrays_[i].dims, first + k))];
    }
  }

 private:
  std::endian read_header() {
    ByteCursor header = file_.cursor(0, kMatHeader, "the header of a MAT-file");
    header.skip(kMatHeader - 4);
    const std::string_view end = header.take_text(4);
    const bool little = end.ends_with("IM");
    if (!little && !end.ends_with("MI"))
      file_.fail(kMatHeader - 2, "is no MAT-file of version 5: no mark of its byte order");
    const char version = little ? end[1] : end[0];
    if (version == 2) {
      file_.fail(kMatHeader - 4, "is a MAT-file of version 7.3; save it with -v7 (MATLAB: save -v7 FILE)");
    }
    if (version != 1)
      file_.fail(kMatHeader - 4, "is a MAT-file of another version; read is version 5 (save -v7)");
    return little ? std::endian::little : std::endian::big;
  }

  void variable(std::uint32_t type, ByteCursor body, std::uint64_t at, std::endian order) {
    if (type == MatType::kMatrix) return matrix(body, "");
    std::vector<std::uint8_t> unpacked;
    decompress_zlib(body, unpacked);
    const ByteOrigin origin{path(), fmt::format("the variable at byte {}", at)};
    ByteCursor all(unpacked, origin, 0, order);
    const Element element = take_element(all);
    if (element.type == MatType::kMatrix) matrix(element.data, "");
  }

  /// An array, or the arrays of a structure. `field`: its name, where it is a field of one.
  void matrix(ByteCursor body, const std::string& field) {
    if (body.done()) return;  // an empty field
    ByteCursor flags = take_element(body).data;
    const std::uint32_t word = flags.take<std::uint32_t>();
    std::vector<std::uint64_t> dims;
    for (ByteCursor from = take_element(body).data; !from.done();) {
      const auto dim = from.take<std::int32_t>();
      if (dim < 0) body.fail(fmt::format("a dimension of {}: corrupted", dim));
      dims.push_back(static_cast<std::uint64_t>(dim));
    }
    ByteCursor letters = take_element(body).data;
    const std::string own(letters.take_text(letters.left()));
    const std::string& name = field.empty() ? own : field;
    const std::uint32_t kind = word & 0xffU;
    constexpr std::uint32_t kComplex = 0x0800;
    if (kind == MatClass::kStructure && field.empty()) return structure(body, dims);
    const bool numeric =
        kind >= MatClass::kFirstNumeric && kind <= MatClass::kLastNumeric && (word & kComplex) == 0;
    if (!numeric || !is_log_array(name)) {
      arrays_.push_back({.name = name, .type = "not read", .dims = {}});
      numbers_.emplace_back();
      return;
    }
    numbers(name, dims, take_element(body));
  }

  void structure(ByteCursor body, const std::vector<std::uint64_t>& dims) {
    if (std::ranges::any_of(dims, [](std::uint64_t dim) { return dim != 1; })) return;  // an array of them
    ByteCursor length = take_element(body).data;
    const auto name_size = length.take<std::uint32_t>();
    ByteCursor names = take_element(body).data;
    if (name_size == 0) body.fail("a structure with names of no length: corrupted");
    while (!names.done()) {
      const std::string_view padded = names.take_text(name_size);
      const Element value = take_element(body);
      if (value.type == MatType::kMatrix)
        matrix(value.data, std::string(padded.substr(0, padded.find('\0'))));
    }
  }

  void numbers(const std::string& name, const std::vector<std::uint64_t>& dims, Element element) {
    const std::uint64_t size = number_size(element.type);
    std::uint64_t count = 1;
    for (const std::uint64_t dim : dims) {
      // Beyond what is there, it need not be multiplied on.
      if (dim > 0 && count > element.data.left() / dim) {
        element.data.fail(
            fmt::format("{}: dimensions beyond its {} bytes: corrupted", name, element.data.left()));
      }
      count *= dim;
    }
    if (size == 0 || count * size != element.data.left()) {
      element.data.fail(fmt::format("{}: {} bytes of numbers of type {} do not fit its dimensions: corrupted",
                                    name, element.data.left(), element.type));
    }
    if ((in_memory_ += count * sizeof(double)) > kMostInMemory) {
      element.data.fail(fmt::format("{}: of the arrays of a MAT-file 2 GiB in all are read", name));
    }
    std::vector<double> values(static_cast<std::size_t>(count));
    for (double& value : values) value = take_number(element.data, element.type);
    arrays_.push_back({.name = name, .type = "numbers", .dims = dims});
    numbers_.push_back(std::move(values));
  }

  BinaryFile file_;
  std::vector<ArrayShape> arrays_;
  std::vector<std::vector<double>> numbers_;  ///< of each array, the first index running fastest
  std::uint64_t in_memory_ = 0;
};

}  // namespace

LogFormat mat_format() {
  return {.name = "mat",
          .title = "MATLAB arrays",
          .extensions = ".mat",
          .recognises =
              [](std::string_view beginning, const std::filesystem::path&) {
                return beginning.size() >= kMatHeader &&
                       (beginning.substr(kMatHeader - 2, 2) == "IM" ||
                        beginning.substr(kMatHeader - 2, 2) == "MI") &&
                       beginning.starts_with("MATLAB");
              },
          .list = [](const std::filesystem::path& file) { return list_arrays(MatArrays(file)); },
          .read =
              [](const std::filesystem::path& file, const LogReadOptions&, LogSink& sink) {
                MatArrays arrays(file);
                read_arrays(arrays, sink);
                sink.advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
              }};
}

}  // namespace credence::internal
