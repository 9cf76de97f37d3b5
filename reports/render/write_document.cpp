#include "reports/render/write_document.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string>
#include <vector>

#include "montecarlo/engine/result_store.h"
#include "reports/document/report_index.h"
#include "reports/figures/draw_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"

namespace credence::internal {
namespace {

/// The turn of this process to write a report into a folder: files of two would be mixed. Where a file system
/// has no locks there is none.
class WritersTurn {
 public:
  explicit WritersTurn(const std::filesystem::path& folder)
      : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0) return;
    while (flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) continue;
  }
  ~WritersTurn() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  WritersTurn(const WritersTurn&) = delete;
  WritersTurn& operator=(const WritersTurn&) = delete;

 private:
  int descriptor_;
};

/// One for each figure of the document; empty for those without data.
std::vector<Drawing> draw_figures(const Document& document, const ReportFolder& directory) {
  std::vector<Figure> figures;
  std::vector<bool> shown;
  for (const DocumentPart& part : document.parts()) {
    const auto* drawn = std::get_if<part::DrawnFigure>(&part);
    if (drawn == nullptr) continue;
    Figure figure = drawn->make();
    shown.push_back(has_data(figure));
    if (shown.back()) figures.push_back(std::move(figure));
  }
  std::vector<Drawing> drawn, all;
  if (!figures.empty()) drawn = draw_all(figures, directory);
  auto next = drawn.begin();
  for (const bool is_drawn : shown) all.push_back(is_drawn ? std::move(*next++) : Drawing{});
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
  if (is_page_of_others(page)) refuse(page);
  if (ResultStore::exists(directory)) return;
  for (const DocumentFile& file : document.files) {
    const std::filesystem::path path = directory / file.name;
    if (std::filesystem::exists(path) && !leads_to(page, file.name)) refuse(path);
  }
}

/// With links to what earlier reports have left in the folder, so that these stay files of a report: whoever
/// writes them next may replace them.
Document with_earlier_files(Document document, const std::filesystem::path& page) {
  bool any = false;
  for (const std::string& name : files_of_page(page)) {
    if (std::ranges::find(document.files, name, &DocumentFile::name) != document.files.end()) continue;
    if (!any) document.section("Left by earlier reports in this folder");
    any = true;
    document.link(name, name);
  }
  return document;
}

}  // namespace

void write_document(const Document& document, const ReportFolder& directory, const Provenance& provenance) {
  make_directories(directory);
  const WritersTurn turn(directory);
  require_own_files(document, directory);
  for (const char* folder : {".", "figures", "figures/panels"}) remove_abandoned(directory / folder);
  const std::vector<Drawing> drawings = draw_figures(document, directory);
  const std::filesystem::path target = directory / "index.html";
  const std::string page = html_page(with_earlier_files(document, target), drawings, provenance, directory);
  // The page last, so that an old one stays where a file cannot be written. But first where it does not lead
  // to all files yet: after a kill, or on a full disk, those that are there would be no files of a report,
  // and never replaced.
  const bool leads = std::ranges::all_of(
      document.files, [&](const DocumentFile& file) { return leads_to(target, file.name); });
  if (!leads) write_file(target, page);
  for (const DocumentFile& file : document.files) file.write(directory / file.name);
  if (leads) write_file(target, page);
}

}  // namespace credence::internal
