#include "datasets/logs/filter_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

const std::string kHeader =
    "step,estimate.x,estimate.heading:angle,truth.x,truth.heading,P.1.1,P.1.2,P.2.2,innovation.1,S.1.1\n";

class FilterLog : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const {
    std::ofstream(folder_.path() / "log.csv", std::ios::binary) << text;
    return folder_.path() / "log.csv";
  }

  std::vector<Step> read(const std::string& text) const {
    FilterLogReader reader(write(text));
    std::vector<Step> rows;
    Step row;
    while (reader.next(row)) rows.push_back(row);
    return rows;
  }

  std::string error(const std::string& text) const {
    try {
      read(text);
    } catch (const DataError& e) {
      return e.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
};

TEST_F(FilterLog, StepsMayBeCountedFromZero) {
  const auto rows = read(kHeader + "0,2,3,2,3,4,0,9,0,2\n1,2,3,2,3,4,0,9,0,2\n7,2,3,2,3,4,0,9,0,2\n");
  EXPECT_THAT((std::vector{rows.at(0).step, rows.at(1).step, rows.at(2).step}), ElementsAre(1, 2, 8));
  EXPECT_NE(error(kHeader + "0,2,3,2,3,4,0,9,0,2\n0,2,3,2,3,4,0,9,0,2\n")
                .find("step 0 does not increase: the row before has 0"),
            std::string::npos);
  FilterLogReader reader(write(kHeader + "0,2,3,2,3,4,0,9,0,2\n# failed: diverged at step 1\n"));
  Step row;
  while (reader.next(row)) {
  }
  EXPECT_EQ(reader.failure().value().step, 2);
  FilterLogReader threw(write(kHeader + "0,2,3,2,3,4,0,9,0,2\n# failed: threw at step 1\n"));
  while (threw.next(row)) {
  }
  EXPECT_EQ(threw.failure().value().outcome, Outcome::threw);
}

TEST_F(FilterLog, MayHoldTheNoiseThatTheFilterAssumes) {
  const std::string header = "innovation.1,innovation.2,S.1.1,S.1.2,S.2.2,R.1.1,R.1.2,R.2.2\n";
  const auto rows =
      read(header + "1,2,5,0,5,,,\n1,2,5,0,5,2,0.5,3\n1,2,5,0,5,,,\n1,,5,,,,,\n1,2,5,0,5,4,0,4\n");
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0].innovations[0].R.size(), 0);  // not known yet
  EXPECT_EQ(rows[1].innovations[0].R, (Matrix{{2.0, 0.5}, {0.5, 3.0}}));
  EXPECT_EQ(rows[2].innovations[0].R, rows[1].innovations[0].R);  // blank: as before
  EXPECT_EQ(rows[3].innovations[0].R, Matrix::Constant(1, 1, 2.0));
  EXPECT_EQ(rows[4].innovations[0].R, 4.0 * Matrix::Identity(2, 2));

  // Of one observation: the same for each that the innovation holds.
  const auto pieces =
      read("innovation.gps.1,innovation.gps.2:next,S.gps.1.1,S.gps.1.2,S.gps.2.2,R.gps.1.1\n1,2,5,0,5,3\n");
  EXPECT_EQ(pieces.at(0).innovations[0].R, 3.0 * Matrix::Identity(2, 2));

  EXPECT_NE(error(header + "1,2,5,0,5,2,,3\n")
                .find("log.csv:2: column R.1.2 is blank where others of its matrix are not"),
            std::string::npos);
  EXPECT_NE(error(header + "1,2,5,0,5,2,0,-3\n").find("a variance of R is negative"), std::string::npos);
  EXPECT_NE(error("innovation.1,innovation.2,S.1.1,S.1.2,S.2.2,R.1.1\n1,2,5,0,5,3\n")
                .find("column R.1.2 is missing"),
            std::string::npos);
  EXPECT_NE(error("nis.2,R.1.1\n1,1\n").find("name one of them"), std::string::npos);
}

TEST_F(FilterLog, MaySayThatTheFilterLinearisesOrInflates) {
  const auto layout = [&](const std::string& text) {
    FilterLogReader reader(write(text));
    Step row;
    reader.next(row);
    return reader.layout();
  };
  const std::string header = "innovation.1,S.1.1,nonlinear,inflated\n";
  const RunLayout both = layout(header + "1,5,1,0\n");
  EXPECT_TRUE(both.nonlinear);
  EXPECT_FALSE(both.inflated);
  EXPECT_TRUE(layout(header + "1,5,0,1\n").inflated);
  EXPECT_EQ(read(header + "1,5,1,0\n1,5,,\n1,5,1,0\n").size(), 3U);
  EXPECT_NE(error(header + "1,5,,0\n").find("column nonlinear: the first row says 1"), std::string::npos);
  EXPECT_NE(error(header + "1,5,0,0.5\n").find("column inflated: the first row says 1"), std::string::npos);
  EXPECT_NE(error(header + "1,5,1,0\n1,5,0,0\n")
                .find("log.csv:3: column nonlinear: what it says of the filter changes"),
            std::string::npos);
}

TEST_F(FilterLog, HoldsErrorsCovariancesAndInnovations) {
  const auto rows = read(kHeader + "1,2.5,3.1,2,-3.1,4,0.5,9,0.25,2\n3,1,0,1,0,1,0,1,,\r\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].step, 1);
  EXPECT_EQ(rows[0].line, 2);
  EXPECT_EQ(rows[0].error[0], 0.5);
  EXPECT_NEAR(rows[0].error[1], 6.2 - 2.0 * std::numbers::pi, 1e-15);  // wrapped
  EXPECT_EQ(rows[0].P(0, 1), 0.5);
  EXPECT_EQ(rows[0].P(1, 0), 0.5);
  EXPECT_EQ(rows[0].P(1, 1), 9.0);
  EXPECT_EQ(rows[0].innovations.at(0).nu[0], 0.25);
  EXPECT_EQ(rows[0].innovations.at(0).S(0, 0), 2.0);
  EXPECT_EQ(rows[1].step, 3);
  EXPECT_EQ(rows[1].innovations.at(0).nu.size(), 0);
}

TEST_F(FilterLog, NisAloneHasItsDimensionAndNoSign) {
  const std::string text = "step,nis.2,nis.baro.1\n1,8,\n2,0.5,4\n3,-1,1\n";
  const auto rows = read(text);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].innovations.at(0).nu, Vector::Constant(1, 8.0));
  EXPECT_EQ(rows[0].innovations.at(0).S.size(), 0);
  EXPECT_EQ(rows[0].innovations.at(1).nu.size(), 0);
  EXPECT_EQ(rows[1].innovations.at(1).nu, Vector::Constant(1, 4.0));
  EXPECT_EQ(rows[2].problem, "a NIS is negative");
  const FilterLogReader reader(write(text));
  EXPECT_TRUE(reader.layout().sensors.at(0).nis_alone);
  EXPECT_EQ(reader.layout().sensors.at(1).name, "baro");
  EXPECT_NE(error("nis.a.1,innovation.a.1,S.a.1.1\n1,1,1\n").find("name one of them"), std::string::npos);
  EXPECT_NE(error("nis\n1\n").find("unknown column 'nis'"), std::string::npos);
}

TEST_F(FilterLog, ObservationsThatLackComponentsAreMarked) {
  const auto rows = read(
      "innovation.1:angle,innovation.2,innovation.3:next:angle,innovation.4,S.1.1,S.1.2,S.1.3,S.1.4,S.2.2,S."
      "2.3,S.2.4,"
      "S.3.3,S.3.4,S.4.4\n"
      "1,2,3,4,1,0,0,0,1,0,0,1,0,1\n"
      "1,2,,,1,0,0,0,1,0,0,1,0,1\n"
      ",,3,4,1,0,0,0,1,0,0,1,0,1\n"
      ",,,,1,0,0,0,1,0,0,1,0,1\n"
      ",5,3,,1,0,0,0,1,0,0,1,0,1\n"
      "1,,,,1,0,0,0,1,0,0,1,0,1\n");
  ASSERT_EQ(rows.size(), 6U);
  for (const std::size_t whole : {0U, 1U, 2U, 3U})
    EXPECT_TRUE(rows[whole].innovations.at(0).complete) << whole;
  for (const std::size_t part : {4U, 5U}) EXPECT_FALSE(rows[part].innovations.at(0).complete) << part;
}

TEST_F(FilterLog, LeavesOutStatesThatAreBlankWithTheirVariances) {
  const auto rows = read(kHeader + "1,,3,,2.5,,,9,,\n2,1,3,,3,4,0,9,,\n");
  ASSERT_EQ(rows.size(), 2U);
  for (const Step& row : rows) {
    EXPECT_EQ(row.states, std::vector<Index>{1});
    EXPECT_EQ(row.P(0, 0), 9.0);
  }
}

TEST_F(FilterLog, TakesSeveralSensorsOfVaryingDimension) {
  FilterLogReader reader(
      write("innovation.gps.1,innovation.gps.2,S.gps.1.1,S.gps.1.2,S.gps.2.2,innovation.odo.1,S.odo.1.1\n"
            "1,2,3,0.5,4,,\n,2,,,4,7,8\n"));
  EXPECT_FALSE(reader.layout().has_truth);
  EXPECT_EQ(reader.layout().sensors, (std::vector<Sensor>{{.name = "gps", .dim = 2, .piece = 2},
                                                          {.name = "odo", .dim = 1, .piece = 1}}));
  Step row;
  ASSERT_TRUE(reader.next(row));
  EXPECT_EQ(row.innovations[0].nu.size(), 2);
  EXPECT_EQ(row.innovations[0].S(1, 0), 0.5);
  EXPECT_EQ(row.innovations[1].nu.size(), 0);
  ASSERT_TRUE(reader.next(row));
  EXPECT_EQ(row.innovations[0].nu.size(), 1);
  EXPECT_EQ(row.innovations[0].S(0, 0), 4.0);
  EXPECT_EQ(row.innovations[1].S(0, 0), 8.0);
}

TEST_F(FilterLog, ObservationsOfOneSensorBeginAtTheirMarksAndHaveTheSameAngles) {
  const std::string s = ",S.1.1,S.2.2,S.3.3,S.4.4,S.1.2,S.1.3,S.1.4,S.2.3,S.2.4,S.3.4\n",
                    row = "1,2,3,4,1,1,1,1,0,0,0,0,0,0\n";
  const auto sensor = [&](const std::string& innovation) {
    return FilterLogReader(write(innovation + s + row)).layout().sensors.at(0);
  };
  EXPECT_EQ(sensor("innovation.1,innovation.2,innovation.3,innovation.4"),
            (Sensor{.name = "", .dim = 4, .piece = 4}));
  EXPECT_EQ(sensor("innovation.1,innovation.2:angle,innovation.3:next,innovation.4:angle"),
            (Sensor{.name = "", .dim = 4, .piece = 2, .angles = {false, true}}));
  EXPECT_EQ(
      sensor("innovation.4:next:angle,innovation.2:next:angle,innovation.3:next:angle,innovation.1:angle"),
      (Sensor{.name = "", .dim = 4, .piece = 1, .angles = {true}}));
}

// Beyond 2^53 a double holds no odd number, and near 1.7e9 it is nothing finer than 2.4e-7.
TEST_F(FilterLog, RunsAreToldApartByAllDigitsOfTheirNumbers) {
  const auto names = [&](const std::string& text) {
    FilterLogReader reader(write(text));
    std::vector<std::string> all;
    for (Step row; reader.next(row);) {
      if (reader.run_began()) all.push_back(reader.run().value());
    }
    return all;
  };
  const std::string header = "run,estimate.x,truth.x,P.1.1\n", row = ",1,0,1\n";
  EXPECT_THAT(names(header + "20240101120000006" + row + "20240101120000006" + row + "20240101120000007" +
                    row + "20240101120000008" + row),
              ElementsAre("20240101120000006", "20240101120000007", "20240101120000008"));
  EXPECT_THAT(
      names("estimate.x,truth.x,P.1.1,run\n1,0,1, \"1700000000123456789\"\n1,0,1,1700000000123456790\n"),
      ElementsAre("1700000000123456789", "1700000000123456790"));
  EXPECT_THAT(names(header + "1700000000.12345678" + row + "1700000000.12345679" + row),
              ElementsAre("1700000000.12345678", "1700000000.12345679"));
  EXPECT_THAT(names(header + "7" + row + "7.0" + row + "0" + row + "-0" + row + "20240101120000007" + row +
                    "8" + row),
              ElementsAre("7", "0", "20240101120000007", "8"))
      << "small ones are numbers, however written";
}

TEST_F(FilterLog, KeepsTheRunsOfARunColumnApart) {
  FilterLogReader reader(
      write("run,estimate.x,truth.x,P.1.1\n7,1,0,1\n7,1,0,1\n# failed: diverged at step 3\n2,1,0,1\n"));
  Step row;
  ASSERT_TRUE(reader.next(row));
  EXPECT_TRUE(reader.run_began());
  ASSERT_TRUE(reader.next(row));
  EXPECT_FALSE(reader.run_began());
  EXPECT_EQ(row.step, 2);
  ASSERT_TRUE(reader.next(row));
  EXPECT_TRUE(reader.run_began());
  EXPECT_EQ(row.step, 1);
  ASSERT_TRUE(reader.failure().has_value());
  EXPECT_EQ(reader.failure()->step, 3);
  EXPECT_EQ(reader.failure()->outcome, Outcome::diverged);
  EXPECT_FALSE(reader.next(row));
}

TEST_F(FilterLog, TellsHowFarTheTruthHasTravelledInEachRun) {
  const std::string diagonal = ",1,0,0,1,0,1\n",
                    header =
                        "run,estimate.vehicle.x,estimate.vehicle.y,estimate.vehicle.heading:angle,truth."
                        "vehicle.x,truth.vehicle.y,"
                        "truth.vehicle.heading,P.1.1,P.1.2,P.1.3,P.2.2,P.2.3,P.3.3\n";
  testing::RecordedSink sink;
  const auto file = write(header + "1,0,0,0,0,0,0" + diagonal + "1,0,0,0,3,4,0" + diagonal + "1,0,0,0,3,5,0" +
                          diagonal + "2,0,0,0,9,9,0" + diagonal);
  own_format().read(file, {}, sink);
  ASSERT_EQ(sink.runs.size(), 2U);
  EXPECT_THAT(sink.runs[0].travelled_m, ElementsAre(0.0, 5.0, 6.0));
  EXPECT_THAT(sink.runs[1].travelled_m, ElementsAre(0.0));
}

TEST_F(FilterLog, AnAsymmetricCovarianceIsAProblemOfTheRow) {
  const auto rows = read(
      "estimate.x,estimate.y,truth.x,truth.y,P.1.1,P.1.2,P.2.1,P.2.2\n1,1,0,0,1,0.5,0.5,1\n1,1,0,0,1,0.5,0.4,"
      "1\n");
  EXPECT_EQ(rows.at(0).problem, "");
  EXPECT_EQ(rows.at(1).problem, "a covariance is not symmetric");
}

TEST_F(FilterLog, TimesBeyondTenToTheSixteenAreNanoseconds) {
  FilterLogReader reader(
      write("time,innovation.1,S.1.1\n1700000000100000000,1,1\n1700000000350000000,1,1\n"));
  Step row;
  ASSERT_TRUE(reader.next(row));
  EXPECT_NEAR(reader.time_s(), 1700000000.10, 1e-6);
  ASSERT_TRUE(reader.next(row));
  EXPECT_NEAR(reader.time_s(), 1700000000.35, 1e-6);
}

TEST_F(FilterLog, NanIsABlankAsProgramsWriteIt) {
  const std::vector<Step> blank = read(kHeader + "1,2,3,,,4,0,9,0,2\n2,2,3,2,3,4,0,9,,\n");
  for (const char* word : {"nan", "NaN", "-nan", "NAN", " nan"}) {
    const std::string nan = word;
    const std::vector<Step> rows =
        read(kHeader + "1,2,3," + nan + "," + nan + ",4,0,9,0,2\n2,2,3,2,3,4,0,9," + nan + "," + nan + "\n");
    ASSERT_EQ(rows.size(), 2U);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(rows[i].states, blank[i].states) << word;
      EXPECT_EQ(rows[i].error, blank[i].error);
      EXPECT_EQ(rows[i].innovations.size(), blank[i].innovations.size());
      EXPECT_EQ(rows[i].innovations[0].nu.size(), blank[i].innovations[0].nu.size());
    }
  }
}

TEST_F(FilterLog, AnAngleMayBeMarkedInEitherColumn) {
  for (const char* header : {"estimate.h:angle,truth.h,P.1.1\n", "estimate.h,truth.h:angle,P.1.1\n"}) {
    EXPECT_NEAR(read(std::string(header) + "3,-3,1\n").at(0).error[0], 6.0 - 2.0 * std::numbers::pi, 1e-15);
  }
}

TEST_F(FilterLog, NumbersMayHaveASignAndQuotesAndBeTooSmallForADouble) {
  const std::vector<Step> rows = read(kHeader + "1,+2,\"0.5\",1e-400, \"-0.25\" ,4,0,9,0,2\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].error, (Vector{{2.0, 0.75}}));
}

TEST_F(FilterLog, EveryMalformedInputIsOneErrorWithFileAndLine) {
  const std::string row = "1,2,3,2,3,4,0,9,0,2\n";
  const std::pair<std::string, std::string> cases[] = {
      {"", "is empty"},
      {"\n\n", "is empty"},
      {kHeader, "log.csv:1: holds no rows"},
      {kHeader + row + "2,2,3,2,3,4,0,9,0,2", "log.csv:3: the last line has no end"},
      {kHeader + row + "2,2,3\n", "log.csv:3: 3 fields where the header names 10 columns"},
      {kHeader + row + "2,2,3,2,3,4,0,9,0,2,5\n", "log.csv:3: 11 fields"},
      {kHeader + "1,nane,3,2,3,4,0,9,0,2\n", "log.csv:2: column estimate.x: 'nane' is not a finite number"},
      {kHeader + "1,-,3,2,3,4,0,9,0,2\n", "log.csv:2: column estimate.x: '-' is not a finite number"},
      {kHeader + "nan,2,3,2,3,4,0,9,0,2\n", "column step is blank"},
      {kHeader + "1,2,3,2,3,4,nan,9,0,2\n", "column P.1.2 is blank"},
      {kHeader + "1,inf,3,2,3,4,0,9,0,2\n", "'inf' is not a finite number"},
      {kHeader + "1,2.5.1,3,2,3,4,0,9,0,2\n", "'2.5.1' is not a finite number"},
      {kHeader + "1,\x01\x02,3,2,3,4,0,9,0,2\n", "'?\?' is not a finite number"},
      {kHeader + row + row, "log.csv:3: step 1 does not increase"},
      {kHeader + "1,2,3,2,3,4,0,9,0,2\n0,2,3,2,3,4,0,9,0,2\n",
       "log.csv:3: step 0 in a file whose first step is not 0"},
      {kHeader + "1e12,2,3,2,3,4,0,9,0,2\n", "accepted are whole numbers, counted from 0 or 1, to 10000000"},
      {kHeader + "10000000,2,3,2,3,4,0,9,0,2\n", "log.csv:2: step 10000000 with 0 rows before it"},
      {kHeader + row + "100101,2,3,2,3,4,0,9,0,2\n", "log.csv:3: step 100101 with 1 rows before it"},
      {kHeader + ",2,3,2,3,4,0,9,0,2\n", "column step is blank"},
      {kHeader + "1,2,3,2,3,4,,9,0,2\n", "column P.1.2 is blank"},
      {kHeader + "1,2,3,2,3,4,0,9,0,\n", "column S.1.1 is blank"},
      {"estimate.x,truth.x\n1,1\n", "log.csv:1: column P.1.1 is missing"},
      {"error.x,error.y,P.1.1,P.2.2\n1,1,1,1\n",
       "column P.1.2 is missing (0 where the two are not correlated)"},
      {"error.x,P.1.1\r1,1\r2,1\r", "lines end with CR alone, as on old Macs"},
      {"estimate.x,truth.y,P.1.1\n1,1,1\n", "column truth.x is missing"},
      {"estimate.x,P.1.1\n1,1\n", "nothing to judge"},
      {"estimate.x,truth.x,P.1.1,P.1.1\n1,1,1,1\n", "twice"},
      {"estimate.x,truth.x,P.1.1,P.1.2\n1,1,1,1\n", "lies outside"},
      {"estimate.x,truth.x,P.1.1,weight\n1,1,1,1\n", "unknown column 'weight'"},
      {"step,estimate.x\x1b[31m,truth.x,P.1.1\n1,1,1,1\n",
       "log.csv:1: column 2, 'estimate.x?[31m': its name holds a control character"},
      {"innovation.gps\xC2\x9B.1,S.gps\xC2\x9B.1.1\n1,1\n",
       "log.csv:1: column 1, 'innovation.gps?\?.1': its name holds a control character"},
      {"innovation.1,innovation.3,S.1.1\n1,1,1\n", "column innovation.2 is missing"},
      {"innovation.1\n1\n", "column S.1.1 is missing"},
      {"innovation.1:next,S.1.1\n1,1\n", "columns innovation.i:next: 1 components are not observations"},
      {"innovation.1:last,S.1.1\n1,1\n", "unknown column 'innovation.1:last'"},
      {"innovation.1,innovation.2,innovation.3:next,S.1.1,S.2.2,S.3.3,S.1.2,S.1.3,S.2.3\n1,1,1,1,1,1,0,0,0\n",
       "columns innovation.i:next: 3 components are not observations of one dimension"},
      {"innovation.1,innovation.2:next,innovation.3,S.1.1,S.2.2,S.3.3,S.1.2,S.1.3,S.2.3\n1,1,1,1,1,1,0,0,0\n",
       "columns innovation.i:next: 3 components"},
      {"innovation.1,innovation.2:next:angle,S.1.1,S.1.2,S.2.2\n1,1,1,0,1\n",
       "column innovation.2: an angle in one observation and not in another"},
      {"time,innovation.1,S.1.1\n2,1,1\n2,1,1\n", "log.csv:3: time 2 does not increase"},
      {"run,innovation.1,S.1.1\n1,1,1\n2,1,1\n1,1,1\n", "log.csv:4: the rows of run 1 do not stand together"},
      {kHeader + row + "# failed: tired at step 3\n", "log.csv:3: accepted is"},
      {kHeader + row + "# failed: diverged at step 3\n# failed: diverged at step 4\n",
       "log.csv:4: a second line"},
      {"# failed: diverged at step 2\n" + kHeader + row, "log.csv:2: a line '# failed: …' stands behind"},
      {kHeader + "# failed: diverged at step 2\n" + row, "log.csv:3: a line '# failed: …' stands behind"},
      {kHeader + row + "# failed: diverged at step 2\n2,2,3,2,3,4,0,9,0,2\n",
       "log.csv:4: the line '# failed: …' before stands behind the last row of its run"},
      {"run,innovation.1,S.1.1\n20240101120000007,1,1\n20240101120000008,1,1\n20240101120000007,1,1\n",
       "log.csv:4: the rows of run 20240101120000007 do not stand together"}};
  for (const auto& [text, expected] : cases) {
    EXPECT_NE(error(text).find(expected), std::string::npos)
        << "expected " << expected << "\ngot " << error(text);
  }
  EXPECT_EQ(error(kHeader + row + "100100,2,3,2,3,4,0,9,0,2\n"), "no error") << "steps may be left out";
  EXPECT_THROW(FilterLogReader(folder_.path() / "absent.csv"), DataError);
  EXPECT_THROW(FilterLogReader(folder_.path()), DataError);
}

TEST_F(FilterLog, NoBytesMakeItDoAnythingElseThanReadOrRefuse) {
  const std::string good = kHeader + "1,2,3,2,3,4,0,9,0,2\n2,1,1,1,1,1,0,1,,\n# failed: diverged at step 3\n";
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 600; ++i) {
    std::string text = good;
    const auto changes = 1 + random() % 4;
    for (unsigned c = 0; c < changes; ++c) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0: text[at] = static_cast<char>(random() % 256); break;
        case 1: text.erase(at, 1 + random() % 8); break;
        default: text.insert(at, text.substr(random() % text.size(), random() % 40));
      }
      if (text.empty()) text = "\n";
    }
    try {
      for (const Step& row : read(text)) {
        ASSERT_TRUE(row.error.allFinite());
        ASSERT_EQ(row.P.rows(), row.error.size());
      }
    } catch (const DataError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
}

TEST_F(FilterLog, StreamsLinesLongerThanItsBuffer) {
  const std::string padding(200'000, ' ');
  const auto rows = read("innovation.1,S.1.1\n" + padding + "1," + padding + "2\n3,4\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].innovations[0].S(0, 0), 2.0);
  EXPECT_EQ(rows[1].innovations[0].nu[0], 3.0);
}

TEST_F(FilterLog, MayHoldTheErrorsOfItsFilterOrOfSomeStates) {
  for (const char* log :
       {"error.x,error.turn:angle,P.1.1,P.1.2,P.2.2\n0.5,6.3,4,1,9\n,0.1,,,9\n",
        "estimate.x,truth.x,error.turn:angle,P.1.1,P.1.2,P.2.2\n2,1.5,6.3,4,1,9\n2,,0.1,,,9\n"}) {
    SCOPED_TRACE(log);
    const auto rows = read(log);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_THAT(rows[0].states, ElementsAre(0, 1));
    EXPECT_EQ(rows[0].error[0], 0.5);
    EXPECT_NEAR(rows[0].error[1], 6.3 - 2.0 * std::numbers::pi, 1e-15);
    EXPECT_EQ(rows[0].P(0, 1), 1.0);
    if (std::string_view(log).starts_with("estimate")) {  // which is known of that state
      ASSERT_EQ(rows[0].estimate.size(), 2);
      EXPECT_EQ(rows[0].estimate[0], 2.0);
      EXPECT_TRUE(std::isnan(rows[0].estimate[1]));
    } else {
      EXPECT_EQ(rows[0].estimate.size(), 0);
    }
    EXPECT_THAT(rows[1].states, ElementsAre(1));
    EXPECT_EQ(rows[1].P(0, 0), 9.0);
  }
}

}  // namespace
}  // namespace credence::internal
