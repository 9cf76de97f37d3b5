#include "app/binary_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace credence::internal {
namespace {

constexpr std::size_t kBytes = sizeof(double);
constexpr double kLargestInteger = 9007199254740992.0;  // 2^53: up to it a float64 holds every one

/// Between the order of this machine and little-endian.
std::uint64_t little_endian(std::uint64_t bits) {
  if constexpr (std::endian::native == std::endian::little) {
    return bits;
  } else {
    return __builtin_bswap64(bits);
  }
}

}  // namespace

std::string frame_of(std::span<const double> row) {
  std::string bytes(row.size() * kBytes, '\0');
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::uint64_t bits = little_endian(std::bit_cast<std::uint64_t>(row[i]));
    std::copy_n(reinterpret_cast<const char*>(&bits), kBytes, bytes.data() + i * kBytes);
  }
  return bytes;
}

std::string csv_row(std::span<const double> row, std::size_t whole) {
  std::string text;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) text += ',';
    if (std::isnan(row[i])) continue;
    const bool integer = i < whole && std::trunc(row[i]) == row[i] && std::abs(row[i]) <= kLargestInteger;
    text += integer ? fmt::format("{}", static_cast<std::int64_t>(row[i])) : fmt::format("{}", row[i]);
  }
  return text;
}

bool holds_frames(const std::filesystem::path& file) {
  std::ifstream input(file, std::ios::binary);
  std::string line;
  return std::getline(input, line) && line == kFramesHead;
}

void frames_to_csv(const std::filesystem::path& frames, const std::filesystem::path& csv) {
  std::ifstream input(frames, std::ios::binary);
  std::ofstream output(csv, std::ios::binary);
  std::string names;
  while (std::getline(input, names) && names.starts_with('#')) continue;
  if (!input || input.eof()) throw std::runtime_error("frames: the stream has no line with names of columns");
  output << names << '\n';
  // Which columns hold whole numbers: the numbers of runs and steps, which stand first.
  const std::size_t whole = names.starts_with("run,step,") ? 2 : names.starts_with("step,") ? 1 : 0;
  const auto columns = static_cast<std::size_t>(std::ranges::count(names, ',')) + 1;
  std::vector<double> row(columns);
  std::string bytes(columns * kBytes, '\0');
  for (std::int64_t number = 1;; ++number) {
    input.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (input.gcount() == 0) break;
    if (static_cast<std::size_t>(input.gcount()) < bytes.size()) {
      throw std::runtime_error(fmt::format("frames: row {} breaks off after {} of {} bytes", number,
                                           input.gcount(), bytes.size()));
    }
    for (std::size_t i = 0; i < columns; ++i) {
      std::uint64_t bits = 0;
      std::copy_n(bytes.data() + i * kBytes, kBytes, reinterpret_cast<char*>(&bits));
      row[i] = std::bit_cast<double>(little_endian(bits));
    }
    output << csv_row(row, whole) << '\n';
  }
  output.close();
  if (!output) throw std::runtime_error(fmt::format("{}: cannot be written", csv.string()));
}

}  // namespace credence::internal
