#include "montecarlo/scenario/scenario_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

/// A file of the test's own, gone with it.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content) {
    std::string pattern = (std::filesystem::temp_directory_path() / "credence_scenario_XXXXXX").string();
    directory_ = mkdtemp(pattern.data());
    path_ = directory_ / "little.toml";
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~ScratchFile() { std::filesystem::remove_all(directory_); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& directory() const { return directory_; }

 private:
  std::filesystem::path directory_, path_;
};

const std::string kLine = "[world]\nmodel = \"monobot\"\n";

std::string refusal_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return scenario_refusal([&] { load_scenario_text(text, "scenarios/x.toml", overrides); });
}

/// "section.key = value" of each.
std::vector<std::string> texts_of(const std::vector<Setting>& settings) {
  std::vector<std::string> texts;
  for (const Setting& s : settings) texts.push_back(s.section + "|" + s.key + " = " + value_text(s.value));
  return texts;
}

std::vector<std::string> places_of(const std::vector<Setting>& settings) {
  std::vector<std::string> places;
  for (const Setting& s : settings) places.push_back(s.place);
  return places;
}

TEST(ReadScenario, KeepsTheOrderOfTheFileAndSaysWhereEachKeyStands) {
  const ScenarioDocument read = read_scenario_text(
      "top = 1\n[zoo]\nb = 2.5\na = \"x\"\n[ant]\nc = true\nd = [1, 2.0]\ne = [[1], [2, 3]]\nf = "
      "2024-01-01\n",
      "dir/the.name.toml");
  EXPECT_EQ(read.file, "dir/the.name.toml");
  EXPECT_EQ(read.name, "the.name");
  EXPECT_THAT(texts_of(read.settings),
              ElementsAre("|top = 1", "zoo|b = 2.5", "zoo|a = \"x\"", "ant|c = true", "ant|d = [1, 2.0]",
                          "ant|e = [[1], [2, 3]]", "ant|f = a date or time"));
  EXPECT_EQ(read.settings[0].place, "dir/the.name.toml:1: top = 1");
  EXPECT_EQ(read.settings[2].place, "dir/the.name.toml:4: [zoo] a = \"x\"");
  EXPECT_THAT(read.sweep, testing::IsEmpty());
}

// An array is nested only where all of its elements are arrays.
TEST(ReadScenario, ArraysAreFlatOrNested) {
  const auto value = [](const std::string& text) {
    return read_scenario_text("[s]\nk = " + text + "\n", "x.toml").settings.front().value;
  };
  EXPECT_TRUE(std::holds_alternative<std::vector<ScalarValue>>(value("[]")));
  EXPECT_TRUE(std::holds_alternative<std::vector<ScalarValue>>(value("[[1], 2]")));
  EXPECT_TRUE(std::holds_alternative<NestedArray>(value("[[], []]")));
  EXPECT_TRUE(std::holds_alternative<NestedArray>(value("[[1, \"a\"], [true]]")));
  EXPECT_TRUE(std::holds_alternative<ScalarValue>(value("{a = 1}")));
}

TEST(ReadScenario, AnEmptySectionCountsOnlyWhereItsNameIsUnknown) {
  EXPECT_THAT(read_scenario_text("[noise]\n", "x.toml").settings, testing::IsEmpty());
  const auto unknown = read_scenario_text("\n[nose]\n", "x.toml").settings;
  ASSERT_EQ(unknown.size(), 1U);
  EXPECT_EQ(unknown[0].section, "nose");
  EXPECT_EQ(unknown[0].key, "");
  EXPECT_EQ(unknown[0].place, "x.toml:2: [nose]");
}

// The three ways to write a key of [sweep] say the same; words that qualify a sweep have no section.
TEST(ReadScenario, KeysOfASweepAreWrittenInThreeWays) {
  for (const char* text : {"[sweep]\n\"world.landmarks\" = \"1:3\"\nmode = \"zip\"\n",
                           "[sweep]\nworld.landmarks = \"1:3\"\nmode = \"zip\"\n",
                           "[sweep.world]\nlandmarks = \"1:3\"\n[sweep]\nmode = \"zip\"\n"}) {
    EXPECT_THAT(texts_of(read_scenario_text(text, "x.toml").sweep),
                testing::UnorderedElementsAre("world|landmarks = \"1:3\"", "|mode = \"zip\""))
        << text;
  }
  EXPECT_THAT(refusal_of(kLine + "[sweep]\n\"world.landmarks\" = [1]\nworld.landmarks = [2]\n"),
              AllOf(HasSubstr("x.toml:5: [sweep] world.landmarks = [2]: was given before"),
                    HasSubstr("x.toml:4: [sweep] world.landmarks = [1]")));
}

TEST(ReadScenario, OverridesAreTomlValuesOrElseWords) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"a.k=1", "a|k = 1"},
      {"a.k=0x10", "a|k = 16"},
      {"a.k=1.0", "a|k = 1.0"},
      {" a.k = true ", "a|k = true"},
      {"a.k=[1, 2]", "a|k = [1, 2]"},
      {"a.k=\"two words\"", "a|k = \"two words\""},
      {"a.k='b'", "a|k = \"b\""},
      {"a.k=word", "a|k = \"word\""},
      {"a.k=min-trace", "a|k = \"min-trace\""},
      {"a.k=two words", "a|k = \"two words\""},
      {"a.k=", "a|k = \"\""},
      {"a.k=b=c", "a|k = \"b=c\""},
      {"a.k=1\nb = 2", "a|k = \"1\\u000Ab = 2\""},
      {"a.k=1 # no comment", "a|k = 1"},
      {"a.b.k=1", "a|b.k = 1"},
  };
  for (const auto& [text, expected] : cases) {
    const std::vector<std::string> overrides = {text};
    EXPECT_THAT(texts_of(read_scenario_text("", "x.toml", overrides).settings), ElementsAre(expected))
        << text;
  }
}

// "10:10:50" is a time of day in TOML, and a range in a sweep.
TEST(ReadScenario, OverridesOfASweepAreNoTimesOfDay) {
  const std::vector<std::string> overrides = {"sweep.world.landmarks=10:10:50", "sweep.study.seed=[1, 2]",
                                              "sweep.mode=zip", "sweep.world.anchors=[1, 2]",
                                              "sweep.study.seed='1:4'"};
  EXPECT_THAT(texts_of(read_scenario_text("[sweep]\nworld.landmarks = [3]\n", "x.toml", overrides).sweep),
              ElementsAre("world|landmarks = \"10:10:50\"", "study|seed = \"1:4\"", "|mode = \"zip\"",
                          "world|anchors = [1, 2]"));
}

TEST(ReadScenario, AnOverrideStandsWhereItsKeyStoodAndTheLastWins) {
  const std::vector<std::string> overrides = {"b.y=7", "c.z=8", "b.y=9"};
  const ScenarioDocument read = read_scenario_text("[a]\nx = 1\n[b]\ny = 2\n", "x.toml", overrides);
  EXPECT_THAT(texts_of(read.settings), ElementsAre("a|x = 1", "b|y = 9", "c|z = 8"));
  EXPECT_THAT(places_of(read.settings), ElementsAre("x.toml:2: [a] x = 1", "--set b.y=9", "--set c.z=8"));
}

TEST(LoadScenario, RefusesWrongOverridesNamingTheOption) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"noise.measurement_variance=-1",
       {"--set noise.measurement_variance=-1: must be a finite number >= 0"}},
      {"noise.measurement_variance=nan", {"--set noise.measurement_variance=nan: ", "finite"}},
      {"noise.measurement_variance=", {"--set noise.measurement_variance=: ", "finite", "the string \"\""}},
      {"study.runs=many", {"--set study.runs=many: ", "integer from 1", "the string \"many\""}},
      {"study.runs=1e3", {"--set study.runs=1e3: ", "integer from 1", "the number 1000.0"}},
      {"study.runs=1\nseed = 3", {"--set study.runs=1", "integer from 1", "the string"}},
      {"study.run=1", {"--set study.run=1: ", "did you mean runs?"}},
      {"studdy.runs=1", {"--set studdy.runs=1: ", "did you mean [study]?"}},
      {"runs=1", {"--set runs=1: ", "section.key=value, did you mean study.runs?"}},
      {"measurement_scale=2",
       {"--set measurement_scale=2: ", "section.key=value, did you mean filter.measurement_scale?"}},
      {"qqqqqqqqqq=2", {"section.key=value, such as noise.process_variance=0.2"}},
      {"sweeep.world.landmarks=1:3", {"--set sweeep.world.landmarks=1:3: ", "did you mean [sweep]?"}},
      {"study.runs", {"--set study.runs: ", "section.key=value"}},
      {"", {"--set : ", "section.key=value"}},
      {"=1", {"--set =1: ", "section.key=value"}},
      {".runs=1", {"--set .runs=1: ", "section.key=value"}},
      {"study.=1", {"--set study.=1: ", "section.key=value"}},
      {"world.landmarks.x=1", {"--set world.landmarks.x=1: ", "unknown key"}},
      {"world.landmarks=[1, 2]", {"--set world.landmarks=[1, 2]: ", "integer", "the array [1, 2]"}},
      {"world.landmarks={a = 1}", {"--set world.landmarks={a = 1}: ", "integer", "a table"}},
  };
  for (const auto& [text, parts] : cases) {
    const std::string said = refusal_of(kLine, {text});
    for (const std::string& part : parts) EXPECT_THAT(said, HasSubstr(part)) << text;
  }
}

// The parser and its tables call themselves for each dot: tens of thousands would overflow the stack.
TEST(LoadScenario, KeysOfManyDotsAreRefused) {
  std::string dots = "a";
  for (int i = 0; i < 40'000; ++i) dots += ".a";
  const std::string head = "[world]\nmodel = \"monobot\"\n";
  for (const std::string& text : {"[sweep]\n" + dots + " = 1\n", "[" + dots + "]\nb = 1\n"}) {
    EXPECT_THAT(refusal_of(head + text), HasSubstr("more than 1000 dots"));
  }
  EXPECT_NO_THROW(load_scenario_text(head + "# " + std::string(500, '.') + "\n", "x.toml"));
  std::string quoted = "\"=\"";
  for (int i = 0; i < 40'000; ++i) quoted += i % 2 == 0 ? ".'#=\"'" : ".\"\\\"=\"";
  EXPECT_THAT(refusal_of(head + quoted + " = 1\n"), HasSubstr("x.toml:3: \"=\".'#=\"'"));
  EXPECT_THAT(refusal_of(head + quoted + " = 1\n"), HasSubstr("more than 1000 dots"));
  // 300 tables in one another, each by a key of 900 dots.
  std::string nested = "1";
  for (int i = 0; i < 300; ++i) nested = "[0, {" + dots.substr(0, 1801) + " = " + nested + "}]";
  EXPECT_THAT(refusal_of(head + "x = " + nested + "\n"), HasSubstr("more than 1000 dots"));
  // Dots of texts and comments are none of keys.
  const std::string many(2000, '.');
  EXPECT_THAT(refusal_of(head + "x = \"" + many + "\" # " + many + "\n"), HasSubstr("unknown key"));
  const std::string lines = "x = [\"\"\"\n'" + many + "\"\"\", '''" + many + "''']\n";
  EXPECT_THAT(refusal_of(head + lines), HasSubstr("unknown key"));
  EXPECT_THROW(
      load_scenario_text(head, "x.toml", std::vector<std::string>{"noise.process_variance={" + dots + "=1}"}),
      ScenarioError);
}

TEST(LoadScenario, FilesThatCannotBeRead) {
  const auto said = [](const std::filesystem::path& path) {
    try {
      load_scenario(path);
    } catch (const ScenarioError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const ScratchFile little(kLine);
  EXPECT_EQ(load_scenario(little.path()).name, "little");
  EXPECT_THAT(said(little.directory() / "missing.toml"),
              AllOf(HasSubstr("missing.toml"), HasSubstr("no such")));
  EXPECT_THAT(said(little.path() / "below.toml"), AllOf(HasSubstr("below.toml"), HasSubstr("no such")));
  EXPECT_THAT(said(little.directory()), HasSubstr("is a directory"));
  const auto pipe = little.directory() / "pipe.toml";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(said(pipe), HasSubstr("is a pipe"));
  EXPECT_THAT(said(""), HasSubstr("no such"));
  const auto loop = little.directory() / "loop.toml";
  std::filesystem::create_symlink("loop.toml", loop);
  EXPECT_EQ(said(loop), loop.string() + ": cannot be read (Too many levels of symbolic links)");
  const ScratchFile full(kLine + std::string((1 << 20) - kLine.size(), '#'));
  EXPECT_EQ(said(full.path()), "accepted") << "1 MiB, to the byte";
  const ScratchFile large(std::string((1 << 20) + 1, '#'));
  EXPECT_THAT(said(large.path()), HasSubstr("larger than 1 MiB"));
  std::filesystem::permissions(little.path(), std::filesystem::perms::none);
  if (!std::ifstream(little.path())) {  // root can read it nonetheless
    EXPECT_THAT(said(little.path()), HasSubstr("cannot be read"));
  }
}

}  // namespace
}  // namespace credence::internal
