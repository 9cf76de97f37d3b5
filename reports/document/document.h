#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "reports/document/report_table.h"
#include "reports/figures/figure.h"

/// @file
/// What a command has to say, once. It is shown on a terminal (text_page.h), printed as JSON, and written as
/// a page with its figures and the files beside it (write_document.h).

namespace credence::internal {

/// Parts of a page.
namespace part {
/// Of a section.
struct Heading {
  std::string title, anchor;
};
/// A fold up to its heading, until the next FoldEnd: a section with a verdict in a word and a line about it,
/// or, with neither, what few readers need within one.
struct Fold {
  Heading heading;
  TableCell word;
  std::string line;
  bool open = false, section = true;
};
struct FoldEnd {};
struct Paragraph {
  std::string text;
};
struct Bullets {
  std::vector<std::string> items;
};
struct Callout {
  CellTone tone;
  std::string text;
};
struct Facts {
  std::vector<std::pair<std::string, std::string>> names_and_values;
};
struct Verbatim {
  std::string text;
};
struct Link {
  std::string words, address;
};
struct DrawnFigure {
  std::string anchor;
  std::function<Figure()> make;
};
}  // namespace part

using DocumentPart =
    std::variant<part::Heading, part::Fold, part::FoldEnd, part::Paragraph, part::Bullets, part::Callout,
                 part::Facts, part::Verbatim, part::Link, part::DrawnFigure, ReportTable>;

/// A file beside the page, such as a table as CSV.
struct DocumentFile {
  std::string name;
  std::function<void(const std::filesystem::path& target)> write;  ///< whole or not at all; OutputError
};

/// The parts in their order. Every text is literal; renderers escape it.
class Document {
 public:
  /// `studied` stands below the title.
  explicit Document(std::string heading = {}, std::string studied = {})
      : title(std::move(heading)), subtitle(std::move(studied)) {}

  std::string title, subtitle;
  /// What all of it comes to, in a sentence or two; stands above everything else on the page, and in the
  /// index of a folder of reports.
  ReportAnswer answer;
  /// A line or a table of what a terminal shows, in this order.
  std::vector<std::variant<std::string, ReportTable>> brief;
  /// The same as data; made when it is asked for, as often as that is.
  std::function<std::string()> json;
  std::vector<DocumentFile> files;
  /// What stands at the end of the page behind its provenance: the seed, the files read.
  std::vector<std::pair<std::string, std::string>> sources;
  /// What the authors of scenarios say, by name: in the head of the page too, for who makes it again of what
  /// is stored (description_of_page).
  std::vector<std::pair<std::string, std::string>> descriptions;

  /// The answer as a line of its own on a terminal.
  void show_answer();
  /// All lines on a terminal.
  void show(const std::vector<std::string>& lines);
  /// The tables on a terminal, each with a blank line below.
  void show_apart(const std::vector<ReportTable>& tables);

  /// Where a later section will be found: rows of a table can link to "#" + this.
  std::string reserve(std::string_view heading);
  /// A heading that appears in the table of contents, at a reserved anchor or at one of its own.
  void section(std::string_view heading, std::string anchor = {});
  /// A section that is folded up to its heading, a verdict in a word and a line about it, unless `open`.
  void folded_section(std::string_view heading, const TableCell& word, std::string_view line, bool open,
                      const std::function<void()>& inside, std::string anchor = {});
  /// What few readers need, folded under a heading within a section.
  void folded(std::string_view heading, const std::function<void()>& inside);
  void paragraph(std::string_view text);
  /// Nothing where there are none.
  void bullets(std::vector<std::string> items);
  /// A paragraph that must be noticed; the words say what the tone says.
  void callout(CellTone tone, std::string_view text);
  /// Names and values, such as the settings of a study.
  void facts(std::vector<std::pair<std::string, std::string>> names_and_values);
  /// Text with its line breaks kept, in a fixed-width font.
  void verbatim(std::string_view text);
  /// Numbered, with its title as caption; numbers align at their decimal points, tones colour the cells.
  void table(ReportTable table);
  /// With its caption, a letter that counts within the section (numbers are those of a paper's figures), and
  /// the anchor "figure-<name>". Nothing of a figure without panels, or without data in any of them.
  void figure(Figure figure);
  void figures(std::vector<Figure> figures);
  /// One that takes time, made when the page is.
  void figure(std::string_view name, std::function<Figure()> make);
  /// A paragraph whose words link to an address relative to the page or absolute (http, https).
  void link(std::string_view words, std::string_view address);
  /// A file beside the page.
  void file(std::string name, std::function<void(const std::filesystem::path&)> write);

  const std::vector<DocumentPart>& parts() const { return parts_; }

 private:
  std::vector<DocumentPart> parts_;
  std::set<std::string> anchors_;
};

/// A name as a file's: its letters, digits and '-', anything else as '_'; `otherwise` for an empty one. Where
/// it has letters beyond ASCII a hash of it follows.
std::string plain_name(std::string_view name, const char* otherwise);

}  // namespace credence::internal
