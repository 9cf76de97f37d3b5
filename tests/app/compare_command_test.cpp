// `credence compare` as a user types it.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/command.h"
#include "tests/app/small_studies.h"

namespace credence::internal {
namespace {

class CompareCommand : public CommandTest {};

TEST_F(CompareCommand, CompareSetsVerdictsBesideEachOtherAndPairsRunsOfTheSameNoise) {
  write("a.toml", kMonobot);
  const Json first = json({"run", "a.toml", "--out", "a", "--format", "json"});
  ASSERT_EQ(run({"run", "a.toml", "--out", "b", "--set", "filter.measurement_scale=2.0"}).code, 0);
  ASSERT_EQ(run({"run", "a.toml", "--out", "c", "--seed", "2"}).code, 0);
  const Json studies = json({"compare", "a", "b", "c", "a", "--format", "json"})["studies"];
  ASSERT_EQ(studies.size(), 4U);
  EXPECT_EQ(studies[0]["verdict"], "consistent");
  EXPECT_EQ(studies[1]["verdict"], "pessimistic");
  EXPECT_EQ(studies[0]["nees"]["mean"], first["nees"]["mean"]);
  EXPECT_EQ(studies[1]["name"], "a (b)") << "two of one name are told apart";
  const double dof = first["nees"]["expected"];
  const double difference =
      (studies[1]["nees"]["mean"].get<double>() - studies[0]["nees"]["mean"].get<double>()) / dof;
  EXPECT_NEAR(studies[1]["paired_difference"]["value"].get<double>(), difference, 1e-12);
  EXPECT_LT(studies[1]["paired_difference"]["upper"], 0.0);
  EXPECT_TRUE(studies[2]["paired_difference"].is_null()) << "another seed is other noise";
  EXPECT_EQ(studies[3]["paired_difference"]["lower"], 0.0) << "itself";

  write("a.json", first.dump());
  const Json documents = json({"compare", "a.json", "b", "--format", "json"})["studies"];
  EXPECT_EQ(documents[0]["nees"]["mean"], first["nees"]["mean"]);
  EXPECT_NE(run({"compare", "a", "b"}).out.find("against the first"), std::string::npos);
  EXPECT_EQ(run({"compare", "a"}).code, 2);
  write("no.json", "{\"schema\": 1}");
  EXPECT_NE(run({"compare", "a", "no.json"}).err.find("no.json: is not a document of"), std::string::npos);
}

TEST_F(CompareCommand, WhatCannotBeComparedIsRefusedByName) {
  write("a.toml", kMonobot);
  write("s.toml", kMonobotSweep);
  write("empty.json", "{\"schema\": 1, \"studies\": []}");
  ASSERT_EQ(run({"run", "a.toml", "--out", "a", "--quiet"}).code, 0);
  ASSERT_EQ(run({"sweep", "s.toml", "--runs", "64", "--out", "s", "--quiet"}).code, 0);
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"compare", "a"}, "compare: takes two results or more"},
      {{"compare", "a", "s"},
       "compare: s is a sweep and a is none: compare sweeps with sweeps, and runs with runs"},
      {{"compare", "a", "nowhere"}, "nowhere: no such folder or document"},
      {{"compare", "a", "a.toml"}, "a.toml:1: is no JSON, from column 2 on"},
      {{"compare", "a", "/dev/zero"}, "/dev/zero: is no regular file"},
      {{"compare", "a", "pipe"}, "pipe: is no regular file"},
      {{"compare", "empty.json", "a"}, "empty.json: holds no results to compare"},
      {{"compare", "s"}, "compare: takes two results or more"}};
  for (const auto& [arguments, message] : cases) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2) << message;
    EXPECT_EQ(f.out, "") << message;
    EXPECT_EQ(f.err, "credence: " + message + "\n");
  }
}

TEST_F(CompareCommand, APipeOfTheShellIsReadToItsEndOrTheLimit) {
  write("a.toml", kMonobot);
  write("a.json", json({"run", "a.toml", "--format", "json", "--quiet"}).dump());
  const auto from = [&](const std::string& source) {
    return finish(start_program({"sh", "-c",
                                 source + " | " + credence_binary().string() +
                                     " compare a.json /dev/stdin > out 2> err"}))
        .code;
  };
  EXPECT_EQ(from("cat a.json"), 0) << read("err");
  EXPECT_EQ(from("cat /dev/zero"), 2);
  EXPECT_EQ(read("err"), "credence: /dev/stdin: is longer than 256 MiB, as no document is\n");
}

TEST_F(CompareCommand, SweepsAreComparedConfigurationByConfiguration) {
  write("s.toml", kMonobotSweep);
  const std::vector<std::string> sweep = {"sweep", "s.toml", "--runs", "64", "--quiet", "--format", "json"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = sweep;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json(arguments);
  };
  const Json a = with({"--out", "a"});
  with({"--out", "b", "--set", "filter.measurement_scale=4.0"});
  write("a.json", a.dump());
  write("seed.json", with({"--out", "seed", "--seed", "7"}).dump());
  const std::size_t n = a["configurations"].size();
  ASSERT_GT(n, 1U);

  // The same noise: run by run.
  const Json paired = json({"compare", "a", "b", "--format", "json"})["studies"];
  ASSERT_EQ(paired.size(), 2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(paired[i]["configuration"], paired[n + i]["configuration"]);
    EXPECT_TRUE(paired[i]["paired_difference"].is_null());
    EXPECT_LT(paired[n + i]["paired_difference"]["upper"], 0.0);
    EXPECT_TRUE(paired[n + i]["changes"].empty());
  }
  EXPECT_NE(run({"compare", "a", "b"}).out.find(fmt::format("{} differ", n)), std::string::npos);

  // Of documents, and of other noise, by the intervals of the factors.
  const Json documents = json({"compare", "a.json", "seed.json", "--format", "json"})["studies"];
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(documents[n + i]["changes"].size(), 1U);
    EXPECT_GT(documents[n + i]["changes"][0]["adjusted_p_value"], 1e-3);
  }
  EXPECT_EQ(json({"compare", "a", "seed.json", "--format", "json"})["studies"][n]["changes"],
            documents[n]["changes"]);
}

TEST_F(CompareCommand, MoreConfidenceIsAWiderIntervalAroundTheSameDifference) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "a", "--quiet"}).code, 0);
  ASSERT_EQ(run({"run", "a.toml", "--out", "b", "--set", "filter.measurement_scale=2.0", "--quiet"}).code, 0);
  const auto difference = [&](const char* confidence) {
    return json({"compare", "a", "b", "--confidence", confidence, "--format",
                 "json"})["studies"][1]["paired_difference"];
  };
  const Json some = difference("0.8"), more = difference("0.99");
  EXPECT_EQ(some["value"], more["value"]);
  // NEES of half the size differs by values with a long tail below, where the interval reaches further
  // (Hall). Above it is Student's: the quantile at 0.99 of a normal law is 2.576 and at 0.8 it is 1.2816; of
  // a t of 299 degrees 2.592 and 1.284.
  const auto reach = [](const Json& d, const char* end) {
    return std::abs(d[end].get<double>() - d["value"].get<double>());
  };
  EXPECT_NEAR(reach(more, "upper") / reach(some, "upper"), 2.592 / 1.284, 0.002);
  for (const Json& d : {some, more}) EXPECT_GT(reach(d, "lower"), reach(d, "upper"));
}

TEST_F(CompareCommand, TheReportSetsThemSideBySide) {
  write("a.toml", kMonobot);
  ASSERT_EQ(run({"run", "a.toml", "--out", "a", "--quiet"}).code, 0);
  const Finished f = run({"compare", "a", "a", "--out", "page"});
  EXPECT_EQ(f.code, 0) << f.err;
  EXPECT_EQ(f.err, "Report: page/index.html\n");
  EXPECT_NE(read("page/index.html").find("<svg"), std::string::npos);
}

}  // namespace
}  // namespace credence::internal
