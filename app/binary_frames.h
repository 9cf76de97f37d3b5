#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace credence::internal {

/// The first line of a stream of binary frames: after it lines that begin with #, the names of the columns as
/// in CSV, and then every row as so many little-endian float64, NaN where CSV has a blank.
inline constexpr std::string_view kFramesHead = "# credence frames 1";

/// A row as bytes.
std::string frame_of(std::span<const double> row);

/// A row as CSV without its line's end: the first `whole` of its numbers are integers and written as such,
/// all others, and an "integer" that is none, in the shortest decimals that read back as the same bits; NaN
/// is blank.
std::string csv_row(std::span<const double> row, std::size_t whole);

/// Whether a file is a stream of frames.
bool holds_frames(const std::filesystem::path& file);

/// Writes the CSV that a stream of frames stands for, without its comments. Throws std::runtime_error for a
/// stream that breaks off within its names or a row, or that cannot be written.
void frames_to_csv(const std::filesystem::path& frames, const std::filesystem::path& csv);

}  // namespace credence::internal
