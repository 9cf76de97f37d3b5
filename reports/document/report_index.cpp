#include "reports/document/report_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/append_item.h"
#include "reports/document/document.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/html_text.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIndexName = "reports.html";

/// What escape_html made of a text, undone.
std::string unescaped(std::string_view html) {
  static constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&#39;", '\''}, {"&amp;", '&'}}};
  std::string text;
  while (!html.empty()) {
    const auto* const entity =
        std::ranges::find_if(kEntities, [&](const auto& e) { return html.starts_with(e.first); });
    text += entity == kEntities.end() ? html.front() : entity->second;
    html.remove_prefix(entity == kEntities.end() ? 1 : entity->first.size());
  }
  return text;
}

/// What stands between two marks; empty where they do not.
std::string between(std::string_view text, std::string_view open, std::string_view close) {
  const std::size_t begin = text.find(open);
  if (begin == std::string_view::npos) return {};
  text.remove_prefix(begin + open.size());
  const std::size_t end = text.find(close);
  return end == std::string_view::npos ? std::string() : unescaped(text.substr(0, end));
}

std::string head_of(const fs::path& page) {
  constexpr std::size_t kHead = 1 << 16;  // names and title come first
  std::string head(kHead, '\0');
  std::ifstream in(page, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(kHead));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return head;
}

std::string said(std::string_view head, std::string_view name) {
  return between(head, fmt::format("<meta name=\"{}\" content=\"", name), "\">");
}

bool is_of_credence(std::string_view head) { return said(head, "generator").starts_with("Credence"); }

/// All of it; empty where it is of others.
std::string text_of_page(const fs::path& page) {
  if (!is_of_credence(head_of(page))) return {};
  std::ifstream in(page, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

constexpr std::string_view kLink = "href=\"";

}  // namespace

bool is_report_page(const fs::path& page) { return is_of_credence(head_of(page)); }

bool is_page_of_others(const fs::path& page) {
  std::error_code none;
  return fs::is_regular_file(page, none) && !is_report_page(page);
}

bool leads_to(const fs::path& page, std::string_view file) {
  return text_of_page(page).find(fmt::format("{}{}\"", kLink, escape_html(file))) != std::string::npos;
}

std::vector<std::string> files_of_page(const fs::path& page) {
  std::vector<std::string> files;
  const std::string text = text_of_page(page);
  for (std::size_t at = text.find(kLink); at != std::string::npos; at = text.find(kLink, at + 1)) {
    const std::string name = between(std::string_view(text).substr(at), kLink, "\"");
    if (name.empty() || name.find_first_of("/:#") != std::string::npos) continue;
    if (fs::is_regular_file(page.parent_path() / name) && std::ranges::find(files, name) == files.end())
      files.push_back(name);
  }
  return files;
}

std::vector<IndexedReport> find_reports(const fs::path& folder) {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  if (error) throw OutputError(fmt::format("{}: {}", folder.string(), error.message()));
  std::vector<IndexedReport> reports;
  const fs::recursive_directory_iterator end;
  while (entry != end) {
    const fs::path path = entry->path();
    if (entry->is_directory(error) && path.filename().string().starts_with('.'))
      entry.disable_recursion_pending();
    if (path.filename() == "index.html" && entry->is_regular_file(error)) {
      if (const std::string head = head_of(path); is_of_credence(head)) {
        reports.push_back({.page = path.lexically_relative(folder),
                           .title = between(head, "<title>", "</title>"),
                           .answer = said(head, "credence-answer"),
                           .date = said(head, "credence-date"),
                           .command = said(head, "credence-command")});
      }
    }
    // One that fails is at its end, so that a loop would not see it.
    entry.increment(error);
    if (error)
      throw OutputError(fmt::format("{}: behind {}: {}", folder.string(), path.string(), error.message()));
  }
  std::ranges::sort(reports, {}, &IndexedReport::page);
  return reports;
}

std::string command_of_page(const fs::path& page) {
  const std::string head = head_of(page);
  return is_of_credence(head) ? said(head, "credence-command") : "";
}

std::string description_of_page(const fs::path& page, std::string_view name) {
  const std::string head = head_of(page);
  return is_of_credence(head) ? said(head, "credence-description " + escape_html(name)) : "";
}

std::size_t write_report_index(const fs::path& folder, const Provenance& provenance) {
  using enum ColumnAlign;
  const std::vector<IndexedReport> reports = find_reports(folder);
  ReportTable table{.title = "Each leads to its page",
                    .columns = {{"report", words}, {"answer", words}, {"made (UTC)", words}, {"by", words}}};
  for (const IndexedReport& report : reports) {
    TableCell name(report.page.has_parent_path() ? report.page.parent_path().generic_string() : report.title);
    name.link = encoded_path(report.page.generic_string());
    table.add({std::move(name), report.answer, report.date, report.command});
  }
  Document document("Reports", counted(reports.size(), "report") + " of this folder");
  document.table(std::move(table));
  write_file(folder / kIndexName, html_page(document, {}, provenance));
  return reports.size();
}

}  // namespace credence::internal
