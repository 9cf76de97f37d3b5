#include "reports/render/parsed_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace credence::internal {

Json parsed_json(const std::string& name, std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw std::invalid_argument(name + ": is empty, and no JSON");
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::string_view before =
        text.substr(0, std::min(text.size(), std::max<std::size_t>(error.byte, 1) - 1));
    const std::size_t line_end = before.rfind('\n');
    throw std::invalid_argument(
        fmt::format("{}:{}: is no JSON, from column {} on", name, 1 + std::ranges::count(before, '\n'),
                    before.size() - (line_end == std::string_view::npos ? 0 : line_end + 1) + 1));
  } catch (const Json::exception&) {
    throw std::invalid_argument(name + ": is no JSON: a number in it is beyond all numbers");
  }
}

void require_schema(const std::string& name, const Json& document) {
  if (!document.is_object()) return;
  const auto schema = document.find("schema");
  if (schema == document.end() || *schema == kSchema) return;
  throw std::invalid_argument(
      fmt::format("{}: schema = {}: this version of Credence reads {}", name, schema->dump(), kSchema));
}

}  // namespace credence::internal
