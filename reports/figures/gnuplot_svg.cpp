#include "reports/figures/gnuplot_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <initializer_list>
#include <stdexcept>
#include <utility>
#include <vector>

#include "reports/figures/gnuplot_svg_markers.h"
#include "reports/figures/gnuplot_svg_tag.h"
#include "reports/figures/gnuplot_text.h"
#include "reports/render/html_text.h"
#include "reports/render/utf8_text.h"

namespace credence {
namespace {

// What every drawing inherits from the root; gnuplot repeats it on each group.
constexpr std::array<SvgAttribute, 6> kInherited{{{"fill", "none"},
                                                  {"color", "black"},
                                                  {"stroke", "currentColor"},
                                                  {"stroke-width", "1.00"},
                                                  {"stroke-linecap", "butt"},
                                                  {"stroke-linejoin", "miter"}}};

bool is_inherited(const SvgAttribute& attribute) {
  return std::any_of(kInherited.begin(), kInherited.end(), [&](const SvgAttribute& known) {
    return known.name == attribute.name && known.value == attribute.value;
  });
}

std::string attribute_text(std::string_view name, std::string_view value) {
  return fmt::format(" {}=\"{}\"", name, escape_html(short_colour(value)));
}

// The attributes among `names` that the tag has.
std::string chosen_attributes(const SvgTag& tag, std::initializer_list<std::string_view> names) {
  std::string out;
  for (const std::string_view name : names) {
    if (!tag.value(name).empty()) out += attribute_text(name, tag.value(name));
  }
  return out;
}

class SvgCleaner {
 public:
  explicit SvgCleaner(std::string_view description) : description_(description) {}

  std::string clean(std::string_view raw) {
    std::size_t position = raw.find("<svg");
    if (position == std::string_view::npos) throw std::runtime_error("gnuplot wrote no <svg>");
    while (!finished_) {
      const std::size_t open = raw.find('<', position);
      const std::size_t close = raw.find('>', open == std::string_view::npos ? raw.size() : open);
      if (close == std::string_view::npos)
        throw std::runtime_error("gnuplot wrote an SVG that is not complete");
      words(raw.substr(position, open - position));
      element(parse_svg_tag(raw.substr(open + 1, close - open - 1)));
      position = close + 1;
    }
    return std::move(out_);
  }

 private:
  // Characters that travelled in the private-use area come back as entities.
  void words(std::string_view text) {
    if (ignored_ > 0 || !in_text_) return;
    for (std::size_t i = 0; i < text.size();) {
      const char32_t c = next_code_point(text, i);
      const bool travelled = c >= kEscapedCharacters && c < kEscapedCharacters + 0x80;
      if (travelled) {
        out_ += escape_html(std::string(1, static_cast<char>(c - kEscapedCharacters)));
      } else {
        append_utf8(out_, c);
      }
    }
  }

  void element(const SvgTag& tag) {
    const bool ignored = tag.name == "title" || tag.name == "desc" || tag.name == "defs";
    if (ignored) ignored_ += tag.closes ? -1 : 1;
    if (ignored || ignored_ > 0) return;
    if (!markers_.continues(tag)) out_ += markers_.take();
    if (tag.name == "svg") return root(tag);
    if (tag.name == "g") return group(tag);
    if (tag.name == "text") return text(tag);
    if (tag.name == "tspan") return span(tag);
    if (tag.name == "path") return path(tag);
    if (tag.name == "polygon") return polygon(tag);
    if (tag.name == "rect") return rectangle(tag);
    if (tag.name == "use") return markers_.add(tag);
    throw std::runtime_error(fmt::format("gnuplot wrote an unexpected element <{}>", tag.name));
  }

  void root(const SvgTag& tag) {
    finished_ = tag.closes;
    if (tag.closes) {
      out_ += "</svg>\n";
      return;
    }
    out_ += "<svg xmlns=\"http://www.w3.org/2000/svg\"" + attribute_text("viewBox", tag.value("viewBox"));
    out_ += " role=\"img\"" + attribute_text("aria-label", description_);
    out_ += attribute_text("font-family", "Helvetica, Arial, sans-serif");
    for (const SvgAttribute& one : kInherited) out_ += attribute_text(one.name, one.value);
    out_ += ">\n";
  }

  // A group that would add nothing is left out together with its end.
  void group(const SvgTag& tag) {
    if (!tag.closes) {
      std::string attributes;
      for (const SvgAttribute& one : tag.attributes) {
        const bool needed = one.name != "id" && one.name != "font-family" && !is_inherited(one);
        if (needed) attributes += attribute_text(one.name, one.value);
      }
      const std::size_t start = out_.size();
      if (!attributes.empty()) out_ += "<g" + attributes + ">";
      groups_.push_back({start, out_.size()});
      return;
    }
    if (groups_.empty()) throw std::runtime_error("gnuplot closed a group twice");
    const auto [start, content] = groups_.back();
    groups_.pop_back();
    if (out_.size() == content) {
      out_.resize(start);
    } else if (content > start) {
      out_ += "</g>\n";
    }
  }

  void text(const SvgTag& tag) {
    in_text_ = !tag.closes;
    out_ += tag.closes ? "</text>" : "<text>";
  }

  // Spans carry sub- and superscripts and bold type; others are left out.
  void span(const SvgTag& tag) {
    if (!tag.closes) {
      const std::string attributes =
          chosen_attributes(tag, {"font-size", "dy", "font-weight", "font-style", "fill"});
      spans_.push_back(!attributes.empty());
      if (spans_.back()) out_ += "<tspan" + attributes + ">";
      return;
    }
    if (spans_.empty()) throw std::runtime_error("gnuplot closed a span twice");
    if (spans_.back()) out_ += "</tspan>";
    spans_.pop_back();
  }

  void path(const SvgTag& tag) {
    const std::string data = short_coordinates(tag.value("d"));
    if (data.empty()) return;
    out_ +=
        "<path" + chosen_attributes(tag, {"stroke", "stroke-dasharray"}) + attribute_text("d", data) + "/>\n";
  }

  void polygon(const SvgTag& tag) {
    out_ += "<polygon" + chosen_attributes(tag, {"fill"});
    if (!tag.value("fill-opacity").empty()) {
      out_ +=
          fmt::format(" fill-opacity=\"{:.3g}\"", std::atof(std::string(tag.value("fill-opacity")).c_str()));
    }
    out_ += attribute_text("points", short_coordinates(tag.value("points"))) + "/>\n";
  }

  // The canvas is the only rectangle, and it is transparent.
  static void rectangle(const SvgTag& tag) {
    if (tag.value("fill") != "none") throw std::runtime_error("gnuplot wrote an unexpected rectangle");
  }

  std::string_view description_;
  std::string out_;
  SvgMarkerRun markers_;
  std::vector<std::pair<std::size_t, std::size_t>> groups_;  // where a group and its content start
  std::vector<bool> spans_;                                  // whether an open span was written
  int ignored_ = 0;                                          // depth of elements that are left out
  bool in_text_ = false;
  bool finished_ = false;
};

}  // namespace

std::string clean_svg(std::string_view raw, std::string_view description) {
  return SvgCleaner(description).clean(raw);
}

}  // namespace credence
