#pragma once

#include <string>
#include <string_view>

#include "reports/render/json_numbers.h"

namespace credence::internal {

/// The JSON of a file of this name. Throws std::invalid_argument with its name, the line and the column where
/// it is none.
Json parsed_json(const std::string& name, std::string_view text);

/// Throws std::invalid_argument where a document says that it is of another schema than this program writes.
void require_schema(const std::string& name, const Json& document);

/// Throws std::invalid_argument where a number by which results are compared is one that none has: a count or
/// a mean NEES below 0, a p-value above 1. What is missing, or no number, is passed over.
void require_possible(const std::string& name, const Json& result);

}  // namespace credence::internal
