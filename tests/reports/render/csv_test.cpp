#include "reports/render/csv.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

std::string record(std::initializer_list<CsvField> fields) {
  return csv_record(std::span<const CsvField>(fields.begin(), fields.size()));
}

// RFC 4180, section 2, rules 5 to 7.
TEST(Csv, QuotesWhatMustBeQuoted) {
  EXPECT_EQ(record({"plain", "with space"}), "plain,with space\r\n");
  EXPECT_EQ(record({"a,b", "say \"hi\"", "two\nlines", "cr\r"}),
            "\"a,b\",\"say \"\"hi\"\"\",\"two\nlines\",\"cr\r\"\r\n");
  EXPECT_EQ(record({"", "σ²"}), ",σ²\r\n");
}

TEST(Csv, DoublesAreShortAndReadBackExactly) {
  EXPECT_EQ(record({0.1, 1.0, -2.5e-300, 100}), "0.1,1,-2.5e-300,100\r\n");
  for (const double value : {1.0 / 3.0, 0.1 + 0.2, 1e23, std::numeric_limits<double>::denorm_min()}) {
    EXPECT_EQ(std::strtod(CsvField(value).text.c_str(), nullptr), value);
  }
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(record({std::numeric_limits<double>::quiet_NaN(), kInf, -kInf}), "nan,inf,-inf\r\n");
}

TEST(Csv, WritesHeaderAndRecords) {
  const TemporaryFolder folder;
  CsvWriter writer(folder / "a.csv", {"step", "nees"});
  writer.add({1, 2.5});
  EXPECT_FALSE(std::filesystem::exists(folder / "a.csv")) << "the file must not appear before it is whole";
  writer.commit();
  EXPECT_EQ(folder.read("a.csv"), "step,nees\r\n1,2.5\r\n");
}

TEST(Csv, WritesMoreThanOneBlock) {
  const TemporaryFolder folder;
  CsvWriter writer(folder / "a.csv", {"i"});
  std::string expected = "i\r\n";
  for (int i = 0; i < 20000; ++i) {
    writer.add({i});
    expected += std::to_string(i) + "\r\n";
  }
  writer.commit();
  EXPECT_EQ(folder.read("a.csv"), expected);
}

TEST(Csv, RefusesARecordOfAnotherLength) {
  const TemporaryFolder folder;
  CsvWriter writer(folder / "a.csv", {"a", "b"});
  EXPECT_THROW(writer.add({1}), std::invalid_argument);
}

TEST(Csv, AnUnwritablePathIsAnError) {
  EXPECT_THROW(CsvWriter("/nonexistent/folder/a.csv", {"a"}), OutputError);
}

}  // namespace
}  // namespace credence::internal
