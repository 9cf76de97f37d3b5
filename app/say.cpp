#include "app/say.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "reports/render/utf8_text.h"

namespace credence::internal {

void say(std::string_view line) {
  std::string text;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find('\n', begin), line.size());
    text += printable_line(line.substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  std::fflush(stdout);  // where both go to one place, what is said stands behind whole lines of results
  std::fputs(text.c_str(), stderr);
}

}  // namespace credence::internal
