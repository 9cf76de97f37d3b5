#pragma once

#include <concepts>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

/// @file
/// What the files beside a page are written as, so that a figure stands in a paper as it is.

namespace credence::internal {

/// Formats, width and lettering of the figures that are written into files.
struct PaperStyle {
  /// A column of a paper in two columns is 3.5 in wide, its text 7.16 in. `by_figure`: as many as its panels.
  enum class Width { by_figure, one_column, two_columns };

  bool svg = true, pdf = true, png = false, pgf = false;
  Width width = Width::by_figure;
  bool serif = false;  ///< of PDF and PNG: Times, or what stands in for it; pgf takes the paper's own letters
};

/// The words of `paper_style`: "svg", "pdf", "png", "pgf", "one-column", "two-columns", "serif".
std::span<const std::string_view> paper_words();

/// The style that words name: where formats are among them, these instead of SVG and PDF. Throws
/// std::invalid_argument for a word that is not among paper_words, and for two widths.
PaperStyle paper_style(std::span<const std::string> words);

/// Where a report is written, and how its figures are.
struct ReportFolder {
  /// From anything that names a folder.
  template <class Path>
  requires std::convertible_to<Path, std::filesystem::path> &&
      (!std::same_as<std::remove_cvref_t<Path>, ReportFolder>)
          ReportFolder(Path&& folder, PaperStyle style = {})  // NOLINT: most callers name a folder only
      : path(std::forward<Path>(folder)), paper(style) {}
  operator const std::filesystem::path&() const { return path; }  // NOLINT
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path / name; }

  std::filesystem::path path;
  PaperStyle paper;
};

}  // namespace credence::internal
