#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/types.h"

/// @file
/// JSON of numbers. It has no NaN and no infinity: the library writes null for both, and the document says
/// why elsewhere.

namespace credence::internal {

using Json = nlohmann::ordered_json;

/// Version of the documents (docs/formats.md).
inline constexpr int kSchema = 1;

/// A document as text. Names of files, columns and sensors are other people's bytes: what is no UTF-8 becomes
/// U+FFFD.
inline std::string text_of_json(const Json& document, int indent = 1) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

inline Json json_vector(const Vector& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

/// Rows of numbers.
inline Json json_matrix(const Matrix& matrix) {
  Json rows = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) rows.push_back(json_vector(matrix.row(i)));
  return rows;
}

/// A list of what `make` makes of each item.
template <class Items, class Make>
Json json_list(const Items& items, Make make) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(std::invoke(make, item));
  return list;
}

/// A number with its interval.
inline Json json_interval(double value, double lower, double upper) {
  return {{"value", value}, {"lower", lower}, {"upper", upper}};
}

/// The same of a MeanInterval, or what has its members.
template <class Interval>
Json json_interval(const Interval& interval) {
  return json_interval(interval.mean, interval.lower, interval.upper);
}

/// The object, with the reason why numbers of it are null where there is one.
inline Json with_reason(Json object, std::string_view reason) {
  if (!reason.empty()) object["reason"] = reason;
  return object;
}

inline Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

}  // namespace credence::internal
