#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

using Json = nlohmann::ordered_json;

/// Version of the documents (docs/formats.md).
inline constexpr int kSchema = 1;

/// JSON has no NaN and no infinity: null stands for both, and the document says why elsewhere.
inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

inline Json json_numbers(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(json_number(value));
  return array;
}

/// A document as text. Names of files, columns and sensors are other people's bytes: what is no UTF-8 becomes
/// U+FFFD.
inline std::string text_of_json(const Json& document, int indent = 1) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Rows of numbers.
inline Json json_matrix(const Matrix& matrix) {
  Json rows = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Index j = 0; j < matrix.cols(); ++j) row.push_back(json_number(matrix(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace credence::internal
