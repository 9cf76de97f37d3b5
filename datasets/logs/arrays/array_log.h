#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/log_format.h"

/// @file
/// Runs of a filter as arrays: `error` (runs, steps, n), or `estimate` and `truth`, with `P` (runs, steps, n,
/// n), and `innovation` (runs,
/// steps, m) with `S` (runs, steps, m, m), or `innovation_NAME` with `S_NAME` for each of several sensors;
/// `nis_DIM` or `nis_NAME_DIM` (runs, steps) where of innovations of DIM components NIS alone is known.
/// One run may do without the first dimension, and scalars without those of the components: (runs, steps)
/// with (runs, steps). NaN marks what is missing: in an error a state that is not estimated, in an innovation
/// a component that was not measured.

namespace credence::internal {

/// The array of the names of the states, one text each, which are in memory as (n, letters) code points, 0
/// behind the last; "name:angle" is an angle in rad.
inline constexpr std::string_view kNamesOfStates = "names";

/// The type of an array of MATLAB whose elements are arrays: it is not read.
inline constexpr std::string_view kCellArray = "cell array";

/// An array of a file.
struct ArrayShape {
  std::string name;
  std::string type;  ///< for people
  std::vector<std::uint64_t> dims;
};

/// A file of arrays.
class ArrayFile {
 public:
  virtual ~ArrayFile() = default;
  virtual const std::filesystem::path& path() const = 0;
  virtual const std::vector<ArrayShape>& arrays() const = 0;
  /// Numbers first … first + count − 1 of array i, the last index running fastest.
  virtual void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) = 0;
};

/// Where number k of an array, counted with the last index running fastest, stands when the first one does.
std::uint64_t column_major_place(const std::vector<std::uint64_t>& dims, std::uint64_t k);

/// Whether an array of this name is one that read_arrays would read; others may hold anything.
bool is_log_array(std::string_view name);

/// Hands over the runs of a file, in memory for one run. Throws DataError for arrays that are not there or
/// whose dimensions do not agree, naming them.
void read_arrays(ArrayFile& file, LogSink& judged);

LogContents list_arrays(const ArrayFile& file);

/// The format whose files are such ones, given its names and what it recognises.
template <class File>
LogFormat array_format(LogFormat format) {
  format.list = [](const std::filesystem::path& file) { return list_arrays(File(file)); };
  format.read = [](const std::filesystem::path& file, const LogReadOptions&, LogSink& sink) {
    File arrays(file);
    read_arrays(arrays, sink);
    sink.advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
  };
  return format;
}

}  // namespace credence::internal
