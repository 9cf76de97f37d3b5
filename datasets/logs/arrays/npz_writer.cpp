#include "datasets/logs/arrays/npz_writer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/utf8.h"
#include "datasets/logs/bytes/append_crc32.h"
#include "datasets/logs/bytes/append_number.h"

namespace credence::internal {
namespace {

/// What numpy holds texts as: the code points of each, in four bytes, up to the longest.
struct CodePoints {
  std::size_t longest = 1;
  std::string bytes;
};

CodePoints code_points_of(const std::vector<std::string>& texts) {
  std::vector<std::vector<std::uint32_t>> all;
  CodePoints points;
  for (const std::string& text : texts) {
    auto& letters = all.emplace_back();
    for (std::size_t i = 0; i < text.size();)
      letters.push_back(static_cast<std::uint32_t>(next_code_point(text, i)));
    points.longest = std::max(points.longest, letters.size());
  }
  for (auto& letters : all) {
    letters.resize(points.longest, 0);
    for (const std::uint32_t letter : letters) append_number(points.bytes, letter);
  }
  return points;
}

std::string npy_bytes(const NamedArray& array) {
  constexpr std::size_t kPrefix = 10, kAlignment = 64;
  const auto count =
      std::accumulate(array.dims.begin(), array.dims.end(), std::uint64_t{1}, std::multiplies<>());
  const std::size_t given = array.texts.empty() ? array.values.size() : array.texts.size();
  if (count != given) {
    throw std::invalid_argument(
        fmt::format("{}: {} values for dimensions ({})", array.name, given, fmt::join(array.dims, ", ")));
  }
  const CodePoints texts = code_points_of(array.texts);
  const std::string type = array.texts.empty() ? "<f8" : fmt::format("<U{}", texts.longest);
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({},), }}", type,
                                   fmt::join(array.dims, ", "));
  header.resize((header.size() + kPrefix + kAlignment) / kAlignment * kAlignment - kPrefix, ' ');
  header.back() = '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  append_number(bytes, static_cast<std::uint16_t>(header.size()));
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(array.values.data()), array.values.size() * sizeof(double));
  return bytes + texts.bytes;
}

/// What the header of a member and its entry in the directory have in common (APPNOTE.TXT of PKWARE, 4.3.7
/// and 4.3.12, from "version needed" to the lengths of the name and of what is extra).
std::string member_head(const std::string& name, const std::string& content) {
  constexpr std::uint16_t kVersion = 20, kFirstDay = 0x21;
  std::string head;
  append_number(head, kVersion);
  append_number(head, std::uint16_t{0});  // flags
  append_number(head, std::uint16_t{0});  // not packed
  append_number(head, std::uint16_t{0});
  append_number(head, kFirstDay);  // 1980-01-01: the same runs give the same bytes
  append_crc32(head, content);
  append_number(head, static_cast<std::uint32_t>(content.size()));
  append_number(head, static_cast<std::uint32_t>(content.size()));
  append_number(head, static_cast<std::uint16_t>(name.size()));
  append_number(head, std::uint16_t{0});
  return head;
}

}  // namespace

std::string npz_bytes(std::span<const NamedArray> arrays) {
  std::string file, directory;
  for (const NamedArray& array : arrays) {
    const std::string content = npy_bytes(array), name = array.name + ".npy";
    if (file.size() + content.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
      throw std::invalid_argument(fmt::format("{}: a file of arrays holds at most 2 GiB", array.name));
    }
    const std::string head = member_head(name, content);
    directory += std::string("PK\x01\x02\x14\x00", 6) + head + std::string(10, '\0');
    append_number(directory, static_cast<std::uint32_t>(file.size()));
    directory += name;
    file.append("PK\x03\x04").append(head).append(name).append(content);
  }
  const std::size_t begin = file.size();
  file += directory + std::string("PK\x05\x06\x00\x00\x00\x00", 8);
  append_number(file, static_cast<std::uint16_t>(arrays.size()));
  append_number(file, static_cast<std::uint16_t>(arrays.size()));
  append_number(file, static_cast<std::uint32_t>(directory.size()));
  append_number(file, static_cast<std::uint32_t>(begin));
  append_number(file, std::uint16_t{0});
  return file;
}

}  // namespace credence::internal
