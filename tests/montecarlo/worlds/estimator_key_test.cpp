#include "montecarlo/worlds/estimator_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "tests/montecarlo/scenario/scenario_refusal.h"

namespace credence::internal {
namespace {

using testing::HasSubstr;

const std::vector<std::string_view>& words_of_key() {
  static const KeyRow row = estimator_key();
  return std::get<ChoiceField>(row.field).words;
}

TEST(EstimatorKey, HasTheWordsOfAllWorldsOnce) {
  const std::set<std::string_view> unique(words_of_key().begin(), words_of_key().end());
  EXPECT_EQ(unique.size(), words_of_key().size());
  std::set<std::string_view> offered;
  for (const EstimatorOffer* offer : {&kPlanarSlamOffer, &kSpatialOffer, &kLinearOffer}) {
    for (const std::string_view name : offer->names(nullptr)) offered.insert(name);
  }
  EXPECT_EQ(unique, offered);
  for (const std::string_view word : words_of_key()) {
    EXPECT_THAT(std::string(estimator_key().meaning), HasSubstr(std::string(word))) << "is explained";
  }
}

TEST(EstimatorKey, AnyOfThemMayBeADefault) {
  for (const std::string_view word : words_of_key()) {
    Scenario scenario;
    set_estimator(scenario, word);
    EXPECT_EQ(word_value(scenario, "filter.estimator"), word);
  }
}

TEST(EstimatorKey, ThatOfAnotherWorldIsRefusedWithThoseOfThisOne) {
  const auto refusal = [](const std::string& model, const std::string& estimator) -> std::string {
    return scenario_refusal([&] {
      load_scenario_text("[world]\nmodel = \"" + model + "\"\n", "t.toml",
                         std::vector<std::string>{"filter.estimator=" + estimator});
    });
  };
  EXPECT_EQ(refusal("planar_slam", "invariant"), "accepted");
  EXPECT_EQ(refusal("spatial_slam", "ekf-se3"), "accepted");
  EXPECT_THAT(refusal("planar_slam", "kalman"),
              HasSubstr("--set filter.estimator=kalman: must be one of \"ekf\""));
  EXPECT_THAT(refusal("planar_slam", "kalman"), HasSubstr("in this world"));
  EXPECT_THAT(refusal("planar_slam", "ekf-se3"), HasSubstr("must be one of"));
  EXPECT_THAT(refusal("spatial_slam", "ukf"), HasSubstr("\"ekf-se3\""));
}

}  // namespace
}  // namespace credence::internal
