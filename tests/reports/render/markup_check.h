#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace credence::internal {

/// What is wrong with `xml` as well-formed XML (tags nested and closed, attributes quoted, entities known),
/// or nothing. Knows just enough for SVG without declarations.
inline std::string xml_problem(std::string_view xml) {
  std::vector<std::string> open;
  std::size_t i = 0;
  while (i < xml.size()) {
    if (xml[i] == '&') {
      const std::size_t end = xml.find(';', i);
      if (end == std::string_view::npos) return "bare ampersand";
      const std::string_view name = xml.substr(i + 1, end - i - 1);
      const std::vector<std::string_view> known{"amp", "lt", "gt", "quot", "#39"};
      if (std::find(known.begin(), known.end(), name) == known.end())
        return "unknown entity " + std::string(name);
      i = end + 1;
    } else if (xml[i] == '<') {
      std::size_t j = i + 1;
      char quote = '\0';
      for (; j < xml.size() && (quote != '\0' || xml[j] != '>'); ++j) {
        if (xml[j] == '<') return "'<' in a tag";
        if (quote != '\0') {
          if (xml[j] == quote) quote = '\0';
        } else if (xml[j] == '"' || xml[j] == '\'') {
          quote = xml[j];
        }
      }
      if (j == xml.size()) return "a tag does not end";
      const std::string tag(xml.substr(i + 1, j - i - 1));
      const std::string name = tag.substr(0, tag.find_first_of(" \n/", 1));
      if (tag.starts_with('/')) {
        if (open.empty() || "/" + open.back() != tag) return "unexpected <" + tag + ">";
        open.pop_back();
      } else if (!tag.ends_with('/')) {
        open.push_back(name);
      }
      i = j + 1;
    } else if (static_cast<unsigned char>(xml[i]) < 0x20 && xml[i] != '\n' && xml[i] != '\t') {
      return "control character";
    } else {
      ++i;
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

/// All text between tags, entities replaced: what a reader sees.
inline std::string visible_text(std::string_view xml) {
  std::string text;
  bool in_tag = false;
  for (const char c : xml) {
    if (c == '<') in_tag = true;
    if (!in_tag) text += c;
    if (c == '>') in_tag = false;
  }
  const std::vector<std::pair<std::string, std::string>> entities{
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&amp;", "&"}};
  for (const auto& [entity, character] : entities) {
    for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
      text.replace(at, entity.size(), character);
    }
  }
  return text;
}

inline int count_of(std::string_view text, std::string_view part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos;
       at = text.find(part, at + part.size())) {
    ++count;
  }
  return count;
}

}  // namespace credence::internal
