#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// An array of a MAT-file.
struct MatArray {
  std::string name;
  bool is_read =
      false;  ///< else there are no more than its name: it was not wanted, or holds no real numbers
  std::vector<std::uint64_t> dims{};
  std::vector<double> numbers{};  ///< the first index running fastest
  bool is_cell = false;           ///< its elements are arrays
};

/// The arrays in a MAT-file of version 5, that is of MATLAB's save -v6 and -v7: its variables, and the fields
/// of a variable that is a structure; read are those whose names `wanted` takes. `names` may be texts, in a
/// matrix of characters or a cell array, which are read as (n, letters).
///
/// Format: "MAT-File Format", The MathWorks, chapter 1 (level 5). Numbers of any real type, either byte
/// order; packed variables up to 1 GiB each, all numbers up to 2 GiB. Throws DataError for a file that is
/// missing, cut, inconsistent or of another version.
std::vector<MatArray> read_mat_arrays(const std::filesystem::path& file,
                                      bool (*wanted)(std::string_view name));

/// Whether a file begins as such a one: of its `beginning` the header is looked at.
bool begins_as_mat(std::string_view beginning);

/// --input mat: arrays (array_log.h) in such a file. MATLAB leaves out last dimensions of 1.
LogFormat mat_format();

}  // namespace credence::internal
