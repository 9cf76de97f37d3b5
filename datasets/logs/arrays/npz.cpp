#include "datasets/logs/arrays/npz.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <set>

#include "datasets/data_error.h"
#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/bytes/binary_file.h"
#include "datasets/logs/bytes/decompress.h"

namespace credence::internal {
namespace {

constexpr std::string_view kText = "text";
constexpr std::uint64_t kLargestInMemory = std::uint64_t{1} << 30;

/// A member of the zip file that holds one array.
struct NpyMember {
  std::string name;
  std::uint64_t begin = 0, packed_size = 0, size = 0;  ///< bytes, in the zip file and unpacked
  std::uint32_t checksum = 0;
  bool packed = false;
  std::uint64_t header = 0;  ///< bytes before the numbers
  std::size_t number_size = 8;
  bool integers = false;
  std::endian order = std::endian::little;
  bool fortran_order = false;
  std::vector<std::uint8_t> held{};  ///< unpacked, if it is held in memory
};

/// What stands behind "'key':" in the header of a .npy file.
std::string_view header_value(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(fmt::format("'{}':", key));
  if (at == std::string_view::npos) return {};
  header.remove_prefix(at + key.size() + 3);
  header.remove_prefix(std::min(header.find_first_not_of(' '), header.size()));
  return header;
}

/// What numpy calls the array of a member.
std::string array_name(const NpyMember& member) {
  return member.name.ends_with(".npy") ? member.name.substr(0, member.name.size() - 4) : member.name;
}

class NpzFile final : public ArrayFile {
 public:
  explicit NpzFile(const std::filesystem::path& file) : file_(file) {
    read_directory();
    for (NpyMember& member : members_) open(member);
  }

  const std::filesystem::path& path() const override { return file_.path(); }
  const std::vector<ArrayShape>& arrays() const override { return arrays_; }

  void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) override {
    NpyMember& member = members_[i];
    if (member.packed && member.held.empty()) unpack(member);
    if (member.fortran_order && member.held.empty()) hold(member);
    out.resize(static_cast<std::size_t>(count));
    const std::uint64_t at = member.header + first * member.number_size, bytes = count * member.number_size;
    if (member.held.empty()) {
      return convert(member, file_.cursor(member.begin + at, bytes, "an array", member.order), out);
    }
    if (!member.fortran_order) {
      const ByteOrigin origin{path(), member.name};
      const Bytes part =
          Bytes(member.held).subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(bytes));
      return convert(member, ByteCursor(part, origin, at, member.order), out);
    }
    read_transposed(member, arrays_[i].dims, first, out);
  }

 private:
  static double take_number(const NpyMember& member, ByteCursor& from) {
    if (member.number_size == 1) return from.take<std::uint8_t>();
    if (member.integers) {
      return member.number_size == 4 ? from.take<std::int32_t>()
                                     : static_cast<double>(from.take<std::int64_t>());
    }
    return member.number_size == 4 ? from.take<float>() : from.take<double>();
  }

  static void convert(const NpyMember& member, ByteCursor from, std::vector<double>& out) {
    if (!member.integers && member.number_size == sizeof(double) && member.order == std::endian::native) {
      const Bytes numbers = from.take_bytes(out.size() * sizeof(double));
      std::ranges::copy(numbers, reinterpret_cast<std::uint8_t*>(out.data()));
      return;
    }
    for (double& number : out) number = take_number(member, from);
  }

  /// The first index of what is stored runs fastest.
  void read_transposed(const NpyMember& member, const std::vector<std::uint64_t>& dims, std::uint64_t first,
                       std::vector<double>& out) const {
    const ByteOrigin origin{path(), member.name};
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::uint64_t place = column_major_place(dims, first + k);
      ByteCursor number(member.held, origin, 0, member.order);
      number.skip(member.header + place * member.number_size);
      out[k] = take_number(member, number);
    }
  }

  void read_directory() {
    constexpr std::uint64_t kEnd = 22, kLongestComment = 65535;
    const std::uint64_t tail = std::min(file_.size(), kEnd + kLongestComment);
    const Bytes last = file_.view(file_.size() - tail, tail, "the end of a zip file");
    constexpr std::string_view kSignature = "PK\x05\x06";
    const std::string_view text(reinterpret_cast<const char*>(last.data()), last.size());
    const std::size_t found = text.rfind(kSignature);
    if (found == std::string_view::npos || last.size() - found < kEnd) {
      file_.fail(file_.size(), "ends without the directory of a zip file: cut off, or no .npz");
    }
    const std::uint64_t end_at = file_.size() - tail + found;
    ByteCursor end = file_.cursor(end_at + 8, kEnd - 8, "the end of a zip file");
    std::uint64_t count = end.take<std::uint16_t>();
    end.skip(2);
    std::uint64_t size = end.take<std::uint32_t>(), begin = end.take<std::uint32_t>();
    if (begin == std::numeric_limits<std::uint32_t>::max() || count == 0xffff)
      read_zip64(end_at, count, size, begin);
    ByteCursor directory = file_.cursor(begin, size, "the directory of a zip file");
    // Entries are read before any other part of the file is.
    std::vector<NpyMember> members;
    for (std::uint64_t i = 0; i < count; ++i) members.push_back(directory_entry(directory));
    members_ = std::move(members);
    require_distinct_names(begin);
  }

  /// Programs differ in which of two they read.
  void require_distinct_names(std::uint64_t directory) const {
    std::set<std::string> names;
    for (const NpyMember& member : members_) {
      if (names.insert(array_name(member)).second) continue;
      file_.fail(directory, fmt::format("{} is there twice: corrupted", member.name));
    }
  }

  void read_zip64(std::uint64_t end_at, std::uint64_t& count, std::uint64_t& size, std::uint64_t& begin) {
    constexpr std::uint64_t kLocator = 20, kRecord = 56;
    if (end_at < kLocator) file_.fail(end_at, "a zip file of 64 bit without its locator: corrupted");
    ByteCursor locator = file_.cursor(end_at - kLocator, kLocator, "a locator");
    if (locator.take<std::uint32_t>() != 0x07064b50) locator.fail("no locator of a zip file: corrupted");
    locator.skip(4);
    const auto at = locator.take<std::uint64_t>();
    ByteCursor record = file_.cursor(at, kRecord, "the end of a zip file");
    if (record.take<std::uint32_t>() != 0x06064b50) record.fail("no end of a zip file: corrupted");
    record.skip(20 + 8);
    count = record.take<std::uint64_t>();
    size = record.take<std::uint64_t>();
    begin = record.take<std::uint64_t>();
  }

  NpyMember directory_entry(ByteCursor& directory) const {
    constexpr std::uint32_t kIn64Bits = std::numeric_limits<std::uint32_t>::max();
    if (directory.take<std::uint32_t>() != 0x02014b50)
      directory.fail("no entry of a zip directory: corrupted");
    directory.skip(4);
    const auto flags = directory.take<std::uint16_t>();
    const auto method = directory.take<std::uint16_t>();
    directory.skip(4);
    NpyMember member;
    member.checksum = directory.take<std::uint32_t>();
    member.packed_size = directory.take<std::uint32_t>();
    member.size = directory.take<std::uint32_t>();
    const auto name_size = directory.take<std::uint16_t>();
    const auto extra_size = directory.take<std::uint16_t>();
    const auto comment_size = directory.take<std::uint16_t>();
    directory.skip(8);
    member.begin = directory.take<std::uint32_t>();
    member.name = directory.take_text(name_size);
    ByteCursor extra = directory.part(extra_size);
    directory.skip(comment_size);
    while (extra.left() >= 4) {
      const auto id = extra.take<std::uint16_t>();
      ByteCursor field = extra.part(extra.take<std::uint16_t>());
      if (id != 1) continue;
      for (std::uint64_t* value : {&member.size, &member.packed_size, &member.begin}) {
        if (*value == kIn64Bits) *value = field.take<std::uint64_t>();
      }
    }
    if ((flags & 1) != 0 || (method != 0 && method != 8)) {
      directory.fail(
          fmt::format("{}: read are members that are stored or deflated, and not encrypted", member.name));
    }
    member.packed = method == 8;
    return member;
  }

  /// Finds the bytes of a member and reads the header; what it says is known before a packed one is unpacked.
  void open(NpyMember& member) {
    const std::string name = array_name(member);
    if (!is_log_array(name) && name != kNamesOfStates) {
      arrays_.push_back({.name = name, .type = "not read", .dims = {}});
      return;
    }
    constexpr std::uint64_t kLocal = 30;
    ByteCursor local = file_.cursor(member.begin, kLocal, "a member of a zip file");
    if (local.take<std::uint32_t>() != 0x04034b50)
      local.fail_at(member.begin, "no member of a zip file: corrupted");
    local.skip(22);
    const auto name_size = local.take<std::uint16_t>();
    const auto extra_size = local.take<std::uint16_t>();
    member.begin += kLocal + name_size + extra_size;
    if (!member.packed && member.packed_size != member.size) {
      local.fail(fmt::format("{}: of two sizes: corrupted", member.name));
    }
    if (member.begin > file_.size() || member.packed_size > file_.size() - member.begin) {
      local.fail(fmt::format("{}: {} bytes are said and the file ends at byte {}: cut off, or corrupted",
                             member.name, member.packed_size, file_.size()));
    }
    if (!member.packed) check(member);
    std::vector<std::uint8_t> beginning;
    const std::uint64_t size = std::min(member.size, kMostHeader);
    if (member.packed) decompress_beginning(packed_bytes(member), size, beginning);
    const ByteOrigin origin{path(), member.name};
    ArrayShape shape = header(member, member.packed ? ByteCursor(beginning, origin, 0)
                                                    : file_.cursor(member.begin, size, "an array"));
    shape.name = name;
    if (name == kNamesOfStates && shape.type != kText) shape = {.name = name, .type = "not read", .dims = {}};
    arrays_.push_back(std::move(shape));
  }

  ByteCursor packed_bytes(const NpyMember& member) {
    return file_.cursor(member.begin, member.packed_size, "a member of a zip file");
  }

  void unpack(NpyMember& member) {
    reserve(member);
    decompress(Compression::deflate, packed_bytes(member), member.size, member.held);
    check(member);
  }

  void hold(NpyMember& member) {
    reserve(member);
    const Bytes all = file_.view(member.begin, member.size, "an array");
    member.held.assign(all.begin(), all.end());
  }

  /// Several members may claim the same bytes of the file.
  void reserve(const NpyMember& member) {
    if (member.size > kLargestInMemory || (in_memory_ += member.size) > 2 * kLargestInMemory) {
      file_.fail(member.begin, fmt::format("{}: of packed arrays, and of those in Fortran order, 1 GiB each "
                                           "and 2 GiB in all are read; save them in C order with numpy.savez",
                                           member.name));
    }
  }

  void check(const NpyMember& member) {
    constexpr std::uint64_t kAtOnce = std::uint64_t{1} << 20;
    uLong checksum = crc32_z(0, nullptr, 0);
    for (std::uint64_t at = 0; at < member.size; at += kAtOnce) {
      const std::uint64_t count = std::min(kAtOnce, member.size - at);
      const Bytes part =
          member.packed
              ? Bytes(member.held).subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(count))
              : file_.view(member.begin + at, count, "an array");
      checksum = crc32_z(checksum, part.data(), part.size());
    }
    if (checksum != member.checksum) {
      file_.fail(member.begin, fmt::format("{} has a checksum that is not its own: corrupted", member.name));
    }
  }

  static constexpr std::uint64_t kMostHeader = 65536;

  /// Magic, version, and a Python dictionary of descr, fortran_order and shape.
  ArrayShape header(NpyMember& member, ByteCursor from) const {
    const ByteCursor start = from;
    if (from.take_text(6) != "\x93NUMPY") start.fail(fmt::format("{} is no .npy array", member.name));
    const auto version = from.take<std::uint8_t>();
    from.skip(1);
    const std::uint64_t length = version == 1 ? from.take<std::uint16_t>() : from.take<std::uint32_t>();
    const std::string_view text = from.take_text(length);
    member.header = from.taken();
    const std::string_view type = header_value(text, "descr"), order = header_value(text, "fortran_order");
    // What is said of the filter may be what numpy makes of a whole number, or of True and False.
    const auto names = [&](std::string_view start) { return member.name.starts_with(start); };
    const bool said =
        names("observation") || names("R") || names("time") || names("nonlinear") || names("inflated");
    member.integers = said && type.size() > 4 && type[2] == 'i';
    // Texts of numpy are code points of four bytes, as many as the longest has: one more dimension.
    const bool is_names = member.name == fmt::format("{}.npy", kNamesOfStates);
    std::uint64_t letters = 0;
    if (is_names && type.size() > 4 && (type[1] == '<' || type[1] == '>') && type[2] == 'U')
      std::from_chars(type.data() + 3, type.data() + type.size(), letters);
    const char kind = member.integers ? 'i' : 'f';
    const bool of_number =
        type.size() > 4 && (type[1] == '<' || type[1] == '>') && type[2] == kind && type[4] == '\'';
    if (letters > 0) {
      member.integers = true;
      member.number_size = 4;
    } else if (is_names) {
      return {.name = "", .type = "", .dims = {}};
    } else if (said && type.starts_with("'|b1'")) {
      member.number_size = 1;
    } else if (of_number && type[3] == '8') {
      member.number_size = 8;
    } else if (of_number && type[3] == '4') {
      member.number_size = 4;
    } else {
      start.fail(fmt::format("{} is of type {}; read are float32 and float64", member.name,
                             type.substr(0, std::min<std::size_t>(type.find(','), 24))));
    }
    member.order = type[1] == '>' ? std::endian::big : std::endian::little;
    member.fortran_order = order.starts_with("True");
    ArrayShape shape{
        .name = "",
        .type = letters > 0 ? std::string(kText)
                : member.number_size == 1
                    ? "bool"
                    : fmt::format("{}{}", member.integers ? "int" : "float", 8 * member.number_size),
        .dims = {}};
    std::uint64_t bytes = member.number_size;
    if (letters > member.size / bytes)
      start.fail(fmt::format("{}: a shape beyond its {} bytes: corrupted", member.name, member.size));
    if (letters > 0) bytes *= letters;
    for (std::string_view rest = header_value(text, "shape"); !rest.empty() && rest.front() != ')';) {
      const std::size_t digit = rest.find_first_of("0123456789)");
      if (digit == std::string_view::npos) start.fail(fmt::format("{}: no shape: corrupted", member.name));
      if (rest.substr(0, digit).find_first_not_of("(,L ") != std::string_view::npos) {  // L as of Python 2
        start.fail(fmt::format("{}: a shape of other than whole numbers from 0 on: corrupted", member.name));
      }
      rest.remove_prefix(digit);
      if (rest.front() == ')') break;
      std::uint64_t dim = 0;
      const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), dim);
      if (error != std::errc() || (dim > 0 && bytes > member.size / dim)) {
        start.fail(fmt::format("{}: a shape beyond its {} bytes: corrupted", member.name, member.size));
      }
      bytes *= dim;
      shape.dims.push_back(dim);
      rest.remove_prefix(static_cast<std::size_t>(stop - rest.data()));
    }
    if (member.header + bytes != member.size) {
      start.fail(fmt::format("{}: {} bytes of numbers where its shape needs {}: corrupted", member.name,
                             member.size - std::min(member.size, member.header), bytes));
    }
    if (letters > 0) shape.dims.push_back(letters);
    return shape;
  }

  BinaryFile file_;
  std::vector<NpyMember> members_;
  std::vector<ArrayShape> arrays_;
  std::uint64_t in_memory_ = 0;
};

}  // namespace

LogFormat npz_format() {
  return array_format<NpzFile>(
      {.name = "npz",
       .title = "NumPy arrays",
       .extensions = ".npz",
       .recognises = [](std::string_view beginning, const std::filesystem::path& file) {
         return file.extension() == ".npz" || beginning.starts_with("PK\x03\x04");
       }});
}

}  // namespace credence::internal
