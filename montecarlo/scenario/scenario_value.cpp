#include "montecarlo/scenario/scenario_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/utf8.h"

namespace credence::internal {
namespace {

constexpr std::size_t kLongestText = 60;

std::string shortened(const std::string& text, std::size_t longest = kLongestText) {
  return text.size() <= longest ? text : std::string(beginning_of_text(text, longest)) + "...";
}

std::string escaped(std::string_view text, std::string_view also) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (also.find(c) != std::string_view::npos) result += '\\';
    if (byte < 0x20 || byte == 0x7F) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(byte));
    } else {
      result += c;
    }
  }
  return result;
}

/// Levenshtein distance.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

struct TypeName {
  std::string_view operator()(bool) const { return "the boolean"; }
  std::string_view operator()(std::int64_t) const { return "the integer"; }
  std::string_view operator()(double) const { return "the number"; }
  std::string_view operator()(const std::string&) const { return "the string"; }
  std::string_view operator()(const OtherValue&) const { return ""; }
  std::string_view operator()(const ScalarValue& value) const { return std::visit(*this, value); }
  std::string_view operator()(const std::vector<ScalarValue>&) const { return "the array"; }
  std::string_view operator()(const NestedArray&) const { return "the array"; }
};

/// The whole text.
struct ScalarText {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
  std::string operator()(double value) const { return real_text(value); }
  std::string operator()(const std::string& value) const { return quoted_text(value); }
  std::string operator()(const OtherValue& value) const { return value.type; }
};

/// The elements behind some `longest` characters may be left out.
template <class Elements, class Text>
std::string list_text(const Elements& elements, std::size_t longest, Text text_of) {
  std::string text = "[";
  for (const auto& element : elements) {
    if (text.size() > longest) break;
    text += (text.size() > 1 ? ", " : "") + text_of(element);
  }
  return text + "]";
}

std::string array_text(const SettingValue& value, std::size_t longest,
                       std::string (*scalar_text)(const ScalarValue&)) {
  if (const auto* flat = std::get_if<std::vector<ScalarValue>>(&value)) {
    return list_text(*flat, longest, scalar_text);
  }
  return list_text(std::get<NestedArray>(value), longest,
                   [&](const std::vector<ScalarValue>& row) { return list_text(row, longest, scalar_text); });
}

std::string whole_text(const ScalarValue& value) { return std::visit(ScalarText{}, value); }

}  // namespace

std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  const bool is_float = text.find_first_of(".enai") != std::string::npos;  // 1e+22, nan and inf need no point
  return is_float ? text : text + ".0";
}

std::string quoted_text(std::string_view text) { return fmt::format("\"{}\"", escaped(text, "\"\\")); }

std::string shown_text(std::string_view text, std::size_t longest) {
  return shortened(escaped(text, ""), longest);
}

std::string value_text(const ScalarValue& value) { return shortened(whole_text(value)); }

std::string value_text(const SettingValue& value) {
  if (const auto* scalar = std::get_if<ScalarValue>(&value)) return value_text(*scalar);
  return shortened(array_text(value, kLongestText, value_text));
}

std::string full_text(const SettingValue& value) {
  if (const auto* scalar = std::get_if<ScalarValue>(&value)) return whole_text(*scalar);
  return array_text(value, std::string::npos, whole_text);
}

std::string_view type_text(const SettingValue& value) { return std::visit(TypeName{}, value); }

std::string_view closest_word(std::string_view word, const std::vector<std::string_view>& words) {
  if (word.size() > kLongestText) return {};
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : words) {
    // Short words are all alike: what keeps no character is no misspelling.
    const std::size_t distance = edits(word, candidate);
    if (distance < least && distance < std::max(word.size(), candidate.size())) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace credence::internal
