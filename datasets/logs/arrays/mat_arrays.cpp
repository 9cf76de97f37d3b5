#include "datasets/logs/arrays/mat_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <optional>
#include <set>

#include "core/utf8.h"
#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/bytes/binary_file.h"
#include "datasets/logs/bytes/decompress.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kMatHeader = 128;
constexpr const char* kNotVersion5 =
    "is no MAT-file of version 5 (no mark of its byte order), as those of version 4 and of save -ascii: "
    "save it with -v7 (MATLAB: save -v7 FILE)";
constexpr std::uint64_t kMostInMemory = std::uint64_t{2} << 30;

/// Types of data that hold others.
constexpr std::uint32_t kMatrix = 14, kCompressed = 15;
/// Classes of arrays.
constexpr std::uint32_t kCell = 1, kStructure = 2, kCharacters = 4, kFirstNumeric = 6, kLastNumeric = 15,
                        kOpaque = 17;  // tables, strings and other objects, in a form of MATLAB's own
constexpr std::uint32_t kComplexFlag = 0x0800;

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

/// All numbers of one type, which must be as many as the dimensions say.
template <class Number>
std::vector<double> take_numbers(ByteCursor from, const MatArray& array, std::uint64_t& in_memory) {
  std::uint64_t count = std::ranges::count(array.dims, 0U) > 0 ? 0 : 1;
  for (const std::uint64_t dim : array.dims) {
    // Beyond what is there, it need not be multiplied on.
    if (count > 0 && count > from.left() / dim) {
      from.fail(fmt::format("{}: dimensions beyond its {} bytes: corrupted", array.name, from.left()));
    }
    count *= dim;
  }
  if (count * sizeof(Number) != from.left()) {
    from.fail(
        fmt::format("{}: {} bytes of numbers do not fit its dimensions: corrupted", array.name, from.left()));
  }
  if ((in_memory += count * sizeof(double)) > kMostInMemory) {
    from.fail(fmt::format("{}: of the arrays of a MAT-file 2 GiB in all are read", array.name));
  }
  std::vector<double> values(static_cast<std::size_t>(count));
  for (double& value : values) value = static_cast<double>(from.take<Number>());
  return values;
}

/// A type of data that holds numbers, by its number in the format.
struct NumberType {
  std::uint32_t number;
  std::vector<double> (*take)(ByteCursor from, const MatArray& array, std::uint64_t& in_memory);
};
constexpr std::array<NumberType, 10> kNumberTypes{{{1, take_numbers<std::int8_t>},
                                                   {2, take_numbers<std::uint8_t>},
                                                   {3, take_numbers<std::int16_t>},
                                                   {4, take_numbers<std::uint16_t>},
                                                   {5, take_numbers<std::int32_t>},
                                                   {6, take_numbers<std::uint32_t>},
                                                   {7, take_numbers<float>},
                                                   {9, take_numbers<double>},
                                                   {12, take_numbers<std::int64_t>},
                                                   {13, take_numbers<std::uint64_t>}}};

/// The letters of a matrix of characters, as they lie.
std::vector<double> take_letters(Element element) {
  constexpr std::uint32_t kBytes[] = {1, 2, 16}, kWords[] = {4, 17};
  ByteCursor& from = element.data;
  std::vector<double> letters;
  if (std::ranges::find(kBytes, element.type) != std::end(kBytes)) {
    const std::string_view text = from.take_text(from.left());
    for (std::size_t i = 0; i < text.size();) letters.push_back(next_code_point(text, i));
  }
  while (!from.done()) {
    if (std::ranges::find(kWords, element.type) != std::end(kWords)) {
      letters.push_back(from.take<std::uint16_t>());
    } else {
      from.fail(fmt::format("letters of type {}: corrupted", element.type));
    }
  }
  return letters;
}

class MatReader {
 public:
  MatReader(const std::filesystem::path& file, bool (*wanted)(std::string_view))
      : file_(file), wanted_(wanted) {}

  std::vector<MatArray> read() {
    const std::endian order = read_header();
    for (std::uint64_t at = kMatHeader; at < file_.size();) {
      ByteCursor tag = file_.cursor(at, 8, "a variable", order);
      const auto type = tag.take<std::uint32_t>(), size = tag.take<std::uint32_t>();
      if (type != kMatrix && type != kCompressed) file_.fail(at, "no variable begins here: corrupted");
      variable(type, file_.cursor(at + 8, size, "a variable", order), at, order);
      at += 8 + std::uint64_t{size};
    }
    require_distinct_names();
    return std::move(arrays_);
  }

 private:
  /// Which of two is meant nobody can tell.
  void require_distinct_names() const {
    std::set<std::string_view> names;
    for (const MatArray& array : arrays_) {
      if (!wanted_(array.name) || names.insert(array.name).second) continue;
      file_.fail(0,
                 fmt::format("{} is there twice, as a variable or a field of a structure: save one of them",
                             array.name));
    }
  }

  std::endian read_header() {
    constexpr std::uint64_t kVersion4Header = 20;
    if (file_.size() >= kVersion4Header && file_.size() < kMatHeader) file_.fail(0, kNotVersion5);
    ByteCursor header = file_.cursor(0, kMatHeader, "the header of a MAT-file");
    header.skip(kMatHeader - 4);
    const std::string_view end = header.take_text(4);
    const bool little = end.ends_with("IM");
    if (!little && !end.ends_with("MI")) file_.fail(kMatHeader - 2, kNotVersion5);
    const char version = little ? end[1] : end[0];
    if (version == 2) {
      file_.fail(kMatHeader - 4,
                 "is a MAT-file of version 7.3, which is HDF5; save it with -v7 (MATLAB: s = load('FILE'); "
                 "save('FILE', '-struct', 's', '-v7'))");
    }
    if (version != 1)
      file_.fail(kMatHeader - 4, "is a MAT-file of another version; read is version 5 (save -v7)");
    return little ? std::endian::little : std::endian::big;
  }

  void variable(std::uint32_t type, ByteCursor body, std::uint64_t at, std::endian order) {
    if (type == kMatrix) return matrix(body, std::nullopt);
    std::vector<std::uint8_t> unpacked;
    decompress_zlib(body, unpacked);
    const ByteOrigin origin{file_.path(), fmt::format("the variable at byte {}", at)};
    ByteCursor all(unpacked, origin, 0, order);
    const Element element = take_element(all);
    if (element.type == kMatrix) matrix(element.data, std::nullopt);
  }

  /// An array, or the arrays of a structure. `field`: its name, where it is a field of one; structures within
  /// structures are not opened.
  void matrix(ByteCursor body, const std::optional<std::string>& field) {
    if (body.done()) return;  // an empty field
    ByteCursor flags = take_element(body).data;
    const std::uint32_t word = flags.take<std::uint32_t>();
    if ((word & 0xffU) == kOpaque) return opaque(body, field);
    std::vector<std::uint64_t> dims;
    for (ByteCursor from = take_element(body).data; !from.done();) {
      const auto dim = from.take<std::int32_t>();
      if (dim < 0) body.fail(fmt::format("a dimension of {}: corrupted", dim));
      dims.push_back(static_cast<std::uint64_t>(dim));
    }
    ByteCursor letters = take_element(body).data;
    const std::string own(letters.take_text(letters.left()));
    const std::string& name = field ? *field : own;
    const std::uint32_t kind = word & 0xffU;
    if (kind == kStructure && !field) return structure(body, dims);
    if (name == kNamesOfStates && (kind == kCell || kind == kCharacters)) return texts(kind, dims, body);
    const bool numeric = kind >= kFirstNumeric && kind <= kLastNumeric && (word & kComplexFlag) == 0;
    MatArray& array = arrays_.emplace_back(MatArray{.name = name, .is_cell = kind == kCell});
    if (!numeric || !wanted_(name)) return;
    array.is_read = true;
    array.dims = std::move(dims);
    array.numbers = numbers(array, take_element(body));
  }

  void opaque(ByteCursor body, const std::optional<std::string>& field) {
    std::string name = field.value_or("");
    if (!field) {
      ByteCursor letters = take_element(body).data;
      name = letters.take_text(letters.left());
    }
    if (name == kNamesOfStates)
      body.fail("names: are strings, in a form of MATLAB's own; save names = cellstr(names)");
    arrays_.push_back({.name = name});
  }

  /// The names of the states: the rows of a matrix of characters, or the texts of a cell array.
  void texts(std::uint32_t kind, const std::vector<std::uint64_t>& dims, ByteCursor body) {
    std::vector<std::vector<double>> rows;
    if (kind == kCharacters) {
      rows = rows_of_letters(dims, body);
    } else {
      while (!body.done()) {
        const Element cell = take_element(body);
        ByteCursor text = cell.data;
        ByteCursor flags = take_element(text).data;
        if (cell.type != kMatrix || (flags.take<std::uint32_t>() & 0xffU) != kCharacters)
          return void(arrays_.push_back({.name = std::string(kNamesOfStates)}));  // of something else
        std::vector<std::uint64_t> dims_of_text;
        for (ByteCursor from = take_element(text).data; !from.done();)
          dims_of_text.push_back(from.take<std::uint32_t>());
        take_element(text);  // its name
        std::ranges::move(rows_of_letters(dims_of_text, text), std::back_inserter(rows));
      }
    }
    std::size_t longest = 1;
    for (const auto& row : rows) longest = std::max(longest, row.size());
    if (rows.size() > kMostLetters / longest)
      body.fail(fmt::format("names: {} texts, one of {} letters: too many", rows.size(), longest));
    MatArray& array = arrays_.emplace_back(MatArray{.name = std::string(kNamesOfStates), .is_read = true});
    array.dims = {rows.size(), longest};
    array.numbers.assign(rows.size() * longest, 0.0);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t k = 0; k < rows[i].size(); ++k) array.numbers[k * rows.size() + i] = rows[i][k];
    }
  }

  /// Without the blanks that fill up a row.
  static std::vector<std::vector<double>> rows_of_letters(const std::vector<std::uint64_t>& dims,
                                                          ByteCursor body) {
    const std::vector<double> letters = take_letters(take_element(body));
    const std::uint64_t count = dims.size() == 2 ? dims[0] : 0;
    if (count == 0 && letters.empty()) return {{}};
    if (count > kMostLetters) body.fail(fmt::format("names: {} texts: too many", count));
    if (count == 0 || letters.size() % count != 0 || letters.size() / count != dims[1])
      body.fail("names: a text that does not fit its dimensions");
    std::vector<std::vector<double>> rows(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < letters.size(); ++k) rows[k % rows.size()].push_back(letters[k]);
    for (std::vector<double>& row : rows) {
      while (!row.empty() && (row.back() == ' ' || row.back() == 0.0)) row.pop_back();
    }
    return rows;
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
      if (value.type == kMatrix) matrix(value.data, std::string(padded.substr(0, padded.find('\0'))));
    }
  }

  std::vector<double> numbers(const MatArray& array, const Element& element) {
    const auto type = std::ranges::find(kNumberTypes, element.type, &NumberType::number);
    if (type == kNumberTypes.end()) {
      element.data.fail(fmt::format("{}: {} bytes of type {}, which holds no numbers: corrupted", array.name,
                                    element.data.left(), element.type));
    }
    return type->take(element.data, array, in_memory_);
  }

  static constexpr std::size_t kMostLetters = std::size_t{1} << 22;  ///< of all names of states

  BinaryFile file_;
  bool (*wanted_)(std::string_view);
  std::vector<MatArray> arrays_;
  std::uint64_t in_memory_ = 0;
};

class MatArrayFile final : public ArrayFile {
 public:
  explicit MatArrayFile(const std::filesystem::path& file)
      : path_(file), read_(read_mat_arrays(file, is_log_array)) {
    for (const MatArray& array : read_) {
      const bool text = array.name == kNamesOfStates;
      const std::string_view type = array.is_cell    ? kCellArray
                                    : !array.is_read ? "not read"
                                    : text           ? "text"
                                                     : "numbers";
      shapes_.push_back({array.name, std::string(type), array.dims});
    }
  }

  const std::filesystem::path& path() const override { return path_; }
  const std::vector<ArrayShape>& arrays() const override { return shapes_; }

  void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) override {
    out.resize(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = read_[i].numbers[static_cast<std::size_t>(column_major_place(shapes_[i].dims, first + k))];
    }
  }

 private:
  std::filesystem::path path_;
  std::vector<MatArray> read_;
  std::vector<ArrayShape> shapes_;
};

}  // namespace

std::vector<MatArray> read_mat_arrays(const std::filesystem::path& file, bool (*wanted)(std::string_view)) {
  return MatReader(file, wanted).read();
}

bool begins_as_mat(std::string_view beginning) {
  if (beginning.size() < kMatHeader || !beginning.starts_with("MATLAB")) return false;
  const std::string_view order = beginning.substr(kMatHeader - 2, 2);
  return order == "IM" || order == "MI";
}

LogFormat mat_format() {
  return array_format<MatArrayFile>(
      {.name = "mat",
       .title = "MATLAB arrays",
       .extensions = ".mat",
       .recognises = [](std::string_view beginning, const std::filesystem::path& file) {
         return begins_as_mat(beginning) || file.extension() == ".mat";
       }});
}

}  // namespace credence::internal
