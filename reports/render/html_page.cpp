#include "reports/render/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "reports/render/atomic_file.h"
#include "reports/render/html_script.h"
#include "reports/render/html_style.h"
#include "reports/render/html_text.h"
#include "reports/render/utf8_text.h"

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

// Names of settings are long and have no blanks: they may break behind a point.
std::string heading_html(std::string_view title) {
  std::string html;
  for (const char c : escape_html(title)) {
    html += c;
    if (c == '.' || c == '_') html += "<wbr/>";
  }
  return html;
}

std::string cell_html(const ReportTable& table, std::size_t column, const TableCell& cell,
                      std::string_view text) {
  const bool number = table.columns[column].align == ColumnAlign::numbers;
  std::string classes = number ? "number" : "";
  if (cell.tone != CellTone::plain) {
    if (number) classes += ' ';
    classes += class_of(cell.tone);
  }
  constexpr std::size_t kShort = 32;  // columns of text that a cell need not break
  if (display_width(text) > kShort) classes += classes.empty() ? "long" : " long";
  std::string words = escape_html(text);
  // "1.02 (0.98 … 1.06)": the interval goes below its number where the table would be too wide.
  const std::size_t interval = words.find(" (");
  if (!number && interval != std::string::npos && words.back() == ')' && words.find(' ') == interval) {
    words = fmt::format("{}<span class=\"interval\">{}</span>", words.substr(0, interval + 1),
                        words.substr(interval + 1));
    classes += classes.empty() ? "with-interval" : " with-interval";
  }
  const bool linked = !cell.link.empty() && is_web_or_relative(cell.link);
  return fmt::format("<td{}>{}</td>", classes.empty() ? "" : fmt::format(" class=\"{}\"", classes),
                     linked ? fmt::format("<a href=\"{}\">{}</a>", escape_html(cell.link), words) : words);
}

// A, B, … Z, AA, …
std::string letters_of(int number) {
  std::string letters;
  for (; number > 0; number = (number - 1) / 26) {
    letters.insert(letters.begin(), static_cast<char>('A' + (number - 1) % 26));
  }
  return letters;
}

std::string anchor_of(const GlossaryWord& word) {
  std::string anchor = "word-";
  for (const char c : word.word) anchor += c == ' ' ? '-' : static_cast<char>(std::tolower(c));
  return anchor;
}

std::string facts_html(const std::vector<std::pair<std::string, std::string>>& names_and_values) {
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [name, value] : names_and_values) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape_html(name), escape_html(value));
  }
  return html + "</dl>\n";
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

std::string HtmlPage::prose(std::string_view text) {
  std::string html;
  std::size_t done = 0;
  for (const GlossaryUse& use : glossary_uses(text)) {
    if (std::ranges::find(words_, use.word) != words_.end()) continue;
    words_.push_back(use.word);
    html += escape_html(text.substr(done, use.begin - done));
    html += fmt::format("<a class=\"word\" href=\"#{}\" title=\"{}\">{}</a>", anchor_of(*use.word),
                        escape_html(use.word->short_form), escape_html(use.word->word));
    done = use.begin + use.length;
  }
  return html + escape_html(text.substr(done));
}

void HtmlPage::enter_contents(std::string_view title, const std::string& anchor) {
  ++sections_;
  figures_ = 0;
  contents_ += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", anchor, heading_html(title));
}

void HtmlPage::answer(CellTone tone, std::string_view text) {
  answer_ = text;
  answer_html_ =
      fmt::format("<p class=\"callout answer {}\" id=\"answer\">{}</p>\n", class_of(tone), prose(text));
}

void HtmlPage::provenance(const Provenance& from,
                          const std::vector<std::pair<std::string, std::string>>& more) {
  from_ = from;
  provenance_ = provenance_facts(from);
  provenance_.insert(provenance_.end(), more.begin(), more.end());
}

std::string HtmlPage::reserve(std::string_view title) { return unique_anchor(title); }

void HtmlPage::section(std::string_view title, std::string anchor) {
  if (anchor.empty()) anchor = unique_anchor(title);
  enter_contents(title, anchor);
  body_ += fmt::format("<h2 id=\"{}\">{}</h2>\n", anchor, escape_html(title));
}

void HtmlPage::folded_section(std::string_view title, const TableCell& word, std::string_view line, bool open,
                              const std::function<void()>& inside, std::string anchor) {
  if (anchor.empty()) anchor = unique_anchor(title);
  enter_contents(title, anchor);
  body_ += fmt::format("<details class=\"section\" id=\"{}\"{}>\n<summary><h2>{}</h2>", anchor,
                       open ? " open=\"\"" : "", escape_html(title));
  if (!word.text.empty()) {
    body_ += fmt::format(" <span class=\"teaser {}\">{}</span>", class_of(word.tone), escape_html(word.text));
  }
  if (!line.empty()) body_ += fmt::format(" <span class=\"line\">{}</span>", escape_html(line));
  body_ += "</summary>\n";
  inside();
  body_ += "</details>\n";
}

void HtmlPage::folded(std::string_view title, const std::function<void()>& inside) {
  body_ += fmt::format("<details id=\"{}\">\n<summary><h3>{}</h3></summary>\n", unique_anchor(title),
                       escape_html(title));
  inside();
  body_ += "</details>\n";
}

void HtmlPage::subsection(std::string_view title) {
  body_ += fmt::format("<h3 id=\"{}\">{}</h3>\n", unique_anchor(title), escape_html(title));
}

void HtmlPage::paragraph(std::string_view text) { body_ += fmt::format("<p>{}</p>\n", prose(text)); }

void HtmlPage::bullets(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += fmt::format("<li>{}</li>\n", prose(item));
  body_ += "</ul>\n";
}

void HtmlPage::callout(CellTone tone, std::string_view text) {
  body_ += fmt::format("<p class=\"callout {}\">{}</p>\n", class_of(tone), prose(text));
}

void HtmlPage::facts(const std::vector<std::pair<std::string, std::string>>& names_and_values) {
  body_ += facts_html(names_and_values);
}

void HtmlPage::verbatim(std::string_view text) {
  body_ += "<pre tabindex=\"0\">";  // may scroll on a phone
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    body_ += escape_html(text.substr(0, end)) + "\n";
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  body_ += "</pre>\n";
}

void HtmlPage::table(const ReportTable& table) {
  body_ += fmt::format("<div class=\"table\" id=\"table-{}\">", ++tables_);
  // The caption does not scroll away; what scrolls must be reached by the keyboard.
  body_ += fmt::format("<p class=\"caption\" id=\"caption-{0}\"><b>Table {0}.</b> {1}</p>\n", tables_,
                       prose(table.title));
  body_ += fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-labelledby=\"caption-{}\"><table>\n<thead><tr>",
      tables_);
  for (const TableColumn& column : table.columns) {
    body_ += fmt::format("<{0}{1}>{2}</{3}>", column.title.empty() ? "td" : "th scope=\"col\"",
                         column.align == ColumnAlign::numbers ? " class=\"number\"" : "",
                         heading_html(column.title), column.title.empty() ? "td" : "th");
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
      body_ += cell_html(table, i, cell, aligned[i].empty() ? cell.text : aligned[i][row]);
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
  for (const std::string& note : table.notes)
    body_ += fmt::format("<p class=\"notes\">{}</p>\n", prose(note));
  body_ += "</div>\n";
}

void HtmlPage::figure(const Figure& figure, const Drawing& drawing, const std::filesystem::path& link_base) {
  body_ += fmt::format("<figure id=\"{}\">\n", unique_anchor("figure-" + figure.name));
  if (drawing.panels.empty()) {
    const double width = drawn_width(drawing.svg);
    constexpr double kReadable = 0.75;
    body_ += fmt::format(
        "<div class=\"scroll\"><div style=\"max-width:{:.0f}px;min-width:{:.0f}px\">{}</div></div>\n", width,
        kReadable * width, drawing.svg);
  } else {
    std::string columns;
    double width = 0.0;
    for (const double w : drawing.column_widths) {
      columns += fmt::format("{}{:.0f}fr", columns.empty() ? "" : " ", w);
      width += w;
    }
    body_ +=
        fmt::format("<div class=\"panels\" style=\"--columns:{};max-width:{:.0f}px\">\n", columns, width);
    for (const PanelDrawing& panel : drawing.panels) {
      body_ += fmt::format("<div class=\"panel\">{}<script type=\"application/json\">{}</script></div>\n",
                           panel.svg, panel.data);
    }
    body_ += "</div>\n";
  }
  body_ += fmt::format("<figcaption><b>Figure {}.</b> {}", letters_of(++figures_), prose(figure.caption));
  for (const std::filesystem::path& file : drawing.files) {
    const auto relative = link_base.empty() ? file.filename() : file.lexically_relative(link_base);
    std::string format = file.extension().string().substr(1);
    for (char& letter : format) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    body_ +=
        fmt::format(" <a href=\"{}\">{}</a>", escape_html(encoded_path(relative.generic_string())), format);
  }
  body_ += "</figcaption>\n</figure>\n";
}

void HtmlPage::link(std::string_view words, std::string_view address) {
  // "javascript:" and its like are shown, not linked.
  if (!is_web_or_relative(address)) return paragraph(fmt::format("{} ({})", words, address));
  body_ += fmt::format("<p><a href=\"{}\">{}</a></p>\n", escape_html(address), escape_html(words));
}

// The words that the page uses, in the order of the alphabet.
std::string HtmlPage::words_html() const {
  if (words_.empty()) return {};
  std::string html =
      "<details class=\"section\" id=\"words\">\n<summary><h2>Words</h2> <span class=\"line\">what NEES "
      "and its like mean</span></summary>\n<dl class=\"glossary\">\n";
  for (const GlossaryWord& entry : glossary()) {
    if (std::ranges::find(words_, &entry) == words_.end()) continue;
    html += fmt::format("<dt id=\"{}\">{}</dt><dd>{}. {}</dd>\n", anchor_of(entry), escape_html(entry.word),
                        escape_html(entry.short_form), escape_html(entry.says));
  }
  return html + "</dl>\n</details>\n";
}

std::string HtmlPage::head_html() const {
  std::string head = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  head += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  head += "<meta name=\"color-scheme\" content=\"light dark\">\n";
  const auto say = [&](const char* name, const std::string& content) {
    if (!content.empty())
      head += fmt::format("<meta name=\"{}\" content=\"{}\">\n", name, escape_html(content));
  };
  say("generator", from_.version.empty() ? "Credence" : "Credence " + from_.version);
  say("credence-answer", answer_);
  say("credence-date", from_.date);
  say("credence-command", from_.command);
  head += fmt::format("<title>{}</title>\n<style>{}</style>\n<script>{}</script>\n</head>\n",
                      escape_html(title_), kPageStyle, kPageScript);
  return head;
}

std::string HtmlPage::str() const {
  std::string contents = contents_;
  if (!words_.empty()) contents += "<li><a href=\"#words\">Words</a></li>\n";
  std::string page = head_html() + "<body>\n<a class=\"skip\" href=\"#main\">To the text</a>\n";
  if (sections_ > 1) page += fmt::format("<nav aria-label=\"Contents\"><ol>\n{}</ol></nav>\n", contents);
  page += fmt::format("<main id=\"main\">\n<h1>{}</h1>\n", escape_html(title_));
  if (!subtitle_.empty()) page += fmt::format("<p class=\"subtitle\">{}</p>\n", escape_html(subtitle_));
  page += answer_html_ + body_ + words_html();
  if (!provenance_.empty()) page += "<footer>\n" + facts_html(provenance_) + "</footer>\n";
  return page + "</main>\n</body>\n</html>\n";
}

void HtmlPage::write(const std::filesystem::path& target) const { write_file(target, str()); }

}  // namespace credence
