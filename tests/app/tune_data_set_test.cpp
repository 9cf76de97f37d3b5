// `credence tune carpark` and `credence tune mrclam`.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/app/command.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

class TuneDataSet : public CommandTest {};

TEST_F(TuneDataSet, OfADataSetIsJudgedOnWhatWasLeftOut) {
  CREDENCE_DATA_OR_SKIP(data, "carpark");
  const Json j = json({"tune", "carpark", "--data", data.string(), "--free", " noise.range_std ", "--quiet",
                       "--format", "json"});
  EXPECT_EQ(j["parameters"][0]["name"], "noise.range_std");
  EXPECT_EQ(j["held_out"]["parts"].size(), 5U);
  EXPECT_EQ(j["held_out"]["before"]["verdict"], "pessimistic");
  EXPECT_TRUE(j["held_out"]["whiteness_p_value"].is_number());
  const Finished f = run({"tune", "carpark", "--data", data.string(), "--free", "R"});
  EXPECT_EQ(f.code, 2);
  EXPECT_NE(f.err.find("noise.range_std"), std::string::npos) << f.err;
  EXPECT_EQ(run({"tune", "carpark", "--data", data.string(), "--runs", "3"}).code, 2);
}

TEST_F(TuneDataSet, WhatHasNoMeaningForItIsRefused) {
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--write", "tuned.toml"},
                                                 {"--runs", "2"},
                                                 {"--steps", "2"},
                                                 {"--seed", "2"}}) {
    const Finished f = run({"tune", "carpark", "--data", ".", option[0], option[1]});
    EXPECT_EQ(f.code, 2);
    EXPECT_EQ(f.err,
              "credence: a data set is no scenario: --write, --runs, --steps and --seed have no meaning for "
              "it\n");
  }
  EXPECT_EQ(run({"tune", "mrclam", "--data", "."}).err, "credence: --data: there is no robot's log in it\n");
  EXPECT_EQ(run({"tune", "mrclam", "--data", ".", "--robot", "6"}).err,
            "credence: tune: --robot 6: accepted are whole numbers from 1 to 5 (credence help tune)\n");
}

}  // namespace
}  // namespace credence::internal
