#include "datasets/replay/mat_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <fstream>
#include <random>

#include "datasets/data_error.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// A MAT-file of version 5 with one variable of each kind that a test needs.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& file)
      : mat_(Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5)) {}
  ~Writer() { Mat_Close(mat_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  template <typename Number>
  void add(const char* name, matio_classes kind, matio_types type, std::vector<std::size_t> dims,
           std::vector<Number> data, matio_compression compression = MAT_COMPRESSION_NONE) {
    matvar_t* const variable =
        Mat_VarCreate(name, kind, type, static_cast<int>(dims.size()), dims.data(), data.data(), 0);
    Mat_VarWrite(mat_, variable, compression);
    Mat_VarFree(variable);
  }

  void add_complex(const char* name) {
    std::array<double, 2> re{1, 2}, im{3, 4};
    mat_complex_split_t split{re.data(), im.data()};
    std::array<std::size_t, 2> dims{2, 1};
    matvar_t* const variable =
        Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims.data(), &split, MAT_F_COMPLEX);
    Mat_VarWrite(mat_, variable, MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
  }

 private:
  mat_t* mat_;
};

std::string variable_error(const std::filesystem::path& file, const std::string& variable) {
  try {
    MatFile(file).matrix(variable);
  } catch (const DataError& error) {
    EXPECT_EQ(error.file(), file);
    return error.what();
  }
  return "no error";
}

TEST(MatFile, ReadsEveryNumericClass) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "plain.mat";
  {
    Writer writer(file);
    writer.add<double>("doubles", MAT_C_DOUBLE, MAT_T_DOUBLE, {2, 3}, {1, 2, 3, 4, 5, 6.5});
    writer.add<float>("singles", MAT_C_SINGLE, MAT_T_SINGLE, {1, 2}, {0.5F, -0.25F});
    writer.add<std::int16_t>("shorts", MAT_C_INT16, MAT_T_INT16, {3, 1}, {-1, 2, 300});
    writer.add<std::uint8_t>("bytes", MAT_C_UINT8, MAT_T_UINT8, {1, 1}, {255});
    writer.add<std::int64_t>("longs", MAT_C_INT64, MAT_T_INT64, {1, 1}, {-(std::int64_t{1} << 40)});
  }
  const MatFile mat(file);
  Matrix expected(2, 3);
  expected << 1, 3, 5, 2, 4, 6.5;  // columns first
  EXPECT_EQ(mat.matrix("doubles"), expected);
  EXPECT_EQ(mat.vector("singles"), (Vector(2) << 0.5, -0.25).finished());
  EXPECT_EQ(mat.vector("shorts"), (Vector(3) << -1, 2, 300).finished());
  EXPECT_EQ(mat.matrix("bytes")(0, 0), 255);
  EXPECT_EQ(mat.matrix("longs")(0, 0), -1099511627776.0);
  EXPECT_EQ(mat.matrix("doubles"), expected) << "a second look at an earlier variable";
}

TEST(MatFile, NamesFileAndVariableOfWhatItCannotUse) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "odd.mat";
  {
    Writer writer(file);
    writer.add<double>("cube", MAT_C_DOUBLE, MAT_T_DOUBLE, {2, 1, 2}, {1, 2, 3, 4});
    writer.add<double>("nothing", MAT_C_DOUBLE, MAT_T_DOUBLE, {0, 3}, {});
    writer.add<double>("square", MAT_C_DOUBLE, MAT_T_DOUBLE, {2, 2}, {1, 2, 3, 4});
    writer.add<double>("hole", MAT_C_DOUBLE, MAT_T_DOUBLE, {1, 2}, {1, std::nan("")});
    writer.add<char>("text", MAT_C_CHAR, MAT_T_UINT8, {1, 2}, {'h', 'i'});
    writer.add_complex("phasor");
  }
  EXPECT_THAT(variable_error(file, "Laser"),
              AllOf(HasSubstr("odd.mat"), HasSubstr("'Laser'"), HasSubstr("square")));
  EXPECT_THAT(variable_error(file, "cube"), AllOf(HasSubstr("'cube'"), HasSubstr("3 dimensions")));
  EXPECT_THAT(variable_error(file, "nothing"), AllOf(HasSubstr("'nothing'"), HasSubstr("empty")));
  EXPECT_THAT(variable_error(file, "hole"), AllOf(HasSubstr("'hole'"), HasSubstr("not finite")));
  EXPECT_THAT(variable_error(file, "text"), AllOf(HasSubstr("'text'"), HasSubstr("text")));
  EXPECT_THAT(variable_error(file, "phasor"), AllOf(HasSubstr("'phasor'"), HasSubstr("complex")));
  EXPECT_THROW(MatFile(file).vector("square"), DataError);
}

TEST(MatFile, RefusesFilesOfOtherKinds) {
  const TemporaryFolder folder;
  EXPECT_THAT(variable_error(folder.path() / "absent.mat", "x"), HasSubstr("no such file"));
  EXPECT_THAT(variable_error(folder.path(), "x"), HasSubstr("is not a regular file"));
  EXPECT_THAT(variable_error(folder.write("empty.mat", ""), "x"), HasSubstr("header of a MAT-file"));
  EXPECT_THAT(variable_error(folder.write("three_numbers.mat", std::string(20 + 2 + 3 * 8, '\0')), "x"),
              HasSubstr("as those of version 4"));
  EXPECT_THAT(variable_error(folder.write("text.mat", std::string(500, 'a')), "x"),
              HasSubstr("no mark of its byte order"));

  std::string header(128, ' ');
  header.replace(124, 4, std::string("\x00\x02IM", 4));
  EXPECT_THAT(variable_error(folder.write("new.mat", header), "x"), HasSubstr("version 7.3"));
  header.replace(124, 4, std::string("\x00\x01IM", 4));
  EXPECT_THAT(variable_error(folder.write("bare.mat", header), "x"), HasSubstr("'x': is not in the file"));
}

TEST(MatFile, ReadsWhatMatlabPacks) {
  const TemporaryFolder folder;
  const auto packed = folder.path() / "packed.mat";
  Writer(packed).add<double>("x", MAT_C_DOUBLE, MAT_T_DOUBLE, {1, 2}, {1, 2}, MAT_COMPRESSION_ZLIB);
  EXPECT_EQ(MatFile(packed).vector("x"), (Vector(2) << 1, 2).finished());
}

TEST(MatFile, ReadsAFileOfTheOtherByteOrder) {
  const auto word = [](std::uint32_t value) {
    return std::string{static_cast<char>(value >> 24), static_cast<char>(value >> 16),
                       static_cast<char>(value >> 8), static_cast<char>(value)};
  };
  const std::string array = word(6) + word(8) + word(6) + word(0)             // flags: class double
                            + word(5) + word(8) + word(1) + word(2)           // dimensions 1×2
                            + word(1) + word(1) + "x" + std::string(7, '\0')  //
                            + word(9) + word(16) + std::string("\x3f\xf8\0\0\0\0\0\0", 8) +
                            std::string("\xc0\0\0\0\0\0\0\0", 8);
  const std::string header = std::string(124, ' ') + std::string("\x01\x00MI", 4);
  const TemporaryFolder folder;
  const auto file = folder.write("big.mat", header + word(14) + word(64 + 8) + array);
  EXPECT_EQ(MatFile(file).vector("x"), (Vector(2) << 1.5, -2).finished());
}

TEST(MatFile, EveryCutOfASmallFileIsAnError) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "cut.mat";
  Writer(file).add<double>("x", MAT_C_DOUBLE, MAT_T_DOUBLE, {5, 2}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  ASSERT_EQ(variable_error(file, "x"), "no error");
  for (auto size = std::filesystem::file_size(file); size-- > 0;) {
    std::filesystem::resize_file(file, size);
    ASSERT_NE(variable_error(file, "x"), "no error") << "cut to " << size << " bytes";
  }
}

TEST(MatFile, FlippedBytesAreAnErrorOrNumbers) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "whole.mat";
  {
    Writer writer(file);
    writer.add<std::int16_t>("index", MAT_C_INT16, MAT_T_INT16, {1, 6}, {1, 2, 3, 4, 5, 6});
    writer.add<double>("x", MAT_C_DOUBLE, MAT_T_DOUBLE, {5, 2}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  }
  std::ifstream in(file, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::mt19937 random(4);
  int errors = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string broken = whole;
    for (auto flips = 1 + random() % 3; flips > 0; --flips)
      broken[100 + random() % (whole.size() - 100)] = static_cast<char>(random());
    const auto copy = folder.write("broken.mat", broken);
    try {
      EXPECT_TRUE(MatFile(copy).matrix("x").allFinite());
    } catch (const DataError& error) {
      EXPECT_EQ(error.file(), copy);
      ++errors;
    }
  }
  EXPECT_GT(errors, 500);
}

}  // namespace
}  // namespace credence::internal
