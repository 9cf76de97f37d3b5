#include "datasets/replay/carpark.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <fstream>
#include <map>
#include <random>

#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using testing::copy_data;
using ::testing::HasSubstr;

using Arrays = std::map<std::string, Matrix>;

/// A run of two fixes, three odometry samples and one scan, in the form of the real files.
Arrays small_run() {
  Arrays run;
  const auto row = [&](const std::string& name, std::vector<double> values) {
    run[name] = Eigen::Map<Eigen::RowVectorXd>(values.data(), static_cast<Index>(values.size()));
  };
  row("Time", {0.0, 0.1, 0.2, 0.3, 0.4, 0.5});
  row("Sensor", {2, 1, 2, 3, 2, 1});
  row("Index", {1, 1, 2, 1, 3, 2});
  row("Time_VS", {0.0, 0.2, 0.4});
  row("Velocity", {1, 1, 1});
  row("Steering", {0, 0.1, -0.1});
  row("TimeGPS", {0.1, 0.5});
  row("GPSLon", {0, 0.4});
  row("GPSLat", {0, 0});
  row("TimeLaser", {0.3});
  run["Laser"] = Matrix::Constant(1, 361, 81.9);
  run["Intensity"] = Matrix::Zero(1, 361);
  return run;
}

void write_mat(const std::filesystem::path& file, const Arrays& arrays) {
  mat_t* const mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  for (const auto& [name, values] : arrays) {
    std::size_t dims[] = {static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())};
    Matrix copy = values;
    matvar_t* const variable =
        Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, copy.data(), 0);
    Mat_VarWrite(mat, variable, MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
  }
  Mat_Close(mat);
}

std::string error_of(const TemporaryFolder& folder, const Arrays& run, const Matrix& beacons) {
  write_mat(folder.path() / "data_set.mat", run);
  write_mat(folder.path() / "beac_juan3.mat", {{"estbeac", beacons}});
  try {
    read_carpark(folder.path());
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Carpark, MergesTheSensorsInOrderOfTime) {
  const TemporaryFolder folder;
  ASSERT_EQ(error_of(folder, small_run(), Matrix::Ones(3, 2)), "no error");
  const CarparkLog log = read_carpark(folder.path());
  ASSERT_EQ(log.events.size(), 6U);
  EXPECT_EQ(log.events[3].sensor, CarparkSensor::laser);
  EXPECT_EQ(log.events[4].index, 2U);
  EXPECT_DOUBLE_EQ(log.odometry[2].steering_rad, -0.1);
  EXPECT_EQ(log.gps[1].position_m, Eigen::Vector2d(0.4, 0));
  EXPECT_EQ(log.scans[0].range_m.size(), 361);
  EXPECT_EQ(log.beacons_m.size(), 3U);
}

TEST(Carpark, NamesTheVariableThatIsWrong) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& name, const Matrix& values) {
    Arrays run = small_run();
    run[name] = values;
    return error_of(folder, run, Matrix::Ones(3, 2));
  };
  const auto row = [](std::initializer_list<double> values) {
    Matrix result(1, static_cast<Index>(values.size()));
    std::copy(values.begin(), values.end(), result.data());
    return result;
  };
  EXPECT_THAT(error("Time_VS", row({0, 0.4, 0.2})), AllOf(HasSubstr("'Time_VS'"), HasSubstr("backwards")));
  EXPECT_THAT(error("Time", row({0, .1, .2, .2, .4, .5})),
              AllOf(HasSubstr("'Time'"), HasSubstr("its sample")));
  EXPECT_THAT(error("Sensor", row({2, 1, 2, 4, 2, 1})), AllOf(HasSubstr("'Sensor'"), HasSubstr("is 4")));
  EXPECT_THAT(error("Sensor", row({2, 1, 2, 2.5, 2, 1})), AllOf(HasSubstr("'Sensor'"), HasSubstr("2.5")));
  EXPECT_THAT(error("Index", row({1, 1, 2, 1, 4, 2})),
              AllOf(HasSubstr("'Index'"), HasSubstr("number 5 is 4")));
  EXPECT_THAT(error("Index", row({1, 1, 2, 1, 3})),
              AllOf(HasSubstr("'Index'"), HasSubstr("5 numbers where 6")));
  EXPECT_THAT(error("Velocity", row({1, 1})), AllOf(HasSubstr("'Velocity'"), HasSubstr("2 numbers where 3")));
  EXPECT_THAT(error("Velocity", row({1, 99, 1})),
              AllOf(HasSubstr("'Velocity'"), HasSubstr("number 2 is 99")));
  EXPECT_THAT(error("Steering", row({0, 2, 0})), AllOf(HasSubstr("'Steering'"), HasSubstr("outside")));
  EXPECT_THAT(error("Laser", Matrix::Ones(361, 1)), AllOf(HasSubstr("'Laser'"), HasSubstr("361x1")));
  EXPECT_THAT(error("Intensity", Matrix::Ones(2, 361)), AllOf(HasSubstr("'Intensity'"), HasSubstr("2x361")));
  EXPECT_THAT(error("Laser", Matrix::Constant(1, 361, -1)),
              AllOf(HasSubstr("'Laser'"), HasSubstr("negative")));
  EXPECT_THAT(error_of(folder, small_run(), Matrix::Ones(2, 3)),
              AllOf(HasSubstr("'estbeac'"), HasSubstr("East")));

  Arrays lacking = small_run();
  lacking.erase("Laser");
  EXPECT_THAT(error_of(folder, lacking, Matrix::Ones(3, 2)),
              AllOf(HasSubstr("data_set.mat"), HasSubstr("'Laser'")));
  std::filesystem::remove(folder.path() / "data_set.mat");
  EXPECT_THROW(read_carpark(folder.path()), DataError);
}

TEST(Carpark, ReadsTheRealRun) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const CarparkLog log = read_carpark(data);
  EXPECT_EQ(log.events.size(), 6213U);
  EXPECT_EQ(log.gps.size(), 626U);
  EXPECT_EQ(log.odometry.size(), 5001U);
  EXPECT_EQ(log.scans.size(), 586U);
  EXPECT_EQ(log.beacons_m.size(), 15U);
  EXPECT_NEAR(log.events.back().time_s - log.events.front().time_s, 125, 1);
}

// Every length of the real file, coarsely: all its variables are needed, so no cut may pass.
TEST(Carpark, EveryCutOfTheRealFilesIsAnError) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  for (const char* name : {"data_set.mat", "beac_juan3.mat"}) {
    const TemporaryFolder folder;
    copy_data(data, folder);
    std::uintmax_t size = std::filesystem::file_size(folder.path() / name);
    for (int cut = 0; size > 0 && cut < 200; ++cut) {
      size -= std::min(size, cut < 50 ? 1 + size / 5000 : 1 + size / 20);
      std::filesystem::resize_file(folder.path() / name, size);
      try {
        read_carpark(folder.path());
        ADD_FAILURE() << name << " cut to " << size << " bytes was read";
      } catch (const DataError& error) {
        ASSERT_THAT(error.what(), HasSubstr(name));
      }
    }
  }
}

// Flips where it hurts most: in the tags at the beginning of each variable, and anywhere.
TEST(Carpark, FlippedBytesOfTheRealFileAreAnErrorOrNumbers) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const TemporaryFolder folder;
  copy_data(data, folder);
  const auto file = folder.path() / "data_set.mat";
  const auto size = static_cast<std::uint32_t>(std::filesystem::file_size(file));
  std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
  std::vector<std::uint32_t> begins;
  for (std::uint32_t at = 128; at < size;) {
    begins.push_back(at);
    std::uint32_t length = 0;
    bytes.seekg(at + 4).read(reinterpret_cast<char*>(&length), sizeof length);
    at += 8 + length;
  }
  std::mt19937 random(6);
  int errors = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const std::uint32_t begin = begins[random() % begins.size()];
    const auto at =
        static_cast<std::streamoff>(trial % 3 == 0 ? 124 + random() % (size - 124) : begin + random() % 64);
    const auto original = static_cast<char>(bytes.seekg(at).get());
    bytes.seekp(at).put(static_cast<char>(random())).flush();
    try {
      EXPECT_EQ(read_carpark(folder.path()).events.size(), 6213U);
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr("data_set.mat"));
      ++errors;
    }
    bytes.seekp(at).put(original).flush();
  }
  EXPECT_GT(errors, 50);
  EXPECT_NO_THROW(read_carpark(folder.path()));
}

}  // namespace
}  // namespace credence::internal
