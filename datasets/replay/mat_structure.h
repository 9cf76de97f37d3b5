#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace credence::internal {

/// What the header of one array in a MAT-file says, checked against the bytes that are there.
struct MatArray {
  std::string name;
  std::vector<std::int32_t> dims;  ///< at least two
  bool numeric = false;            ///< a real or complex array of floating-point or integer class
  bool complex = false;
};

/// Walks the tags of an uncompressed MAT-file of version 5 and proves that every array lies within the file.
///
/// Format: "MAT-File Format", The MathWorks, chapter 1 (level 5). Only tags are read, no data. Each array's
/// dimensions must agree with the number of bytes of its data, so that a file which passes can be handed to
/// a general reader without fear of wild sizes. Throws DataError for a file that is missing, truncated,
/// inconsistent, of another version, or that holds compressed or non-plain arrays (cells, structures,
/// sparse).
std::vector<MatArray> scan_mat_file(const std::filesystem::path& file);

}  // namespace credence::internal
