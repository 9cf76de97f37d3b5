#include "datasets/logs/arrays/mat_arrays.h"

#include <gmock/gmock.h>
#include <matio.h>

#include "datasets/data_error.h"
#include "datasets/logs/log_format.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/temporary_folder.h"

// The bytes are those of "MAT-File Format", chapter 1, put together here by hand.

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Words = std::vector<std::uint32_t>;

std::string little_word(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

/// An element of a data type, in its long form, padded to 8 bytes.
std::string mat_element(std::uint32_t type, const std::string& data) {
  return little_word(type) + little_word(static_cast<std::uint32_t>(data.size())) + data +
         std::string((8 - data.size() % 8) % 8, '\0');
}

/// Flags, dimensions and name of an array.
std::string array_head(std::uint32_t flags, const Words& dims, const std::string& name) {
  std::string numbers;
  for (const std::uint32_t dim : dims) numbers += little_word(dim);
  return mat_element(6, little_word(flags) + little_word(0)) + mat_element(5, numbers) + mat_element(1, name);
}

std::vector<MatArray> mat_arrays_of(const std::vector<std::string>& arrays) {
  const TemporaryFolder folder;
  std::string bytes = std::string(124, ' ') + std::string("\x00\x01IM", 4);
  for (const std::string& array : arrays) bytes += mat_element(14, array);
  return read_mat_arrays(folder.write("small.mat", bytes),
                         [](std::string_view name) { return name != "other"; });
}

std::string mat_array_error(const std::string& array) {
  try {
    mat_arrays_of({array});
  } catch (const DataError& error) {
    return error.what();
  }
  return "accepted";
}

constexpr std::uint32_t kDoubles = 6, kComplexDoubles = 0x0806, kCharacters = 4;

TEST(MatArrays, TellsNameDimensionsAndNumbersOfThoseThatAreWanted) {
  const std::string eight("\0\0\0\0\0\0\xf0\x3f", 8);  // 1.0
  const auto arrays = mat_arrays_of(
      {array_head(kDoubles, {2, 1}, "plain") + mat_element(9, std::string(8, '\0') + eight),
       array_head(kComplexDoubles, {1, 1}, "phasor") + mat_element(9, eight) + mat_element(9, eight),
       array_head(kCharacters, {1, 2}, "text") + mat_element(4, std::string("h\0i\0", 4)),
       array_head(15, {2, 1, 4}, "longs") + mat_element(1, "\x01\x02\x03\x04\x05\x06\x07\xff"),
       array_head(kDoubles, {1, 1}, "other") + mat_element(9, eight)});
  ASSERT_EQ(arrays.size(), 5U);
  EXPECT_EQ(arrays[0].name, "plain");
  EXPECT_THAT(arrays[0].dims, ElementsAre(2, 1));
  EXPECT_THAT(arrays[0].numbers, ElementsAre(0.0, 1.0));
  EXPECT_FALSE(arrays[1].is_read);
  EXPECT_FALSE(arrays[2].is_read);
  EXPECT_EQ(arrays[3].name, "longs");
  EXPECT_THAT(arrays[3].dims, ElementsAre(2, 1, 4));
  EXPECT_THAT(arrays[3].numbers, ElementsAre(1, 2, 3, 4, 5, 6, 7, -1))
      << "whole numbers may be stored in fewer bytes";
  EXPECT_EQ(arrays[4].name, "other");
  EXPECT_FALSE(arrays[4].is_read);
}

// MATLAB writes up to four bytes of data into the tag: their number in its upper half, the type in the lower.
TEST(MatArrays, OneNameIsOneArray) {
  const std::string error = array_head(kDoubles, {1, 1}, "error") + mat_element(9, std::string(8, '\0'));
  const std::string other = array_head(kDoubles, {1, 1}, "other") + mat_element(9, std::string(8, '\0'));
  EXPECT_EQ(mat_arrays_of({error, other, other}).size(), 3U) << "those that nobody reads";
  EXPECT_THAT(
      [&] {
        mat_arrays_of({error, other, error});
      },
      ::testing::ThrowsMessage<DataError>(HasSubstr("error is there twice, as a variable or a field")));
}

TEST(MatArrays, ReadsShortElements) {
  const std::string short_name = little_word(3U << 16 | 1) + std::string("abc\0", 4);
  const std::string short_data = little_word(2U << 16 | 2) + std::string("\x07\x08\0\0", 4);
  const std::string head = mat_element(6, little_word(kDoubles) + little_word(0)) +
                           mat_element(5, little_word(1) + little_word(2));
  const auto arrays = mat_arrays_of({head + short_name + short_data});
  ASSERT_EQ(arrays.size(), 1U);
  EXPECT_EQ(arrays[0].name, "abc");
  EXPECT_THAT(arrays[0].numbers, ElementsAre(7, 8));
  EXPECT_THAT(mat_array_error(head + little_word(5U << 16 | 1) + "abcd"),
              HasSubstr("short element of 5 bytes"));
}

TEST(MatArrays, EmptyArraysHaveNoData) {
  const auto arrays = mat_arrays_of({array_head(kDoubles, {0, 0}, "none") + mat_element(9, ""),
                                     array_head(kDoubles, {0, 4'000'000}, "flat") + mat_element(9, ""),
                                     array_head(kDoubles, {4'000'000, 0}, "tall") + mat_element(9, "")});
  for (const MatArray& array : arrays) EXPECT_TRUE(array.is_read && array.numbers.empty()) << array.name;
  EXPECT_THAT(arrays.at(2).dims, ElementsAre(4'000'000, 0));
  EXPECT_THAT(arrays.at(1).dims, ElementsAre(0, 4'000'000));
  EXPECT_THAT(mat_array_error(array_head(kDoubles, {0, 3}, "none") + mat_element(9, std::string(8, '\0'))),
              HasSubstr("none: 8 bytes of numbers do not fit its dimensions"));
}

// 8 · 2^30 · 2^30 · 2 is 2^64, which is 0 in 64 bits.
TEST(MatArrays, SizesThatOverflowAreRefused) {
  const std::string none = mat_element(9, ""), eight = mat_element(9, std::string(8, '\0'));
  const std::uint32_t half = 1U << 30, largest = (1U << 31) - 1;
  EXPECT_THAT(mat_array_error(array_head(kDoubles, {half, half, 2}, "x") + none),
              HasSubstr("x: dimensions beyond its"));
  EXPECT_THAT(mat_array_error(array_head(kDoubles, Words(5, largest), "x") + eight),
              HasSubstr("x: dimensions beyond its"));
  EXPECT_THAT(mat_array_error(array_head(kDoubles, {1, 1U << 31}, "x") + eight),
              HasSubstr("a dimension of -2147483648"));
}

// A field without a name was taken for a variable, whatever the depth.
TEST(MatArrays, AStructureWithinAStructureIsNotOpened) {
  const auto structure_of = [](const std::string& field, const std::string& value) {
    return array_head(2, {1, 1}, "s") + mat_element(5, little_word(4)) +
           mat_element(1, field + std::string(4 - field.size(), '\0')) + mat_element(14, value);
  };
  const std::string number = array_head(kDoubles, {1, 1}, "") + mat_element(9, std::string(8, '\0'));
  for (const char* field : {"f", ""}) {
    const auto arrays = mat_arrays_of({structure_of(field, structure_of("x", number))});
    ASSERT_EQ(arrays.size(), 1U);
    EXPECT_EQ(arrays[0].name, field);
    EXPECT_FALSE(arrays[0].is_read);
    EXPECT_TRUE(mat_arrays_of({structure_of(field, number)}).at(0).is_read);
  }
}

TEST(MatArrays, NamesOfNoLettersTakeNoMemory) {
  EXPECT_THAT(mat_array_error(array_head(kCharacters, {(1U << 31) - 1, 0}, "names") + mat_element(4, "")),
              HasSubstr("names: 2147483647 texts: too many"));
}

TEST(MatArrays, NamesWhatIsWrongInAnArray) {
  const std::string one = mat_element(9, std::string(8, '\0')), good = array_head(kDoubles, {1, 1}, "x");
  EXPECT_EQ(mat_array_error(good + one), "accepted");
  EXPECT_THAT(mat_array_error(good), HasSubstr("4 bytes are needed here and 0 are left"));
  EXPECT_THAT(mat_array_error(good + mat_element(8, "")),
              HasSubstr("x: 0 bytes of type 8, which holds no numbers"));
  EXPECT_THAT(mat_array_error(mat_element(5, "")), HasSubstr("4 bytes are needed here and 0 are left"));
}

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

matvar_t* text(const std::string& letters, std::size_t rows) {
  std::size_t dims[] = {rows, letters.size() / rows};
  std::string copy = letters;  // matio takes it without const, and copies it
  return Mat_VarCreate("names", MAT_C_CHAR, MAT_T_UTF8, 2, dims, copy.data(), 0);
}

/// Of a log whose names are such a variable.
RunLayout layout_with(matvar_t* names) {
  const TemporaryFolder folder;
  mat_t* const mat = Mat_CreateVer((folder / "log.mat").c_str(), nullptr, MAT_FT_MAT5);
  std::vector<matvar_t*> all = variables();
  all.push_back(names);
  for (matvar_t* one : all) {
    Mat_VarWrite(mat, one, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(one);
  }
  Mat_Close(mat);
  RecordedSink sink;
  mat_format().read(folder / "log.mat", {}, sink);
  return sink.runs.at(0).layout;
}

// {'car.x', 'yaw:angle'} of MATLAB and char('car.x', 'yaw:angle'), which fills up with blanks.
TEST(MatLog, StatesHaveTheNamesOfACellArrayOrOfTheRowsOfAMatrixOfCharacters) {
  matvar_t* cells[] = {text("car.x", 1), text("yaw:angle", 1), nullptr};
  std::size_t two[] = {1, 2};
  const std::string first = "car.x    ", second = "yaw:angle";
  std::string columns;
  for (std::size_t k = 0; k < first.size(); ++k) columns += {first[k], second[k]};
  for (matvar_t* names :
       {Mat_VarCreate("names", MAT_C_CELL, MAT_T_CELL, 2, two, static_cast<void*>(cells), 0),
        text(columns, 2)}) {
    const RunLayout layout = layout_with(names);
    EXPECT_THAT(layout.states, ElementsAre("car.x", "yaw"));
    EXPECT_THAT(layout.angles, ElementsAre(false, true));
  }
  EXPECT_THAT(layout_with(variable<double>("names", {2}, MAT_C_DOUBLE, MAT_T_DOUBLE, 1.0)).states,
              ElementsAre("x1", "x2"))
      << "numbers of that name are something else";
}

TEST(MatLog, NamesMayHoldLettersBeyondAscii) {
  std::size_t one[] = {1, 1}, two[] = {1, 2}, six[] = {1, 6};
  std::string utf8 = "Höhe.z";
  std::u16string utf16 = u"ψ";
  matvar_t* cells[] = {Mat_VarCreate("", MAT_C_CHAR, MAT_T_UTF8, 2, six, utf8.data(), 0),
                       Mat_VarCreate("", MAT_C_CHAR, MAT_T_UTF16, 2, one, utf16.data(), 0), nullptr};
  EXPECT_THAT(
      layout_with(Mat_VarCreate("names", MAT_C_CELL, MAT_T_CELL, 2, two, static_cast<void*>(cells), 0))
          .states,
      ElementsAre("Höhe.z", "ψ"));
}

TEST(MatLog, NamesMustBeOneForEachStateAndStringsAreToldHowToSave) {
  EXPECT_THAT([] { layout_with(text("car.x", 1)); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("names: 1 names for 2 states")));
  // As an array of letters they would take the square of what the file does.
  std::vector<matvar_t*> cells(3000);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = text(std::string(i == 0 ? 3000 : 1, 'x'), 1);
  cells.push_back(nullptr);
  std::size_t many[] = {1, 3000};
  EXPECT_THAT(
      [&] {
        layout_with(
            Mat_VarCreate("names", MAT_C_CELL, MAT_T_CELL, 2, many, static_cast<void*>(cells.data()), 0));
      },
      ::testing::ThrowsMessage<DataError>(HasSubstr("names: 3000 texts, one of 3000 letters: too many")));
  // A string of MATLAB: its name, "MCOS", "string" and a reference come at once behind the flags.
  const auto opaque = [](const std::string& name) {
    return mat_element(6, little_word(17) + little_word(0)) + mat_element(1, name) + mat_element(1, "MCOS") +
           mat_element(1, "string");
  };
  EXPECT_THAT(mat_array_error(opaque("names")), HasSubstr("names = cellstr(names)"));
  EXPECT_EQ(mat_array_error(opaque("comment")), "accepted");
}

TEST(MatLog, NoCutOrFlippedByteCrashes) {
  for (const As as : {As::packed, As::structure}) {
    const TemporaryFolder folder;
    const std::string whole = folder.read(write(folder, as).filename());
    // Behind error and P a file may end.
    EXPECT_EQ(testing::unnoticed_cuts(mat_format(), whole, {}), as == As::packed ? 1U : 0U);
  }
}

// type, rows, columns, imaginary, length of the name (MAT-File Format, version 4).
TEST(MatLog, AFileOfVersion4SaysHowToSaveIt) {
  const TemporaryFolder folder;
  const std::string bytes = testing::ByteWriter()
                                .add<std::uint32_t>(0)
                                .add<std::uint32_t>(20)
                                .add<std::uint32_t>(1)
                                .add<std::uint32_t>(0)
                                .add<std::uint32_t>(6)
                                .text(std::string("error\0", 6))
                                .text(std::string(160, '\0'))
                                .bytes();
  const auto file = folder.write("log.mat", bytes);
  RecordedSink sink;
  EXPECT_THAT([&] { log_format_of(file).read(file, {}, sink); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("version 4")));
}

TEST(MatLog, AFileOfHdf5SaysHowToSaveIt) {
  const TemporaryFolder folder;
  std::string bytes = folder.read(write(folder, As::variables).filename());
  bytes[125] = 2;
  const auto file = folder.write("log.mat", bytes);
  RecordedSink sink;
  EXPECT_THAT([&] { mat_format().read(file, {}, sink); },
              ::testing::ThrowsMessage<DataError>(HasSubstr("save('FILE', '-struct', 's', '-v7')")));
}

}  // namespace
}  // namespace credence::internal
