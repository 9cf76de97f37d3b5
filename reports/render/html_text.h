#pragma once

#include <string>
#include <string_view>

namespace credence::internal {

/// `text` as one printable line (see printable_line) with & < > and both quotes as entities: safe as content
/// and as the value of an attribute, in HTML and in XML.
std::string escape_html(std::string_view text);

/// Percent-encodes what may not stand in the path of an address.
std::string encoded_path(std::string_view path);

}  // namespace credence::internal
