#include "reports/render/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "reports/render/atomic_file.h"
#include "reports/render/html_style.h"
#include "reports/render/html_text.h"

namespace credence {
namespace {

// Two spaces as wide as a digit and as a point keep right-aligned numbers in line.
constexpr const char* kFigureSpace = "\u2007";
constexpr const char* kPointSpace = "\u2008";

std::string_view class_of(CellTone tone) {
  switch (tone) {
    case CellTone::good:
      return "good";
    case CellTone::caution:
      return "caution";
    case CellTone::alarm:
      return "alarm";
    case CellTone::muted:
      return "muted";
    case CellTone::plain:
      break;
  }
  return "plain";
}

// The width a figure was drawn for: larger looks coarse, much smaller cannot be read.
double drawn_width(const std::string& svg) {
  const std::size_t box = svg.find("viewBox=\"0 0 ");
  return box == std::string::npos ? 0.0 : std::atof(svg.c_str() + box + 13);
}

bool is_web_or_relative(std::string_view address) {
  const std::size_t colon = address.find(':');
  const std::size_t slash = address.find('/');
  const bool relative = colon == std::string_view::npos || (slash != std::string_view::npos && slash < colon);
  return relative || address.starts_with("https://") || address.starts_with("http://");
}

// Percent-encodes what may not stand in a path of an address.
std::string encoded_path(const std::string& path) {
  constexpr std::string_view kPlain = "-._~/";
  std::string out;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte < 0x80 && std::isalnum(byte)) || kPlain.find(c) != std::string_view::npos;
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return out;
}

std::string cell_html(const ReportTable& table, std::size_t column, std::string_view text, CellTone tone) {
  const bool number = table.columns[column].align == ColumnAlign::numbers;
  std::string classes = number ? "number" : "";
  if (tone != CellTone::plain) {
    if (number) classes += ' ';
    classes += class_of(tone);
  }
  return fmt::format("<td{}>{}</td>", classes.empty() ? "" : fmt::format(" class=\"{}\"", classes),
                     escape_html(text));
}

}  // namespace

HtmlPage::HtmlPage(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

std::string HtmlPage::unique_anchor(std::string_view title) {
  std::string slug;
  for (const char c : title) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte)) {
      slug += static_cast<char>(std::tolower(byte));
    } else if (!slug.empty() && slug.back() != '-') {
      slug += '-';
    }
  }
  while (!slug.empty() && slug.back() == '-') slug.pop_back();
  if (slug.empty()) slug = "section";
  std::string anchor = slug;
  for (int i = 2; !anchors_.insert(anchor).second; ++i) anchor = fmt::format("{}-{}", slug, i);
  return anchor;
}

void HtmlPage::section(std::string_view title) {
  const std::string anchor = unique_anchor(title);
  const std::string words = escape_html(title);
  ++sections_;
  contents_ += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", anchor, words);
  body_ += fmt::format("<h2 id=\"{}\">{}</h2>\n", anchor, words);
}

void HtmlPage::subsection(std::string_view title) {
  body_ += fmt::format("<h3 id=\"{}\">{}</h3>\n", unique_anchor(title), escape_html(title));
}

void HtmlPage::paragraph(std::string_view text) { body_ += fmt::format("<p>{}</p>\n", escape_html(text)); }

void HtmlPage::bullets(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += fmt::format("<li>{}</li>\n", escape_html(item));
  body_ += "</ul>\n";
}

void HtmlPage::callout(CellTone tone, std::string_view text) {
  body_ += fmt::format("<p class=\"callout {}\">{}</p>\n", class_of(tone), escape_html(text));
}

void HtmlPage::facts(const std::vector<std::pair<std::string, std::string>>& names_and_values) {
  body_ += "<dl class=\"facts\">\n";
  for (const auto& [name, value] : names_and_values) {
    body_ += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape_html(name), escape_html(value));
  }
  body_ += "</dl>\n";
}

void HtmlPage::verbatim(std::string_view text) {
  body_ += "<pre>";
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    body_ += escape_html(text.substr(0, end)) + "\n";
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  body_ += "</pre>\n";
}

void HtmlPage::table(const ReportTable& table) {
  body_ += fmt::format("<div class=\"table\" id=\"table-{}\"><div class=\"scroll\"><table>\n", ++tables_);
  body_ +=
      fmt::format("<caption><b>Table {}.</b> {}</caption>\n<thead><tr>", tables_, escape_html(table.title));
  for (const TableColumn& column : table.columns) {
    body_ += fmt::format("<th scope=\"col\"{}>{}</th>",
                         column.align == ColumnAlign::numbers ? " class=\"number\"" : "",
                         escape_html(column.title));
  }
  body_ += "</tr></thead>\n<tbody>\n";
  std::vector<std::vector<std::string>> aligned(table.columns.size());
  for (std::size_t i = 0; i < aligned.size(); ++i) {
    if (table.columns[i].align == ColumnAlign::numbers) {
      aligned[i] = align_decimals(table, i, kFigureSpace, kPointSpace);
    }
  }
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    body_ += "<tr>";
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const TableCell& cell = table.rows[row][i];
      body_ += cell_html(table, i, aligned[i].empty() ? cell.text : aligned[i][row], cell.tone);
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
  for (const std::string& note : table.notes)
    body_ += fmt::format("<p class=\"notes\">{}</p>\n", escape_html(note));
  body_ += "</div>\n";
}

void HtmlPage::figure(const Figure& figure, const Drawing& drawing, const std::filesystem::path& link_base) {
  body_ += fmt::format("<figure id=\"{}\">\n", unique_anchor("figure-" + figure.name));
  const double width = drawn_width(drawing.svg);
  constexpr double kReadable = 0.75;
  body_ += fmt::format(
      "<div class=\"scroll\"><div style=\"max-width:{:.0f}px;min-width:{:.0f}px\">{}</div></div>\n", width,
      kReadable * width, drawing.svg);
  body_ += fmt::format("<figcaption><b>Figure {}.</b> {}", ++figures_, escape_html(figure.caption));
  for (const auto& [words, file] : {std::pair{"PDF", &drawing.pdf_file}, {"SVG", &drawing.svg_file}}) {
    if (file->empty()) continue;
    const auto relative = link_base.empty() ? file->filename() : file->lexically_relative(link_base);
    body_ +=
        fmt::format(" <a href=\"{}\">{}</a>", escape_html(encoded_path(relative.generic_string())), words);
  }
  body_ += "</figcaption>\n</figure>\n";
}

void HtmlPage::link(std::string_view words, std::string_view address) {
  // "javascript:" and its like are shown, not linked.
  if (!is_web_or_relative(address)) return paragraph(fmt::format("{} ({})", words, address));
  body_ += fmt::format("<p><a href=\"{}\">{}</a></p>\n", escape_html(address), escape_html(words));
}

std::string HtmlPage::str() const {
  const std::string title = escape_html(title_);
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  page += fmt::format("<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n", title, kPageStyle);
  page += fmt::format("<h1>{}</h1>\n", title);
  if (!subtitle_.empty()) page += fmt::format("<p class=\"subtitle\">{}</p>\n", escape_html(subtitle_));
  if (sections_ > 1) page += fmt::format("<nav aria-label=\"Contents\"><ol>\n{}</ol></nav>\n", contents_);
  return page + body_ + "</main>\n</body>\n</html>\n";
}

void HtmlPage::write(const std::filesystem::path& target) const { write_file(target, str()); }

}  // namespace credence
