#include "reports/render/html_text.h"

#include "reports/render/utf8_text.h"

namespace credence {

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char c : printable_line(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace credence
