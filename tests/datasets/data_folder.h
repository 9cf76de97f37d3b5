#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace credence::internal::testing {

/// The folder of a data set: within $CREDENCE_DATA, or else within ../shared/data beside the project. Empty
/// if absent.
inline std::filesystem::path data_folder(const std::string& name) {
  const char* const named = std::getenv("CREDENCE_DATA");
  const std::filesystem::path root =
      named != nullptr ? std::filesystem::path(named) : source_folder() / "../shared/data";
  return std::filesystem::is_directory(root / name) ? root / name : std::filesystem::path();
}

/// Copies every file of a data set into a test's folder, writable.
inline void copy_data(const std::filesystem::path& data, const TemporaryFolder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(data)) {
    const std::filesystem::path copy = folder / entry.path().filename();
    std::filesystem::copy_file(entry.path(), copy);
    std::filesystem::permissions(copy, std::filesystem::perms::owner_all);
  }
}

}  // namespace credence::internal::testing

/// Names the folder of a data set, or skips the test and says where the data were looked for.
#define CREDENCE_DATA_OR_SKIP(variable, name)                                            \
  const std::filesystem::path variable = credence::internal::testing::data_folder(name); \
  if (variable.empty())                                                                  \
  GTEST_SKIP() << "no data set '" << name << "' in $CREDENCE_DATA or ../shared/data: see docs/datasets.md"
