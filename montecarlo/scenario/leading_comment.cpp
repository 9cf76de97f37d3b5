#include "montecarlo/scenario/leading_comment.h"

#include "core/utf8.h"

namespace credence::internal {

std::string leading_comment(std::istream& scenario) {
  constexpr std::size_t kLongest = 2000;  // of what a page should quote
  std::string text;
  for (std::string line; text.size() < kLongest && std::getline(scenario, line) && line.starts_with('#');) {
    const std::size_t begin = line.find_first_not_of("# \t\r");
    if (begin == std::string::npos) break;  // an empty line of comment ends the first paragraph
    const std::size_t end = line.find_last_not_of(" \t\r");
    text += (text.empty() ? "" : " ");
    text += line.substr(begin, end - begin + 1);
  }
  return std::string(beginning_of_text(text, kLongest));
}

}  // namespace credence::internal
