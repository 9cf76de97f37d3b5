#pragma once

#include <iterator>
#include <string_view>
#include <vector>

namespace credence::internal {

/// What the items of a list are called: their members `name`, which must outlive what is returned.
template <typename Range>
std::vector<std::string_view> names_in(const Range& items) {
  std::vector<std::string_view> names;
  names.reserve(std::size(items));
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace credence::internal
