#include "reports/render/write_document.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "montecarlo/engine/result_store.h"
#include "reports/document/report_index.h"
#include "reports/figures/draw_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"

namespace credence::internal {
namespace {

/// One for each figure of the document; empty for those without panels.
std::vector<Drawing> draw_figures(const Document& document, const ReportFolder& directory) {
  std::vector<Figure> figures;
  std::vector<bool> shown;
  for (const DocumentPart& part : document.parts()) {
    const auto* drawn = std::get_if<part::DrawnFigure>(&part);
    if (drawn == nullptr) continue;
    Figure figure = drawn->make();
    shown.push_back(!figure.panels.empty());
    if (shown.back()) figures.push_back(std::move(figure));
  }
  std::vector<Drawing> drawn, all;
  if (!figures.empty()) drawn = draw_all(figures, directory);
  auto next = drawn.begin();
  for (const bool has_panels : shown) all.push_back(has_panels ? std::move(*next++) : Drawing{});
  return all;
}

/// Throws OutputError where a file would be replaced that is of no report: a page of others or, in a folder
/// without stored results, a file that no page leads to.
void require_own_files(const Document& document, const ReportFolder& directory) {
  const std::filesystem::path page = directory / "index.html";
  const auto refuse = [&](const std::filesystem::path& path) {
    const std::string command = command_of_page(page);
    throw OutputError(fmt::format(
        "{}: is there already and no file of {}, and would be replaced: name another --out, or move the file "
        "away",
        path.string(),
        command.empty() ? "a report" : fmt::format("the report in that folder, which is of `{}`", command)));
  };
  if (std::filesystem::is_regular_file(page) && !is_report_page(page)) refuse(page);
  if (ResultStore::exists(directory)) return;
  for (const DocumentFile& file : document.files) {
    const std::filesystem::path path = directory / file.name;
    if (std::filesystem::exists(path) && !leads_to(page, file.name)) refuse(path);
  }
}

}  // namespace

void write_document(const Document& document, const ReportFolder& directory, const Provenance& provenance) {
  make_directories(directory);
  require_own_files(document, directory);
  for (const char* folder : {".", "figures", "figures/panels"}) remove_abandoned(directory / folder);
  const std::vector<Drawing> drawings = draw_figures(document, directory);
  for (const DocumentFile& file : document.files) file.write(directory / file.name);
  write_file(directory / "index.html", html_page(document, drawings, provenance, directory));
}

}  // namespace credence::internal
