#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/types.h"
#include "datasets/replay/mat_structure.h"

namespace credence::internal {

/// The real two-dimensional arrays of a MATLAB MAT-file of version 5, read through libmatio.
///
/// The constructor checks the whole structure first (scan_mat_file), because a general reader answers a
/// truncated file with silence or with zeros. All functions throw DataError naming the file and the variable.
class MatFile {
 public:
  explicit MatFile(const std::filesystem::path& file);

  const std::filesystem::path& file() const { return file_; }

  /// The variable as rows × cols doubles, whatever numeric class it is stored in.
  ///
  /// Throws for a variable that is missing, text, complex, empty, of more than two dimensions, or that holds
  /// a number that is not finite.
  Matrix matrix(const std::string& name) const;

  /// The variable as matrix() reads it, of shape 1×n or n×1.
  Vector vector(const std::string& name) const;

  [[noreturn]] void fail(const std::string& name, const std::string& problem) const;

 private:
  const MatArray& array(const std::string& name) const;

  std::filesystem::path file_;
  std::vector<MatArray> arrays_;
  std::unique_ptr<void, void (*)(void*)> handle_;  ///< libmatio's mat_t
};

}  // namespace credence::internal
