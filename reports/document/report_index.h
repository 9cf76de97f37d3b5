#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "reports/document/provenance.h"

/// @file
/// A page above the pages: every report of a folder, with its answer.

namespace credence::internal {

/// What a page says of itself in its head (html_page.h).
struct IndexedReport {
  std::filesystem::path page;  ///< relative to the folder
  std::string title, answer, date, command;
};

/// The reports in a folder and its subfolders, ordered by path. Pages of others are passed over, as are
/// hidden folders and those that one may not read; links are not followed. Throws OutputError for a folder
/// that cannot be read for another reason, or that is not there: none is left out without a word.
std::vector<IndexedReport> find_reports(const std::filesystem::path& folder);

/// Whether a page is one of Credence.
bool is_report_page(const std::filesystem::path& page);

/// Whether there is one that is of somebody else.
bool is_page_of_others(const std::filesystem::path& page);

/// Whether it is, and leads to a file beside it.
bool leads_to(const std::filesystem::path& page, std::string_view file);

/// The files beside a page of Credence that it leads to and that are there, in its order, each once.
std::vector<std::string> files_of_page(const std::filesystem::path& page);

/// The command that made a page, as the page says; empty where there is none, or it is of others.
std::string command_of_page(const std::filesystem::path& page);

/// What the author of a scenario says of it, as the page says (Document::descriptions); empty where it does
/// not.
std::string description_of_page(const std::filesystem::path& page, std::string_view name);

/// Writes FOLDER/reports.html and returns how many reports it lists. Throws OutputError.
std::size_t write_report_index(const std::filesystem::path& folder,
                               const Provenance& provenance = make_provenance());

}  // namespace credence::internal
