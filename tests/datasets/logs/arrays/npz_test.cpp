#include "datasets/logs/arrays/npz.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/manifold/angle.h"
#include "datasets/data_error.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using testing::RecordedSink;

struct Npy {
  std::string name;
  std::vector<std::size_t> shape;
  std::vector<double> values;  ///< the last index runs fastest
  std::string type = "<f8";
  bool fortran_order = false;
  std::pair<std::string, std::string>
      header_change{};  ///< a text of its header, and what stands in its place
};

/// The bytes of a .npy file of version 1.
std::string npy_bytes(const Npy& array) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({},), }}", array.type,
                                   array.fortran_order ? "True" : "False", fmt::join(array.shape, ", "));
  if (const auto& [from, to] = array.header_change; !from.empty())
    header.replace(header.find(from), from.size(), to);
  header.resize((header.size() + 10 + 64) / 64 * 64 - 10, ' ');
  header.back() = '\n';
  ByteWriter out(array.type[0] == '>' ? std::endian::big : std::endian::little);
  std::vector<double> stored = array.values;
  if (array.fortran_order) {
    for (std::size_t k = 0; k < stored.size(); ++k) {
      std::size_t rest = k, place = 0, stride = 1;
      for (const std::size_t dim : array.shape) stride *= dim;
      for (std::size_t d = array.shape.size(); d-- > 0;) {
        stride /= array.shape[d];
        place += rest % array.shape[d] * stride;
        rest /= array.shape[d];
      }
      stored[place] = array.values[k];
    }
  }
  for (const double value : stored) {
    if (array.type.find('U') != std::string::npos) {
      out.add(static_cast<std::uint32_t>(value));
    } else if (array.type.ends_with("i8")) {
      out.add(static_cast<std::int64_t>(value));
    } else if (array.type.ends_with('4')) {
      out.add(static_cast<float>(value));
    } else {
      out.add(value);
    }
  }
  const auto size = static_cast<std::uint16_t>(header.size());
  return std::string("\x93NUMPY\x01\x00", 8) + ByteWriter().add(size).bytes() + header + out.bytes();
}

std::string deflated(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
  std::string in = bytes, out(compressBound(bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// A zip file as numpy.savez and numpy.savez_compressed write it.
std::string written_npz(const std::vector<Npy>& arrays, bool packed = false) {
  std::string file, directory;
  for (const Npy& array : arrays) {
    const std::string plain = npy_bytes(array), name = array.name + ".npy";
    const std::string body = packed ? deflated(plain) : plain;
    const auto checksum = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(plain.data()), static_cast<z_size_t>(plain.size())));
    const auto at = static_cast<std::uint32_t>(file.size());
    ByteWriter common;
    common.add<std::uint16_t>(45)
        .add<std::uint16_t>(0)
        .add<std::uint16_t>(packed ? 8 : 0)
        .add<std::uint32_t>(0);
    common.add(checksum)
        .add(static_cast<std::uint32_t>(body.size()))
        .add(static_cast<std::uint32_t>(plain.size()));
    common.add(static_cast<std::uint16_t>(name.size()));
    // Unlike the directory, the local header has an extra field of 20 bytes, as numpy's has.
    file += ByteWriter().text("PK\x03\x04").text(common.bytes()).add<std::uint16_t>(20).text(name).bytes();
    file += ByteWriter().add<std::uint16_t>(1).add<std::uint16_t>(16).text(std::string(16, '\0')).bytes();
    file += body;
    directory += ByteWriter()
                     .text("PK\x01\x02")
                     .add<std::uint16_t>(45)
                     .text(common.bytes())
                     .text(std::string(12, '\0'))
                     .add(at)
                     .text(name)
                     .bytes();
  }
  const auto count = static_cast<std::uint16_t>(arrays.size());
  const std::string end = ByteWriter()
                              .text("PK\x05\x06")
                              .add<std::uint32_t>(0)
                              .add(count)
                              .add(count)
                              .add(static_cast<std::uint32_t>(directory.size()))
                              .add(static_cast<std::uint32_t>(file.size()))
                              .add<std::uint16_t>(0)
                              .bytes();
  return file + directory + end;
}

constexpr std::size_t kNpzRuns = 3, kNpzSteps = 4;

/// Numbers that differ in every place, and symmetric matrices.
std::vector<Npy> arrays(const std::string& type = "<f8", bool fortran_order = false) {
  Npy error{"error", {kNpzRuns, kNpzSteps, 2}, {}, type, fortran_order};
  Npy P{"P", {kNpzRuns, kNpzSteps, 2, 2}, {}, type, fortran_order};
  Npy nu{"innovation", {kNpzRuns, kNpzSteps, 1}, {}, type, fortran_order};
  Npy S{"S", {kNpzRuns, kNpzSteps, 1, 1}, {}, type, fortran_order};
  for (std::size_t k = 0; k < kNpzRuns * kNpzSteps; ++k) {
    const auto x = static_cast<double>(k);
    error.values.insert(error.values.end(), {x, -x - 0.5});
    P.values.insert(P.values.end(), {2.0 + x, 0.25, 0.25, 3.0 + x});
    nu.values.push_back(0.125 * x);
    S.values.push_back(1.0 + x);
  }
  return {error, P, nu, S};
}

RecordedSink read(const std::string& bytes) {
  const TemporaryFolder folder;
  RecordedSink sink;
  npz_format().read(folder.write("log.npz", bytes), {}, sink);
  return sink;
}

void expect_the_runs(const RecordedSink& sink, const std::string& what, bool angle = false) {
  ASSERT_EQ(sink.runs.size(), kNpzRuns) << what;
  std::size_t k = 0;
  for (const RecordedSink::Run& run : sink.runs) {
    ASSERT_EQ(run.steps.size(), kNpzSteps) << what;
    for (const Step& step : run.steps) {
      const auto x = static_cast<double>(k++);
      EXPECT_EQ(step.error, Eigen::Vector2d(x, angle ? wrap_angle(-x - 0.5) : -x - 0.5)) << what;
      EXPECT_EQ(step.P(0, 0), 2.0 + x) << what;
      EXPECT_EQ(step.P(1, 0), 0.25) << what;
      EXPECT_EQ(step.P(1, 1), 3.0 + x) << what;
      EXPECT_EQ(step.innovations.at(0).nu[0], 0.125 * x) << what;
      EXPECT_EQ(step.innovations.at(0).S(0, 0), 1.0 + x) << what;
      EXPECT_TRUE(step.problem.empty());
    }
  }
}

TEST(Npz, StoredAndPackedInBothOrdersOfBothTypes) {
  for (const char* type : {"<f8", ">f8", "<f4", ">f4"}) {
    for (const bool fortran_order : {false, true}) {
      for (const bool packed : {false, true}) {
        const std::string what = fmt::format("{} {} {}", type, fortran_order, packed);
        expect_the_runs(read(written_npz(arrays(type, fortran_order), packed)), what);
      }
    }
  }
}

TEST(Npz, NanIsSilence) {
  auto log = arrays();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  log[0].values[1] = nan;  // the second state of the first step
  log[2].values[2] = nan;  // the third innovation
  const RecordedSink sink = read(written_npz(log));
  EXPECT_EQ(sink.runs[0].steps[0].states, std::vector<Index>{0});
  EXPECT_EQ(sink.runs[0].steps[0].P, Matrix::Constant(1, 1, 2.0));
  EXPECT_EQ(sink.runs[0].steps[1].states.size(), 2U);
  EXPECT_EQ(sink.runs[0].steps[2].innovations[0].nu.size(), 0);
}

/// As numpy.array(texts), of the texts' longest length.
Npy names_of_states(const std::vector<std::string>& texts) {
  std::size_t longest = 1;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  Npy array{"names", {texts.size()}, {}, fmt::format("<U{}", longest)};
  for (std::string text : texts) {
    text.resize(longest, '\0');
    array.values.insert(array.values.end(), text.begin(), text.end());
  }
  return array;
}

TEST(Npz, StatesHaveTheNamesOfTheArrayOfNames) {
  for (const bool packed : {false, true}) {
    auto log = arrays();
    log.push_back(names_of_states({"position.x", "attitude.yaw:angle"}));
    const RecordedSink sink = read(written_npz(log, packed));
    expect_the_runs(sink, "named", true);
    const RunLayout& layout = sink.runs[0].layout;
    EXPECT_EQ(layout.states, (std::vector<std::string>{"position.x", "attitude.yaw"}));
    EXPECT_EQ(layout.angles, (std::vector<bool>{false, true}));
    ASSERT_EQ(layout.blocks.size(), 2U);
    EXPECT_EQ(layout.blocks[1].name, "attitude");
  }
}

TEST(Npz, NamesMustBeOneForEachState) {
  const auto problem = [](const Npy& names) {
    auto log = arrays();
    log.push_back(names);
    try {
      read(written_npz(log));
    } catch (const DataError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(problem(names_of_states({"x"})), HasSubstr("names: 1 names for 2 states"));
  EXPECT_THAT(problem(names_of_states({"x", "x"})), HasSubstr("'x' is there twice"));
  EXPECT_EQ(problem({"names", {2}, {1, 2}, "<i8"}), "none") << "numbers of that name are something else";
}

TEST(Npz, OneRunNeedsNoDimensionOfRunsAndSensorsHaveNames) {
  const Npy gps{"innovation_gps", {2, 1}, {1, 2}}, S_gps{"S_gps", {2, 1, 1}, {3, 4}};
  const Npy baro{"innovation_baro", {2, 1}, {5, 6}}, S_baro{"S_baro", {2, 1, 1}, {7, 8}};
  const Npy unrelated{"weights", {2}, {1, 2}, "<i4"};
  const RecordedSink sink = read(written_npz({gps, S_gps, baro, S_baro, unrelated}));
  ASSERT_EQ(sink.runs.size(), 1U);
  EXPECT_FALSE(sink.runs[0].layout.has_truth);
  ASSERT_EQ(sink.runs[0].layout.sensors.size(), 2U);
  EXPECT_EQ(sink.runs[0].layout.sensors[1].name, "baro");
  EXPECT_EQ(sink.runs[0].steps[1].innovations[1].S(0, 0), 8.0);
}

TEST(Npz, NisAloneNamesItsDimension) {
  const Npy gps{"nis_gps_2", {2, 3}, {1, 2, 3, 4, NAN, 6}}, other{"nis_1", {2, 3}, {1, 2, 3, 4, 5, -6}};
  const Npy unrelated{"nis_mean", {1}, {1}};
  const RecordedSink sink = read(written_npz({gps, other, unrelated}));
  ASSERT_EQ(sink.runs.size(), 2U);
  const RunLayout& layout = sink.runs[0].layout;
  ASSERT_EQ(layout.sensors.size(), 2U);
  EXPECT_EQ(layout.sensors[0].name, "gps");
  EXPECT_EQ(layout.sensors[0].dim, 2);
  EXPECT_EQ(layout.sensors[1].name, "");
  EXPECT_TRUE(layout.sensors[1].nis_alone);
  EXPECT_NEAR(sink.runs[1].steps[2].innovations[0].nu[0], 6.0, 1e-12);
  EXPECT_EQ(sink.runs[1].steps[1].innovations[0].nu.size(), 0);
  EXPECT_EQ(sink.runs[1].steps[2].problem, "a NIS is negative");
}

TEST(Npz, ObservationSaysHowManyComponentsOneHas) {
  const Npy nu{"innovation_gps", {1, 4}, {1, 2, 3, 4}};
  Npy S{"S_gps", {1, 4, 4}, std::vector<double>(16, 0.0)};
  for (std::size_t i = 0; i < 4; ++i) S.values[5 * i] = 1.0;
  EXPECT_EQ(read(written_npz({nu, S})).runs[0].layout.sensors[0].piece, 4);
  EXPECT_EQ(read(written_npz({nu, S, {"observation_gps", {1}, {2}}})).runs[0].layout.sensors[0].piece, 2);
  const Npy whole{"observation_gps", {1}, {2}, "<i8"};  // what numpy makes of a 2
  EXPECT_EQ(read(written_npz({nu, S, whole})).runs[0].layout.sensors[0].piece, 2);
  for (const Npy& wrong : {Npy{"observation_gps", {1}, {3}}, Npy{"observation_gps", {1}, {0}},
                           Npy{"observation_gps", {1}, {1.5}}, Npy{"observation_gps", {1}, {NAN}},
                           Npy{"observation_gps", {2}, {2, 2}}}) {
    EXPECT_THAT(
        [&] {
          read(written_npz({nu, S, wrong}));
        },
        ::testing::ThrowsMessage<DataError>(HasSubstr("that divides the 4 components")));
  }
}

TEST(Npz, MaySayWhatTheFilterAssumes) {
  const auto log = arrays();  // of an innovation of one component
  const Npy nu{"innovation", {2, 3, 2}, std::vector<double>(12, 1.0)};
  Npy S{"S", {2, 3, 2, 2}, std::vector<double>(24, 0.0)}, R{"R", {2, 3, 2, 2}, {}};
  for (std::size_t i = 0; i < 24; ++i) S.values[i] = i % 4 == 0 || i % 4 == 3 ? 9.0 : 0.0;
  for (std::size_t i = 0; i < 24; ++i)
    R.values.push_back(i % 4 == 0 || i % 4 == 3 ? 1.0 + double(i / 4) : 0.0);
  const auto noise = [&](const std::vector<Npy>& more, std::size_t run, std::size_t step) {
    std::vector<Npy> all{nu, S};
    all.insert(all.end(), more.begin(), more.end());
    return read(written_npz(all)).runs.at(run).steps.at(step).innovations.at(0).R;
  };
  EXPECT_EQ(noise({}, 0, 0).size(), 0);
  EXPECT_EQ(noise({R}, 0, 0), Matrix::Identity(2, 2));
  EXPECT_EQ(noise({R}, 1, 2), 6.0 * Matrix::Identity(2, 2));
  EXPECT_EQ(noise({{"R", {2, 2}, {4, 1, 1, 3}}}, 1, 2), (Matrix{{4.0, 1.0}, {1.0, 3.0}}));
  EXPECT_EQ(noise({{"R", {1, 1}, {4}}, {"observation", {1}, {1}}}, 1, 2), 4.0 * Matrix::Identity(2, 2));
  EXPECT_EQ(noise({{"R", {2, 2}, {4, 0, 0, 3}, "<i8"}}, 0, 1), (Matrix{{4.0, 0.0}, {0.0, 3.0}}));
  const auto fails_with = [&](const Npy& array, const std::string& message) {
    EXPECT_THAT(
        [&] {
          read(written_npz({nu, S, array}));
        },
        ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  fails_with({"R", {2}, {1, 1}}, "R (2): accepted are the dimensions of S (2, 3, 2, 2), and (2, 2)");
  fails_with({"R", {2, 2}, {1, 0, 0, -1}}, "R: is no covariance");
  fails_with({"R", {2, 2}, {1, 0.5, 0, 1}}, "R: is no covariance");
  fails_with({"R", {2, 2}, {1, 0, 0, NAN}}, "R: is no covariance");

  EXPECT_FALSE(read(written_npz(log)).runs.at(0).layout.nonlinear);
  const Npy yes{"nonlinear", {}, {1}}, no{"inflated", {1}, {0}};
  const RunLayout layout = read(written_npz({nu, S, yes, no})).runs.at(0).layout;
  EXPECT_TRUE(layout.nonlinear);
  EXPECT_FALSE(layout.inflated);
  EXPECT_TRUE(read(written_npz({nu, S, {"inflated", {1}, {1}, "<i8"}})).runs.at(0).layout.inflated);
  fails_with({"inflated", {1}, {2}}, "inflated (1): accepted is one number");
  fails_with({"nonlinear", {2}, {1, 1}}, "nonlinear (2): accepted is one number");
}

TEST(Npz, ErrorsNameTheArray) {
  const auto fails_with = [](const std::string& bytes, const std::string& message) {
    EXPECT_THAT([&] { read(bytes); }, ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  auto log = arrays();
  fails_with(written_npz({log[0]}), "array P is missing beside error; its arrays are error (3, 4, 2)");
  fails_with(written_npz({log[1], log[2], log[3]}), "array error is missing beside P");
  fails_with(written_npz({Npy{"x", {1}, {0}}}), "holds nothing to judge");
  fails_with(written_npz({log[0], log[3]}), "array P is missing");
  Npy wrong{"P", {kNpzRuns, kNpzSteps, 2}, log[0].values};
  fails_with(written_npz({log[0], wrong}), "error (3, 4, 2) and P (3, 4, 2): accepted are");
  const Npy other{"innovation", {2, 1}, {1, 2}}, other_S{"S", {2, 1, 1}, {1, 1}};
  fails_with(written_npz({log[0], log[1], other, other_S}), "other runs or steps");
  Npy integers = log[0];
  integers.type = "<i8";
  fails_with(written_npz({integers, log[1]}), "error.npy is of type '<i8'; read are float32 and float64");
  const std::string whole = written_npz(log);
  fails_with(whole.substr(0, whole.size() - 30), "ends without the directory");
  std::string flipped = whole;
  flipped[200] ^= 1;
  fails_with(flipped, "error.npy has a checksum that is not its own");
  Npy large = log[0];
  large.shape = {kNpzRuns, kNpzSteps, 200000000000};
  fails_with(written_npz({large, log[1]}), "a shape beyond its");
}

TEST(Npz, ASizeBelowZeroIsNotReadAsThatAboveIt) {
  const auto log = arrays();
  const std::string shape = "'shape': (3, 4, 2,)";
  for (const bool packed : {false, true}) {
    for (const char* wrong : {"'shape': (-3, 4, 2)", "'shape': (3, -4, 2)", "'shape': (3., 4, 2)"}) {
      std::vector<Npy> changed = log;
      changed[0].header_change = {shape, wrong};
      EXPECT_THAT([&] { read(written_npz(changed, packed)); },
                  ::testing::ThrowsMessage<DataError>(
                      HasSubstr("error.npy: a shape of other than whole numbers from 0 on: corrupted")))
          << wrong;
    }
    std::vector<Npy> of_python_2 = log;
    of_python_2[0].header_change = {shape, "'shape': (3L,4L, 2L)"};
    expect_the_runs(read(written_npz(of_python_2, packed)), "3L");
  }
}

TEST(Npz, AMemberThatIsThereTwiceIsRefusedByName) {
  auto log = arrays();
  log.push_back(log[1]);
  const TemporaryFolder folder;
  const auto file = folder.write("log.npz", written_npz(log));
  RecordedSink sink;
  EXPECT_THAT([&] { npz_format().read(file, {}, sink); },
              ::testing::ThrowsMessage<DataError>(
                  ::testing::AllOf(HasSubstr("log.npz"), HasSubstr("P.npy is there twice: corrupted"))));
  log.back().name = "P.npy";  // its member is P.npy.npy
  expect_the_runs(read(written_npz(log)), "another name");
}

// Zeros of gigabytes are packed into little: what cannot be judged is refused before they are unpacked, and
// with them their checksum is looked at.
TEST(Npz, PackedArraysAreRefusedByTheirHeaders) {
  const auto fails_with = [](std::string bytes, const std::string& message) {
    bytes[bytes.find("PK\x01\x02") + 16] ^= 1;  // the checksum of the first
    EXPECT_THAT([&] { read(bytes); }, ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  const auto log = arrays();
  const Npy wrong{"P", {kNpzRuns, kNpzSteps, 2}, log[0].values};
  fails_with(written_npz({log[0], wrong}, true), "error (3, 4, 2) and P (3, 4, 2): accepted are");
  fails_with(written_npz(log, true), "error.npy has a checksum that is not its own");
}

TEST(Npz, NoCutOrFlippedByteCrashes) {
  for (const bool packed : {false, true}) {
    std::vector<Npy> log = {{"innovation", {2, 1}, {1, 2}}, {"S", {2, 1, 1}, {1, 1}}};
    EXPECT_EQ(testing::unnoticed_cuts(npz_format(), written_npz(log, packed), {}), 0U);
  }
}

}  // namespace
}  // namespace credence::internal
