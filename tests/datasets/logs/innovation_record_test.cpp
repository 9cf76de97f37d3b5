#include "datasets/logs/innovation_record.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <string>

#include "datasets/data_error.h"
#include "datasets/logs/log_format.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

TEST(InnovationRecord, IsWhitenedRunByRun) {
  const TemporaryFolder folder;
  const std::array files = {
      folder.write("a.csv", "run,step,innovation.1,S.1.1\n1,1,2,4\n1,2,3,9\n2,1,-1,1\n2,2,5,-1\n"),
      folder.write("b.csv", "run,step,innovation.1,S.1.1\n1,1,0.5,0.25\n")};
  const std::vector<SensorRecord> records = read_innovations(
      files,
      [](const std::filesystem::path& file, LogSink& sink) { log_format_of(file).read(file, {}, sink); });
  ASSERT_EQ(records.size(), 1U);
  const SensorRecord& record = records.front();
  ASSERT_EQ(record.runs.size(), 3U);
  EXPECT_EQ(record.runs[0].nis, (std::vector<double>{1.0, 1.0}));
  EXPECT_EQ(record.runs[1].nis, std::vector<double>{1.0});
  EXPECT_EQ(record.runs[1].whitened.front()[0], -1.0);
  EXPECT_EQ(record.runs[2].nis, std::vector<double>{1.0});
  EXPECT_EQ(record.runs[2].dof, 1.0);
  EXPECT_NEAR(record.log_determinant, std::log(4.0 * 9.0 * 0.25), 1e-12);
}

// A copy says nothing about the noise that the log does not.
TEST(InnovationRecord, ARunThatIsThereTwiceIsRefused) {
  const TemporaryFolder folder;
  std::string text = "innovation.1,S.1.1\n";
  for (int i = 1; i <= 40; ++i) text += fmt::format("{},1\n", std::sin(i));
  const std::array files = {folder.write("a.csv", text), folder.write("b.csv", text)};
  try {
    read_innovations(files, [](const std::filesystem::path& file, LogSink& sink) {
      log_format_of(file).read(file, {}, sink);
    });
    ADD_FAILURE();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("b.csv: it has, in its first 32 rows"));
  }
}

// π itself is a wrapped angle; lengths have no turns.
TEST(InnovationRecord, AnglesBeyondHalfATurnAreCounted) {
  const TemporaryFolder folder;
  const std::array files = {
      folder.write("a.csv",
                   "innovation.compass.1:angle,S.compass.1.1,innovation.gps.1,S.gps.1.1\n"
                   "4,1,9,1\n3.141592653589793,1,-9,1\n-3.2,1,8,1\n3,1,0,1\n")};
  const std::vector<SensorRecord> records = read_innovations(
      files,
      [](const std::filesystem::path& file, LogSink& sink) { log_format_of(file).read(file, {}, sink); });
  ASSERT_EQ(records.size(), 2U);
  for (const SensorRecord& record : records) {
    EXPECT_EQ(record.unwrapped, record.name == "compass" ? 2 : 0) << record.name;
    EXPECT_EQ(record.left_out, 0);
  }
}

TEST(InnovationRecord, NisAloneIsLeftOutAndCounted) {
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> files = {
      folder.write("a.csv", "innovation.1,S.1.1,nis.gps.2\n2,4,1\n-2,4,3\n")};
  const std::vector<SensorRecord> records = read_innovations(
      files,
      [](const std::filesystem::path& file, LogSink& sink) { log_format_of(file).read(file, {}, sink); });
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].name, "");
  EXPECT_EQ(records[0].runs.at(0).nis.size(), 2U);
}

}  // namespace
}  // namespace credence::internal
