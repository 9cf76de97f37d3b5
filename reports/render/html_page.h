#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/document/glossary.h"
#include "reports/document/provenance.h"
#include "reports/document/report_table.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/figure.h"

/// @file
/// A report as one HTML file that needs nothing else: no files, no fonts, no network. Its one script makes
/// figures answer to the mouse and tables sort; without it everything can still be read and printed.

namespace credence {

/// Collects the parts of a page in order. Every text is literal and escaped; line breaks in it are spaces.
/// Words of the glossary link to their explanation, at the end of the page, where they are first used.
class HtmlPage {
 public:
  /// `subtitle` stands below the title: what was studied.
  explicit HtmlPage(std::string title, std::string subtitle = {});

  /// What the whole page comes to, in a sentence or two. Stands above everything else, and in the index of a
  /// folder of reports.
  void answer(CellTone tone, std::string_view text);
  /// Stands at the end of the page, with `more` behind it: the seed, the files read.
  void provenance(const Provenance& from, const std::vector<std::pair<std::string, std::string>>& more = {});

  /// Where a later section will be found: rows of a table can link to "#" + this.
  std::string reserve(std::string_view title);
  /// A heading that appears in the table of contents, at a reserved anchor or at one of its own.
  void section(std::string_view title, std::string anchor = {});
  /// A section that is folded up to its heading, a verdict in a word and a line about it, unless `open`.
  void folded_section(std::string_view title, const TableCell& word, std::string_view line, bool open,
                      const std::function<void()>& inside, std::string anchor = {});
  /// A heading within a section.
  void subsection(std::string_view title);
  /// What few readers need, folded under a heading within a section.
  void folded(std::string_view title, const std::function<void()>& inside);
  void paragraph(std::string_view text);
  void bullets(const std::vector<std::string>& items);
  /// A paragraph that must be noticed; the words say what the tone says.
  void callout(CellTone tone, std::string_view text);
  /// Names and values, such as the settings of a study.
  void facts(const std::vector<std::pair<std::string, std::string>>& names_and_values);
  /// Text with its line breaks kept, in a fixed-width font.
  void verbatim(std::string_view text);
  /// Numbered, with its title as caption; numbers align at their decimal points, tones colour the cells.
  void table(const ReportTable& table);
  /// With its caption, a letter that counts within the section (numbers are those of a paper's figures), and
  /// the anchor "figure-<name>". Links to the files of the drawing by their paths relative to `link_base`,
  /// the folder of the page.
  void figure(const Figure& figure, const Drawing& drawing, const std::filesystem::path& link_base = {});
  /// A paragraph whose words link to an address relative to the page or absolute (http, https).
  void link(std::string_view words, std::string_view address);

  /// The whole page.
  std::string str() const;
  /// Writes the page whole or not at all; OutputError names the path and the reason.
  void write(const std::filesystem::path& target) const;

 private:
  std::string unique_anchor(std::string_view title);
  std::string prose(std::string_view text);
  void enter_contents(std::string_view title, const std::string& anchor);
  std::string words_html() const;
  std::string head_html() const;

  std::string title_, subtitle_;
  std::string answer_, answer_html_;
  std::string contents_;  // entries of the table of contents
  std::string body_;
  std::vector<std::pair<std::string, std::string>> provenance_;
  Provenance from_;
  std::set<std::string> anchors_;
  std::vector<const GlossaryWord*> words_;  // used so far
  int sections_ = 0, tables_ = 0, figures_ = 0;
};

}  // namespace credence
