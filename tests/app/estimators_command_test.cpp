// `credence estimators` as a user types it: the built binary, its document, its page, its exit codes.

#include <gtest/gtest.h>

#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command.h"

namespace credence::internal {
namespace {

class EstimatorsCommand : public CommandTest {};

TEST_F(EstimatorsCommand, GivesTheDocumentOfTheContract) {
  const Json j = json({"estimators", scenario_file("ukfm_slam2d"), "--runs", "16", "--steps", "300",
                       "--estimators", "ekf,invariant,fej", "--format", "json"});
  EXPECT_EQ(j["schema"], 1);
  EXPECT_EQ(j["scenario"]["world"]["model"], "planar_slam");
  EXPECT_EQ(j["runs"], 16);
  EXPECT_EQ(j["complete"], true);
  ASSERT_EQ(j["rows"].size(), 3U);
  EXPECT_EQ(j["rows"][1]["estimator"], "invariant");
  EXPECT_EQ(j["rows"][1]["chart"], "right_invariant");
  EXPECT_EQ(j["rows"][0]["unobservable"], 2);
  EXPECT_GT(j["bound"]["position_m"].get<double>(), 0.0);
  for (const Json& row : j["rows"]) {
    for (const char* block : {"pose", "heading", "position", "map"}) {
      for (const char* key : {"mean", "lower", "upper"})
        EXPECT_TRUE(row["nees"][block][key].is_number()) << key;
      EXPECT_EQ(row["nees"][block]["quantiles"].size(), j["quantile_levels"].size());
    }
    EXPECT_TRUE(row["rmse"]["heading_rad"].is_number());
    EXPECT_TRUE(row["rmse"]["position_m"].is_number());
    EXPECT_GT(row["seconds_per_step"].get<double>(), 0.0);
    for (const char* of : {"heading", "position"})
      EXPECT_GT(row["efficiency"][of]["mean"].get<double>(), 0.0) << of;
    EXPECT_GT(row["claimed_rmse"]["position_m"].get<double>(), 0.0);
    EXPECT_EQ(row["runs"], 16);
    EXPECT_EQ(row["failed"], 0);
    EXPECT_EQ(row["pose_nees_over_time"].size(), j["window_ends"].size());
  }
  // In the plane's own chart nothing is transported.
  EXPECT_EQ(j["rows"][0]["nees"]["pose"]["mean"], j["rows"][0]["nees_other_chart"]["pose"]["mean"]);
  EXPECT_NE(j["rows"][1]["nees"]["pose"]["mean"], j["rows"][1]["nees_other_chart"]["pose"]["mean"]);
  ASSERT_EQ(j["paired"].size(), 6U);
  for (const char* key : {"first", "second", "difference", "lower", "upper", "p_value"}) {
    EXPECT_TRUE(j["paired"][0].contains(key)) << key;
  }
}

TEST_F(EstimatorsCommand, WhatItLeavesAsideIsSaid) {
  const Finished f = run({"estimators", scenario_file("linear_estimators"), "--runs", "4", "--steps", "5",
                          "--quiet", "--set", "study.stop.max_runs=3", "--set", "filter.estimator=kalman"});
  EXPECT_NE(f.err.find("linear_estimators: estimators leaves [study.stop] aside"), std::string::npos)
      << f.err;
  EXPECT_NE(f.err.find("--set filter.estimator=kalman is left aside: --estimators"), std::string::npos)
      << f.err;
  const Finished plain =
      run({"estimators", scenario_file("linear_estimators"), "--runs", "4", "--steps", "5", "--quiet"});
  EXPECT_EQ(plain.err.find("aside"), std::string::npos) << plain.err;
}

TEST_F(EstimatorsCommand, TextAndPage) {
  const Finished f =
      run({"estimators", scenario_file("huang_ring"), "--runs", "8", "--steps", "60", "--out", "page"});
  ASSERT_EQ(f.code, 0) << f.err;
  for (const char* word : {"invariant", "unobservable", "gain of pairing", "Cramér-Rao"}) {
    EXPECT_NE(f.out.find(word), std::string::npos) << word;
  }
  EXPECT_NE(read("page/index.html").find("<svg"), std::string::npos);
  EXPECT_NE(read("page/index.html").find("Estimators in huang_ring"), std::string::npos);
}

// A sweep gives the map of what is enough where.
TEST_F(EstimatorsCommand, MapsASweep) {
  const std::vector<std::string> common = {
      "estimators",   scenario_file("estimator_map"), "--runs", "4", "--steps", "60", "--estimators",
      "ekf,invariant"};
  std::vector<std::string> as_json = common, as_page = common;
  as_json.insert(as_json.end(), {"--format", "json"});
  const Json j = json(as_json);
  ASSERT_EQ(j["points"].size(), 16U);
  ASSERT_EQ(j["estimators"].size(), 2U);
  EXPECT_EQ(j["estimators"][1]["estimator"], "invariant");
  EXPECT_TRUE(j["points"][0]["values"].contains("world.landmarks"));
  EXPECT_EQ(j["points"][0]["study"]["rows"].size(), 2U);
  EXPECT_EQ(j["points"][0]["estimators"][1]["estimator"], "invariant");
  EXPECT_GT(j["tolerated_factor"], 1.0);
  as_page.insert(as_page.end(), {"--out", "map"});
  const Finished f = run(as_page);
  ASSERT_EQ(f.code, 0) << f.err;
  EXPECT_NE(f.out.find("cheapest"), std::string::npos);
  EXPECT_NE(read("map/index.html").find("<svg"), std::string::npos);
}

TEST_F(EstimatorsCommand, RefusesOtherWorldsAndNames) {
  const Finished twice = run({"estimators", scenario_file("huang_ring"), "--estimators", "ekf,fej,ekf"});
  EXPECT_EQ(twice.code, 2);
  EXPECT_NE(twice.err.find("--estimators: ekf is named twice"), std::string::npos) << twice.err;
  const Finished planar = run({"estimators", scenario_file("planar_loop")});
  EXPECT_EQ(planar.code, 2);
  EXPECT_NE(planar.err.find("planar_loop.toml: world.model = \"planar\""), std::string::npos) << planar.err;
  const Finished magic = run({"estimators", scenario_file("huang_ring"), "--estimators", "magic"});
  EXPECT_EQ(magic.code, 2);
  EXPECT_NE(magic.err.find("magic"), std::string::npos);
}

// A failed run is exit code 3; an optimistic or pessimistic estimator is 1 where that is asked for.
TEST_F(EstimatorsCommand, ExitCodesSayWhatWasFound) {
  const Finished failed =
      run({"estimators", scenario_file("huang_annulus"), "--runs", "8", "--steps", "400", "--estimators",
           "ekf", "--set", "noise.turn_rate_std=1", "--set", "noise.speed_std=2"});
  EXPECT_EQ(failed.code, 3) << failed.err;
  // What it says can be typed, and plays a run that fails.
  const std::size_t begin = failed.out.find("`credence run ");
  ASSERT_NE(begin, std::string::npos) << failed.out;
  std::istringstream words(failed.out.substr(begin + 10, failed.out.find('`', begin + 1) - begin - 10));
  const Finished replayed = run({std::istream_iterator<std::string>(words), {}});
  EXPECT_EQ(replayed.code, 3) << replayed.err;
  EXPECT_NE(replayed.out.find("diverged"), std::string::npos) << replayed.out;
  const Finished optimistic = run({"estimators", scenario_file("huang_annulus"), "--runs", "32",
                                   "--estimators", "ekf", "--fail-on-inconsistent"});
  EXPECT_EQ(optimistic.code, 1);
  const auto ring = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"estimators", scenario_file("huang_ring"), "--fail-on-inconsistent", "--quiet"});
    return run(more);
  };
  const Finished pessimistic = ring({"--runs", "24", "--steps", "60", "--estimators", "ekf", "--set",
                                     "filter.process_scale=25", "--set", "filter.measurement_scale=25"});
  EXPECT_EQ(pessimistic.code, 1);
  EXPECT_NE(pessimistic.out.find("Pessimistic in the pose: ekf"), std::string::npos) << pessimistic.out;
  // One of fifteen, optimistic by its own interval and not among all.
  const Finished chance = ring({"--runs", "24", "--steps", "6", "--seed", "2"});
  EXPECT_EQ(chance.code, 0) << chance.out;
  EXPECT_NE(chance.out.find("Inconsistent alone, but not among so many"), std::string::npos) << chance.out;
}

// What is not asked for by its name and cannot be had is left out, and said.
TEST_F(EstimatorsCommand, LeavesOutWhatRefusesTheScenario) {
  const std::vector<std::string> misses = {"estimators", scenario_file("linear_estimators"), "--runs", "8",
                                           "--set",      "noise.detection_probability=0.8"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), misses.begin(), misses.end());
    return more;
  };
  const Json j = json(with({"--format", "json"}));
  EXPECT_EQ(j["rows"].size(), 1U);
  EXPECT_EQ(j["left_out"].back()["estimator"], "own-gain");
  EXPECT_NE(run(misses).out.find("smoother is left out: filter.estimator = \"smoother\" needs every"),
            std::string::npos);
  EXPECT_EQ(run(with({"--estimators", "kalman,smoother"})).code, 2);
}

}  // namespace
}  // namespace credence::internal
