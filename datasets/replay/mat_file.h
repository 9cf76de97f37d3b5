#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/types.h"
#include "datasets/logs/arrays/mat_arrays.h"

namespace credence::internal {

/// The real two-dimensional arrays of a MAT-file (mat_arrays.h). All functions throw DataError naming the
/// file and, where there is one, the variable.
class MatFile {
 public:
  explicit MatFile(const std::filesystem::path& file);

  /// The variable as rows × cols doubles, whatever numeric class it is stored in.
  ///
  /// Throws for a variable that is missing, text, complex, empty, of more than two dimensions, or that holds
  /// a number that is not finite.
  Matrix matrix(const std::string& name) const;

  /// The variable as matrix() reads it, of shape 1×n or n×1.
  Vector vector(const std::string& name) const;

  [[noreturn]] void fail(const std::string& name, const std::string& problem) const;

 private:
  std::filesystem::path file_;
  std::vector<MatArray> arrays_;
};

}  // namespace credence::internal
