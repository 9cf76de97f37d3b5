#include "reports/render/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>
#include <vector>

#include "core/append_item.h"
#include "reports/document/glossary.h"
#include "reports/render/html_script.h"
#include "reports/render/html_style.h"
#include "reports/render/html_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

// Two spaces as wide as a digit and as a point keep right-aligned numbers in line.
constexpr const char* kFigureSpace = "\u2007";
constexpr const char* kPointSpace = "\u2008";

std::string_view class_of(CellTone tone) {
  switch (tone) {
    case CellTone::good: return "good";
    case CellTone::caution: return "caution";
    case CellTone::alarm: return "alarm";
    case CellTone::muted: return "muted";
    case CellTone::plain: break;
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
  // "1.02 (0.98 … 1.06)", "4.495 of 3.000 (optimistic)": what is in brackets goes below its number where the
  // table would be too wide.
  const std::size_t bracket = words.find(" (");
  const bool one_word = words.find(' ') == bracket,
             of_number = !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) != 0;
  if (!number && bracket != std::string::npos && words.back() == ')' && (one_word || of_number)) {
    const std::string before = words.substr(0, bracket);
    words = fmt::format("{} <span class=\"interval\">{}</span>",
                        one_word ? before : fmt::format("<span class=\"interval\">{}</span>", before),
                        words.substr(bracket + 1));
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
  for (const char c : word.word)
    anchor += c == ' ' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return anchor;
}

std::string facts_html(const std::vector<std::pair<std::string, std::string>>& names_and_values) {
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [name, value] : names_and_values) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape_html(name), escape_html(value));
  }
  return html + "</dl>\n";
}

/// Writes the parts of a document one after the other.
class PageWriter {
 public:
  PageWriter(std::span<const Drawing> drawings, const std::filesystem::path& link_base)
      : drawings_(drawings), link_base_(link_base) {}

  void operator()(const part::Heading& heading) {
    enter_contents(heading);
    body += fmt::format("<h2 id=\"{}\">{}</h2>\n", heading.anchor, escape_html(heading.title));
  }
  void operator()(const part::Fold& fold);
  void operator()(part::FoldEnd) {
    body += "</details>\n";
    if (outside_.back()) figures_ = *outside_.back();
    outside_.pop_back();
  }
  void operator()(const part::Paragraph& p) { body += fmt::format("<p>{}</p>\n", prose(p.text)); }
  void operator()(const part::Bullets& bullets) {
    body += "<ul>\n";
    for (const std::string& item : bullets.items) body += fmt::format("<li>{}</li>\n", prose(item));
    body += "</ul>\n";
  }
  void operator()(const part::Callout& callout) {
    body += fmt::format("<p class=\"callout {}\">{}</p>\n", class_of(callout.tone), prose(callout.text));
  }
  void operator()(const part::Facts& facts) { body += facts_html(facts.names_and_values); }
  void operator()(const part::Verbatim& verbatim);
  void operator()(const part::Link& link);
  void operator()(const part::DrawnFigure& drawn);
  void operator()(const ReportTable& table);

  /// Escaped, with words of the glossary linked where they are first used.
  std::string prose(std::string_view text);
  /// The words that the page uses, in the order of the alphabet.
  std::string words() const;

  std::string contents;  ///< entries of the table of contents
  std::string body;
  int sections = 0;

 private:
  void enter_contents(const part::Heading& heading) {
    ++sections;
    contents += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", heading.anchor, heading_html(heading.title));
  }

  std::span<const Drawing> drawings_;  // of figures still to come
  const std::filesystem::path& link_base_;
  std::vector<const GlossaryWord*> words_;  // used so far
  int tables_ = 0, figures_ = 0;
  std::vector<std::optional<int>> outside_;  ///< of each open fold that is a section, the figures before it
};

std::string PageWriter::prose(std::string_view text) {
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

void PageWriter::operator()(const part::Fold& fold) {
  const part::Heading& heading = fold.heading;
  outside_.push_back(fold.section ? std::optional(std::exchange(figures_, 0)) : std::nullopt);
  if (!fold.section) {
    body += fmt::format("<details id=\"{}\">\n<summary><h3>{}</h3></summary>\n", heading.anchor,
                        escape_html(heading.title));
    return;
  }
  enter_contents(heading);
  body += fmt::format("<details class=\"section\" id=\"{}\"{}>\n<summary><h2>{}</h2>", heading.anchor,
                      fold.open ? " open=\"\"" : "", escape_html(heading.title));
  if (!fold.word.text.empty()) {
    body += fmt::format(" <span class=\"teaser {}\">{}</span>", class_of(fold.word.tone),
                        escape_html(fold.word.text));
  }
  if (!fold.line.empty()) body += fmt::format(" <span class=\"line\">{}</span>", escape_html(fold.line));
  body += "</summary>\n";
}

void PageWriter::operator()(const part::Verbatim& verbatim) {
  std::string_view text = verbatim.text;
  body += "<pre tabindex=\"0\">";  // may scroll on a phone
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    body += escape_html(text.substr(0, end)) + "\n";
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  body += "</pre>\n";
}

void PageWriter::operator()(const ReportTable& table) {
  const auto add_notes = [&] {
    for (const std::string& note : table.notes) {
      body += fmt::format("<p class=\"notes\">{}</p>\n", prose(note));
    }
  };
  if (table.columns.empty()) return add_notes();
  body += fmt::format("<div class=\"table\" id=\"table-{}\">", ++tables_);
  // The caption does not scroll away; what scrolls must be reached by the keyboard.
  body += fmt::format("<p class=\"caption\" id=\"caption-{0}\"><b>Table {0}.</b> {1}</p>\n", tables_,
                      prose(table.title));
  body += fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-labelledby=\"caption-{}\"><table>\n<thead><tr>",
      tables_);
  for (const TableColumn& column : table.columns) {
    body += fmt::format("<{0}{1}>{2}</{3}>", column.title.empty() ? "td" : "th scope=\"col\"",
                        column.align == ColumnAlign::numbers ? " class=\"number\"" : "",
                        heading_html(column.title), column.title.empty() ? "td" : "th");
  }
  body += "</tr></thead>\n<tbody>\n";
  std::vector<std::vector<std::string>> aligned(table.columns.size());
  for (std::size_t i = 0; i < aligned.size(); ++i) {
    if (table.columns[i].align == ColumnAlign::numbers) {
      aligned[i] = align_decimals(table, i, kFigureSpace, kPointSpace);
    }
  }
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    body += "<tr>";
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const TableCell& cell = table.rows[row][i];
      body += cell_html(table, i, cell, aligned[i].empty() ? cell.text : aligned[i][row]);
    }
    body += "</tr>\n";
  }
  body += "</tbody></table></div>\n";
  add_notes();
  body += "</div>\n";
}

void PageWriter::operator()(const part::DrawnFigure& drawn) {
  const Drawing& drawing = drawings_.front();
  drawings_ = drawings_.subspan(1);
  if (drawing.svg.empty()) return;
  body += fmt::format("<figure id=\"{}\">\n", drawn.anchor);
  if (drawing.panels.empty()) {
    const double width = drawn_width(drawing.svg);
    constexpr double kReadable = 0.75;
    body += fmt::format(
        "<div class=\"scroll\"><div style=\"max-width:{:.0f}px;min-width:{:.0f}px\">{}</div></div>\n", width,
        kReadable * width, drawing.svg);
  } else {
    std::string columns;
    double width = 0.0;
    for (const double w : drawing.column_widths) {
      append_item(columns, fmt::format("{:.0f}fr", w), " ");
      width += w;
    }
    body += fmt::format("<div class=\"panels\" style=\"--columns:{};max-width:{:.0f}px\">\n", columns, width);
    for (const PanelDrawing& panel : drawing.panels) {
      body += fmt::format("<div class=\"panel\">{}<script type=\"application/json\">{}</script></div>\n",
                          panel.svg, panel.data);
    }
    body += "</div>\n";
  }
  body += fmt::format("<figcaption><b>Figure {}.</b> {}", letters_of(++figures_), prose(drawing.caption));
  for (const std::filesystem::path& file : drawing.files) {
    const auto relative = link_base_.empty() ? file.filename() : file.lexically_relative(link_base_);
    std::string format = file.extension().string().substr(1);
    for (char& letter : format) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    body +=
        fmt::format(" <a href=\"{}\">{}</a>", escape_html(encoded_path(relative.generic_string())), format);
  }
  body += "</figcaption>\n</figure>\n";
}

void PageWriter::operator()(const part::Link& link) {
  // "javascript:" and its like are shown, not linked.
  if (!is_web_or_relative(link.address)) {
    return (*this)(part::Paragraph{fmt::format("{} ({})", link.words, link.address)});
  }
  body += fmt::format("<p><a href=\"{}\">{}</a></p>\n", escape_html(link.address), escape_html(link.words));
}

std::string PageWriter::words() const {
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

std::string answer_text(const Document& document) {
  return document.answer.text.empty() ? "" : document.answer.text + ".";
}

std::string head_html(const Document& document, const Provenance& from) {
  std::string head = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  head += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  head += "<meta name=\"color-scheme\" content=\"light dark\">\n";
  const auto say = [&](const char* name, const std::string& content) {
    if (!content.empty())
      head += fmt::format("<meta name=\"{}\" content=\"{}\">\n", name, escape_html(content));
  };
  say("generator", from.version.empty() ? "Credence" : "Credence " + from.version);
  say("credence-answer", answer_text(document));
  say("credence-date", from.date);
  say("credence-command", from.command);
  for (const auto& [name, text] : document.descriptions)
    say(("credence-description " + escape_html(name)).c_str(), text);
  head += fmt::format("<title>{}</title>\n<style>{}</style>\n<script>{}</script>\n</head>\n",
                      escape_html(document.title), kPageStyle, kPageScript);
  return head;
}

}  // namespace

std::string html_page(const Document& document, std::span<const Drawing> drawings, const Provenance& from,
                      const std::filesystem::path& link_base) {
  PageWriter writer(drawings, link_base);
  std::string answer;
  if (!document.answer.text.empty()) {
    answer = fmt::format("<p class=\"callout answer {}\" id=\"answer\">{}</p>\n",
                         class_of(document.answer.tone), writer.prose(answer_text(document)));
  }
  for (const DocumentPart& part : document.parts()) std::visit(writer, part);
  const std::string words = writer.words();
  if (!words.empty()) writer.contents += "<li><a href=\"#words\">Words</a></li>\n";
  std::string page = head_html(document, from) + "<body>\n<a class=\"skip\" href=\"#main\">To the text</a>\n";
  if (writer.sections > 1)
    page += fmt::format("<nav aria-label=\"Contents\"><ol>\n{}</ol></nav>\n", writer.contents);
  page += fmt::format("<main id=\"main\">\n<h1>{}</h1>\n", escape_html(document.title));
  if (!document.subtitle.empty())
    page += fmt::format("<p class=\"subtitle\">{}</p>\n", escape_html(document.subtitle));
  page += answer + writer.body + words;
  std::vector<std::pair<std::string, std::string>> facts = provenance_facts(from);
  facts.insert(facts.end(), document.sources.begin(), document.sources.end());
  if (!facts.empty()) page += "<footer>\n" + facts_html(facts) + "</footer>\n";
  return page + "</main>\n</body>\n</html>\n";
}

}  // namespace credence::internal
