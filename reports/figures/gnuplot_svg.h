#pragma once

#include <string>
#include <string_view>

/// @file
/// From gnuplot's SVG to a compact one that may stand in a web page.

namespace credence {

/// Rewrites what gnuplot's svg terminal wrote for a gnuplot_script into one <svg> element for use in HTML: no
/// ids (many figures share a page), no fixed size (it scales with its container), markers as paths,
/// `description` for screen readers. Only known drawing elements pass, and no text can become markup. Throws
/// std::runtime_error on anything else.
std::string clean_svg(std::string_view raw, std::string_view description);

}  // namespace credence
