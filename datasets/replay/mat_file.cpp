#include "datasets/replay/mat_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/data_error.h"

namespace credence::internal {

MatFile::MatFile(const std::filesystem::path& file)
    : file_(file), arrays_(read_mat_arrays(file, [](std::string_view) { return true; })) {}

void MatFile::fail(const std::string& name, const std::string& problem) const {
  throw DataError(file_, "variable '" + name + "'", problem);
}

Matrix MatFile::matrix(const std::string& name) const {
  const auto array = std::ranges::find(arrays_, name, &MatArray::name);
  if (array == arrays_.end()) {
    std::vector<std::string> names;
    for (const MatArray& other : arrays_) names.push_back(other.name);
    fail(name, fmt::format("is not in the file, which holds {}", fmt::join(names, ", ")));
  }
  if (!array->is_read) fail(name, "holds text, complex numbers or cells where real numbers are expected");
  if (array->dims.size() != 2) fail(name, fmt::format("has {} dimensions, not 2", array->dims.size()));
  if (array->numbers.empty()) fail(name, "is empty");
  Matrix values = Eigen::Map<const Matrix>(array->numbers.data(), static_cast<Index>(array->dims[0]),
                                           static_cast<Index>(array->dims[1]));
  if (!values.allFinite()) fail(name, "holds a number that is not finite");
  return values;
}

Vector MatFile::vector(const std::string& name) const {
  const Matrix values = matrix(name);
  if (values.rows() != 1 && values.cols() != 1)
    fail(name, fmt::format("is {}x{} where one row or column is expected", values.rows(), values.cols()));
  return values.reshaped();
}

}  // namespace credence::internal
