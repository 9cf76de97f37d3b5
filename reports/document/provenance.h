#pragma once

#include <string>
#include <utility>
#include <vector>

namespace credence::internal {

/// Where a page comes from, so that two of them can be told apart later.
///
/// It stands on pages only: JSON and CSV are the same bits whenever and wherever they are made.
struct Provenance {
  std::string version;  ///< "0.1.0"
  std::string commit;   ///< empty: not known
  std::string command;  ///< as it was typed; empty: made by a program
  std::string date;     ///< UTC, "2026-11-22 10:36:26"
  std::string machine;  ///< processor, number of its threads, and system
};

/// Of this build, this moment and this machine. The date is SOURCE_DATE_EPOCH where that is set, so that a
/// page can be made again bit for bit.
Provenance make_provenance(std::string command = {});

/// Names and values for a page, those that are known.
std::vector<std::pair<std::string, std::string>> provenance_facts(const Provenance& provenance);

}  // namespace credence::internal
