#include "datasets/replay/mat_structure.h"

#include <fmt/format.h>

#include <array>
#include <fstream>

#include "datasets/data_error.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kHeaderBytes = 128;
constexpr std::uint64_t kMaxNameBytes = 1024;
constexpr std::uint64_t kMaxDims = 32;

// Data types of tags.
constexpr std::uint32_t kInt8 = 1, kInt32 = 5, kUint32 = 6, kMatrix = 14, kCompressed = 15, kUtf8 = 16;
// Array classes of array flags: 4 is text, 6 to 15 are double, single and the integers.
constexpr std::uint32_t kTextClass = 4, kFirstNumericClass = 6, kLastNumericClass = 15;
constexpr std::uint32_t kComplexFlag = 0x0800;

/// Bytes of one number of a tag's data type; 0 for a type that holds no numbers.
std::uint64_t bytes_per_number(std::uint32_t type) {
  switch (type) {
    case 1:
    case 2:
    case 16:
      return 1;
    case 3:
    case 4:
    case 17:
      return 2;
    case 5:
    case 6:
    case 7:
    case 18:
      return 4;
    case 9:
    case 12:
    case 13:
      return 8;
    default:
      return 0;
  }
}

struct Tag {
  std::uint32_t type = 0;
  std::uint64_t bytes = 0;
  std::uint64_t data = 0;  ///< where the data begin
  std::uint64_t next = 0;  ///< where the next tag begins, after the padding to 8 bytes
};

class Scanner {
 public:
  explicit Scanner(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
    std::error_code error;
    if (!std::filesystem::exists(file, error)) fail("there is no such file");
    if (!std::filesystem::is_regular_file(file, error)) fail("is not a regular file");
    size_ = std::filesystem::file_size(file, error);
    if (error || !in_) fail("cannot be read");
  }

  std::vector<MatArray> scan() {
    read_header();
    std::vector<MatArray> arrays;
    for (std::uint64_t at = kHeaderBytes; at < size_;) {
      const Tag tag = top_level_tag(at);
      arrays.push_back(read_array(tag));
      at = tag.data + tag.bytes;
    }
    if (arrays.empty()) fail("holds no variables");
    return arrays;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& place = "") const {
    throw DataError(file_, place, problem);
  }

  void read_bytes(std::uint64_t at, char* to, std::uint64_t count) {
    if (at > size_ || count > size_ - at) fail(fmt::format("truncated: ends at byte {}", size_));
    in_.seekg(static_cast<std::streamoff>(at));
    in_.read(to, static_cast<std::streamsize>(count));
    if (!in_) fail(fmt::format("cannot be read at byte {}", at));
  }

  std::uint32_t read_word(std::uint64_t at) {
    std::array<char, 4> raw{};
    read_bytes(at, raw.data(), raw.size());
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const std::size_t significance = big_endian_ ? 3 - i : i;
      word |= static_cast<std::uint32_t>(static_cast<unsigned char>(raw[i])) << (8 * significance);
    }
    return word;
  }

  void read_header() {
    if (size_ < kHeaderBytes) fail(fmt::format("not a MAT-file of version 5: only {} bytes", size_));
    std::array<char, 4> end{};
    read_bytes(kHeaderBytes - 4, end.data(), end.size());
    const bool little = end[2] == 'I' && end[3] == 'M';
    big_endian_ = end[2] == 'M' && end[3] == 'I';
    if (!little && !big_endian_) fail("not a MAT-file of version 5: no byte-order mark at byte 126");
    const auto version = static_cast<unsigned char>(big_endian_ ? end[0] : end[1]);
    if (version == 2) fail("a MAT-file of version 7.3; save it uncompressed (in MATLAB: save -v6)");
    if (version != 1) fail("not a MAT-file of version 5: wrong version at byte 124");
  }

  Tag top_level_tag(std::uint64_t at) {
    Tag tag{read_word(at), read_word(at + 4), at + 8, 0};
    if (tag.type == kCompressed) fail("holds compressed variables; save it uncompressed (save -v6)");
    if (tag.type != kMatrix) fail(fmt::format("corrupted: no variable begins at byte {}", at));
    if (tag.bytes > size_ - tag.data)
      fail(fmt::format("truncated: a variable of {} bytes begins at byte {} of {}", tag.bytes, at, size_));
    return tag;
  }

  /// A tag within an array that ends at `end`, in its long form or its short one (data within the tag).
  Tag inner_tag(std::uint64_t at, std::uint64_t end) {
    if (at > end || end - at < 8) fail(fmt::format("corrupted: a variable ends too early at byte {}", end));
    const std::uint32_t first = read_word(at);
    Tag tag;
    if (first >> 16 != 0) {
      tag = {first & 0xffff, first >> 16, at + 4, at + 8};
      if (tag.bytes > 4) fail(fmt::format("corrupted: short element of {} bytes at byte {}", tag.bytes, at));
    } else {
      tag = {first, read_word(at + 4), at + 8, 0};
      if (tag.bytes > end - tag.data) fail(fmt::format("corrupted: element too long at byte {}", at));
      tag.next = tag.data + (tag.bytes + 7) / 8 * 8;
    }
    return tag;
  }

  MatArray read_array(const Tag& matrix) {
    const std::uint64_t end = matrix.data + matrix.bytes;
    const Tag flags = inner_tag(matrix.data, end);
    if (flags.type != kUint32 || flags.bytes != 8)
      fail(fmt::format("corrupted: no array flags at byte {}", matrix.data));
    const std::uint32_t word = read_word(flags.data);

    MatArray array;
    const Tag dims = inner_tag(flags.next, end);
    array.dims = read_dims(dims);
    const Tag name = inner_tag(dims.next, end);
    array.name = read_name(name);
    const std::uint32_t array_class = word & 0xff;
    array.numeric = array_class >= kFirstNumericClass && array_class <= kLastNumericClass;
    array.complex = (word & kComplexFlag) != 0;
    if (!array.numeric && array_class != kTextClass)
      fail("neither numbers nor text; only plain arrays are read", variable(array.name));

    const Tag real = inner_tag(name.next, end);
    check_data(array, real);
    if (array.complex) check_data(array, inner_tag(real.next, end));
    return array;
  }

  std::vector<std::int32_t> read_dims(const Tag& tag) {
    if (tag.type != kInt32 || tag.bytes % 4 != 0 || tag.bytes < 8 || tag.bytes > 4 * kMaxDims)
      fail(fmt::format("corrupted: no dimensions at byte {}", tag.data));
    std::vector<std::int32_t> dims;
    for (std::uint64_t at = tag.data; at < tag.data + tag.bytes; at += 4) {
      const auto dim = static_cast<std::int32_t>(read_word(at));
      if (dim < 0) fail(fmt::format("corrupted: negative dimension at byte {}", at));
      dims.push_back(dim);
    }
    return dims;
  }

  std::string read_name(const Tag& tag) {
    if ((tag.type != kInt8 && tag.type != kUtf8) || tag.bytes > kMaxNameBytes)
      fail(fmt::format("corrupted: no variable name at byte {}", tag.data));
    std::string name(tag.bytes, '\0');
    read_bytes(tag.data, name.data(), tag.bytes);
    for (const char letter : name)
      if (letter < ' ' || letter > '~') fail(fmt::format("corrupted: variable name at byte {}", tag.data));
    return name;
  }

  void check_data(const MatArray& array, const Tag& tag) const {
    const std::uint64_t size = bytes_per_number(tag.type);
    if (size == 0) fail(fmt::format("corrupted: data of unknown type {}", tag.type), variable(array.name));
    std::uint64_t bytes = std::ranges::count(array.dims, 0) > 0 ? 0 : size;
    for (const std::int32_t dim : array.dims) {
      bytes *= static_cast<std::uint64_t>(dim);  // at most 2^31 · 2^32: the test below ends it in time
      if (bytes > size_) break;
    }
    if (bytes != tag.bytes)
      fail(fmt::format("corrupted: {} bytes of data do not fit its dimensions", tag.bytes),
           variable(array.name));
  }

  static std::string variable(const std::string& name) { return "variable '" + name + "'"; }

  std::filesystem::path file_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  bool big_endian_ = false;
};

}  // namespace

std::vector<MatArray> scan_mat_file(const std::filesystem::path& file) { return Scanner(file).scan(); }

}  // namespace credence::internal
