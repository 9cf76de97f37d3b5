#include "datasets/logs/arrays/mat_log.h"

#include <gmock/gmock.h>
#include <matio.h>

#include "datasets/data_error.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using testing::RecordedSink;

constexpr std::size_t kMatRuns = 2, kMatSteps = 3;

/// An array whose value at (run, step, i, …) is 100 run + 10 step + the number of the component, as libmatio
/// writes it.
template <class Number>
matvar_t* variable(const char* name, std::vector<std::size_t> dims, matio_classes kind, matio_types type,
                   double offset) {
  std::size_t inner = 1;
  for (std::size_t d = 2; d < dims.size(); ++d) inner *= dims[d];
  std::vector<Number> values(kMatRuns * kMatSteps * inner);
  for (std::size_t i = 0; i < inner; ++i) {
    for (std::size_t k = 0; k < kMatSteps; ++k) {
      for (std::size_t run = 0; run < kMatRuns; ++run) {
        const double value = 100.0 * static_cast<double>(run) + 10.0 * static_cast<double>(k) + offset;
        // Of a covariance the off-diagonal entries are equal.
        const double component =
            dims.size() == 4 ? (i == 0 || i == 3 ? 1000.0 : 1.0) : static_cast<double>(i);
        values[(i * kMatSteps + k) * kMatRuns + run] = static_cast<Number>(value + component);
      }
    }
  }
  return Mat_VarCreate(name, kind, type, static_cast<int>(dims.size()), dims.data(), values.data(), 0);
}

std::vector<matvar_t*> variables() {
  return {variable<double>("error", {kMatRuns, kMatSteps, 2}, MAT_C_DOUBLE, MAT_T_DOUBLE, 0.25),
          variable<float>("P", {kMatRuns, kMatSteps, 2, 2}, MAT_C_SINGLE, MAT_T_SINGLE, 5.0),
          variable<std::int16_t>("innovation", {kMatRuns, kMatSteps}, MAT_C_INT16, MAT_T_INT16, 1.0),
          variable<double>("S", {kMatRuns, kMatSteps}, MAT_C_DOUBLE, MAT_T_DOUBLE, 2.0)};
}

enum class As { variables, packed, structure };

std::filesystem::path write(const TemporaryFolder& folder, As as) {
  const std::filesystem::path file = folder / "log.mat";
  mat_t* const mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  std::vector<matvar_t*> all = variables();
  if (as == As::structure) {
    const char* names[] = {"error", "P", "innovation", "S"};
    std::size_t one[] = {1, 1};
    matvar_t* const log = Mat_VarCreateStruct("log", 2, one, names, 4);
    for (std::size_t i = 0; i < all.size(); ++i) Mat_VarSetStructFieldByName(log, names[i], 0, all[i]);
    all = {log};
  }
  for (matvar_t* one : all) {
    Mat_VarWrite(mat, one, as == As::packed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE);
    Mat_VarFree(one);
  }
  Mat_Close(mat);
  return file;
}

TEST(MatLog, VariablesPackedOrNotAndFieldsOfAStructureAreTheSameRuns) {
  for (const As as : {As::variables, As::packed, As::structure}) {
    const TemporaryFolder folder;
    RecordedSink sink;
    mat_format().read(write(folder, as), {}, sink);
    ASSERT_EQ(sink.runs.size(), kMatRuns);
    for (std::size_t run = 0; run < kMatRuns; ++run) {
      ASSERT_EQ(sink.runs[run].steps.size(), kMatSteps);
      for (std::size_t k = 0; k < kMatSteps; ++k) {
        const Step& step = sink.runs[run].steps[k];
        const double base = 100.0 * static_cast<double>(run) + 10.0 * static_cast<double>(k);
        EXPECT_EQ(step.error, Eigen::Vector2d(base + 0.25, base + 1.25));
        EXPECT_EQ(step.P(0, 0), base + 1005.0);
        EXPECT_EQ(step.P(0, 1), base + 6.0);
        ASSERT_EQ(step.innovations.size(), 1U);
        EXPECT_EQ(step.innovations[0].nu, Vector::Constant(1, base + 1.0));
        EXPECT_EQ(step.innovations[0].S(0, 0), base + 2.0);
      }
    }
  }
}

TEST(MatLog, NoCutOrFlippedByteCrashes) {
  for (const As as : {As::packed, As::structure}) {
    const TemporaryFolder folder;
    const std::string whole = folder.read(write(folder, as).filename());
    // Behind error and P a file may end.
    EXPECT_EQ(testing::unnoticed_cuts(mat_format(), whole, {}), as == As::packed ? 1U : 0U);
  }
}

TEST(MatLog, AFileOfHdf5SaysHowToSaveIt) {
  const TemporaryFolder folder;
  std::string bytes = folder.read(write(folder, As::variables).filename());
  bytes[125] = 2;
  const auto file = folder.write("log.mat", bytes);
  RecordedSink sink;
  EXPECT_THAT([&] { mat_format().read(file, {}, sink); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("save -v7 FILE")));
}

}  // namespace
}  // namespace credence::internal
