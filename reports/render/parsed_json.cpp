#include "reports/render/parsed_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

struct NumberKind {
  bool (*accepts)(double);
  const char* accepted;
};

constexpr NumberKind kCount{[](double x) { return x >= 0.0 && x <= 0x1p53 && x == std::floor(x); },
                            "be a whole number of at least 0"};
constexpr NumberKind kAtLeastZero{[](double x) { return x >= 0.0; }, "be at least 0"};
constexpr NumberKind kPValue{[](double x) { return x >= 0.0 && x <= 1.0; }, "lie in [0, 1]"};
constexpr NumberKind kConfidence{[](double x) { return x > 0.0 && x < 1.0; }, "lie in (0, 1)"};

/// The number at a place below `in`, which is at `before`: "word.p_value", or all of "blocks.*.mean".
void require_number(const std::string& name, const Json& in, const std::string& before,
                    std::string_view place, const NumberKind& kind) {
  if (place.empty()) {
    if (!in.is_number() || kind.accepts(in.get<double>())) return;
    throw std::invalid_argument(
        fmt::format("{}: {} = {}: must {}", name, before, in.get<double>(), kind.accepted));
  }
  if (!in.is_structured()) return;
  const std::string_view first = place.substr(0, place.find('.'));
  const std::string_view rest = place.substr(std::min(place.size(), first.size() + 1));
  for (const auto& [key, value] : in.items()) {
    if (first != "*" && first != key) continue;
    const std::string at = before.empty() ? key : fmt::format("{}.{}", before, key);
    require_number(name, value, at, rest, kind);
  }
}

}  // namespace

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

void require_possible(const std::string& name, const Json& result) {
  const auto require = [&](std::string_view place, const NumberKind& kind) {
    require_number(name, result, "", place, kind);
  };
  for (const char* count :
       {"runs", "rows", "rejected_rows", "unmatched_rows", "state_dim", "wrongly_certain.*.count"})
    require(count, kCount);
  require("word.p_value", kPValue);
  require("nees.confidence", kConfidence);
  for (const std::string verdict : {"nees", "nis", "vehicle_nees", "blocks.*", "sensors.*.nis"}) {
    require(verdict + ".mean", kAtLeastZero);
    require(verdict + ".expected", kAtLeastZero);
    for (const char* of : {"value", "lower", "upper"}) require(verdict + ".factor." + of, kAtLeastZero);
    require(verdict + ".p_value", kPValue);
  }
  require("calibration.unit_factors.*.*", kAtLeastZero);
}

}  // namespace credence::internal
