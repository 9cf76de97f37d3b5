#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/document/report_table.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/figure.h"

/// @file
/// A report as one HTML file that needs nothing else: no scripts, no fonts, no network.

namespace credence {

/// Collects the parts of a page in order. Every text is literal and escaped; line breaks in it are spaces.
class HtmlPage {
 public:
  /// `subtitle` stands below the title: what was studied, when, by which version.
  explicit HtmlPage(std::string title, std::string subtitle = {});

  /// A heading that appears in the table of contents.
  void section(std::string_view title);
  /// A heading within a section.
  void subsection(std::string_view title);
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
  /// Numbered, with its caption and the anchor "figure-<name>". Links to the files of the drawing by their
  /// paths relative to `link_base`, the folder of the page.
  void figure(const Figure& figure, const Drawing& drawing, const std::filesystem::path& link_base = {});
  /// A paragraph whose words link to an address relative to the page or absolute (http, https).
  void link(std::string_view words, std::string_view address);

  /// The whole page.
  std::string str() const;
  /// Writes the page whole or not at all; OutputError names the path and the reason.
  void write(const std::filesystem::path& target) const;

 private:
  std::string unique_anchor(std::string_view title);

  std::string title_, subtitle_;
  std::string contents_;  // entries of the table of contents
  std::string body_;
  std::set<std::string> anchors_;
  int sections_ = 0, tables_ = 0, figures_ = 0;
};

}  // namespace credence
