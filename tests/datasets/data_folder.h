#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace credence::testing {

/// The folder of a data set: within $CREDENCE_DATA, or else within ../shared/data beside the project. Empty
/// if absent.
inline std::filesystem::path data_folder(const std::string& name) {
  const char* const named = std::getenv("CREDENCE_DATA");
  const std::filesystem::path root = named != nullptr
                                         ? std::filesystem::path(named)
                                         : std::filesystem::path(CREDENCE_SOURCE_DIR "/../shared/data");
  return std::filesystem::is_directory(root / name) ? root / name : std::filesystem::path();
}

/// A folder of its own for one test, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            (std::string("credence_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

  /// Copies every file of another folder here, writable.
  void fill_from(const std::filesystem::path& other) const {
    for (const auto& entry : std::filesystem::directory_iterator(other)) {
      std::filesystem::copy_file(entry.path(), path_ / entry.path().filename());
      std::filesystem::permissions(path_ / entry.path().filename(), std::filesystem::perms::owner_all);
    }
  }

 private:
  std::filesystem::path path_;
};

}  // namespace credence::testing

/// Names the folder of a data set, or skips the test and says where the data were looked for.
#define CREDENCE_DATA_OR_SKIP(variable, name)                                  \
  const std::filesystem::path variable = credence::testing::data_folder(name); \
  if (variable.empty())                                                        \
  GTEST_SKIP() << "no data set '" << name << "' in $CREDENCE_DATA or ../shared/data: see docs/datasets.md"
