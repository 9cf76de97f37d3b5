#include "datasets/replay/mat_file.h"

#include <fmt/format.h>
#include <matio.h>

#include <algorithm>

#include "datasets/data_error.h"

namespace credence::internal {
namespace {

void close(void* mat) { Mat_Close(static_cast<mat_t*>(mat)); }

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

template <typename Number>
Matrix as_doubles(const void* data, Index rows, Index cols) {
  using Stored = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::Map<const Stored>(static_cast<const Number*>(data), rows, cols).template cast<double>();
}

/// The data of a variable in the type that libmatio holds it in, 0×0 for a type that is not a number.
Matrix to_doubles(const matvar_t& variable) {
  const auto rows = static_cast<Index>(variable.dims[0]);
  const auto cols = static_cast<Index>(variable.dims[1]);
  switch (variable.data_type) {
    case MAT_T_DOUBLE:
      return as_doubles<double>(variable.data, rows, cols);
    case MAT_T_SINGLE:
      return as_doubles<float>(variable.data, rows, cols);
    case MAT_T_INT8:
      return as_doubles<std::int8_t>(variable.data, rows, cols);
    case MAT_T_UINT8:
      return as_doubles<std::uint8_t>(variable.data, rows, cols);
    case MAT_T_INT16:
      return as_doubles<std::int16_t>(variable.data, rows, cols);
    case MAT_T_UINT16:
      return as_doubles<std::uint16_t>(variable.data, rows, cols);
    case MAT_T_INT32:
      return as_doubles<std::int32_t>(variable.data, rows, cols);
    case MAT_T_UINT32:
      return as_doubles<std::uint32_t>(variable.data, rows, cols);
    case MAT_T_INT64:
      return as_doubles<std::int64_t>(variable.data, rows, cols);
    case MAT_T_UINT64:
      return as_doubles<std::uint64_t>(variable.data, rows, cols);
    default:
      return {};
  }
}

/// Whether libmatio holds what the scan of the tags promised.
bool agrees(const matvar_t* variable, const MatArray& array) {
  return variable != nullptr && variable->data != nullptr && variable->rank == 2 &&
         variable->isComplex == 0 && variable->dims[0] == static_cast<std::size_t>(array.dims[0]) &&
         variable->dims[1] == static_cast<std::size_t>(array.dims[1]) &&
         variable->nbytes >= variable->dims[0] * variable->dims[1] * Mat_SizeOf(variable->data_type);
}

}  // namespace

// libmatio is silent as long as nobody gives it a log function.
MatFile::MatFile(const std::filesystem::path& file)
    : file_(file), arrays_(scan_mat_file(file)), handle_(Mat_Open(file.c_str(), MAT_ACC_RDONLY), close) {
  if (!handle_) throw DataError(file, "", "cannot be opened as a MAT-file");
}

void MatFile::fail(const std::string& name, const std::string& problem) const {
  throw DataError(file_, "variable '" + name + "'", problem);
}

const MatArray& MatFile::array(const std::string& name) const {
  const auto found = std::find_if(arrays_.begin(), arrays_.end(),
                                  [&](const MatArray& candidate) { return candidate.name == name; });
  if (found == arrays_.end()) {
    std::vector<std::string> names;
    for (const MatArray& other : arrays_) names.push_back(other.name);
    fail(name, fmt::format("is not in the file, which holds {}", fmt::join(names, ", ")));
  }
  return *found;
}

Matrix MatFile::matrix(const std::string& name) const {
  const MatArray& wanted = array(name);
  if (!wanted.numeric) fail(name, "holds text where numbers are expected");
  if (wanted.complex) fail(name, "is complex where real numbers are expected");
  if (wanted.dims.size() != 2) fail(name, fmt::format("has {} dimensions, not 2", wanted.dims.size()));
  if (wanted.dims[0] == 0 || wanted.dims[1] == 0) fail(name, "is empty");

  Mat_Rewind(static_cast<mat_t*>(handle_.get()));
  const Variable variable(Mat_VarRead(static_cast<mat_t*>(handle_.get()), name.c_str()), Mat_VarFree);
  if (!agrees(variable.get(), wanted)) fail(name, "cannot be read: corrupted");
  Matrix values = to_doubles(*variable);
  if (values.size() == 0) fail(name, "is stored in a type that holds no numbers");
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
