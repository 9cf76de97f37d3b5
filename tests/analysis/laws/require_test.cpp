#include "analysis/laws/require.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

std::string complaint_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

constexpr double kLeast = std::numeric_limits<double>::denorm_min();
constexpr double kEndless = std::numeric_limits<double>::infinity();
const double kBelowOne = std::nextafter(1.0, 0.0);

TEST(Require, TakesWhatLiesWithin) {
  for (const double good : {kLeast, 0.5, kBelowOne}) {
    EXPECT_EQ(complaint_of([&] { require_confidence(good); }), "");
    EXPECT_EQ(complaint_of([&] { require_fraction("share", good); }), "");
  }
  for (const double good : {0.0, 0.5, 1.0}) EXPECT_EQ(complaint_of([&] { require_probability(good); }), "");
  for (const double good : {kLeast, 1e300}) EXPECT_EQ(complaint_of([&] { require_positive("x", good); }), "");
}

TEST(Require, RefusesWhatDoesNot) {
  for (const double bad : {0.0, 1.0, -0.5, 95.0, kEndless, std::nan("")}) {
    EXPECT_NE(complaint_of([&] { require_confidence(bad); }), "") << bad;
    EXPECT_NE(complaint_of([&] { require_fraction("share", bad); }), "") << bad;
  }
  for (const double bad : {-kLeast, std::nextafter(1.0, 2.0), kEndless, std::nan("")}) {
    EXPECT_NE(complaint_of([&] { require_probability(bad); }), "") << bad;
  }
  for (const double bad : {0.0, -1.0, kEndless, -kEndless, std::nan("")}) {
    EXPECT_NE(complaint_of([&] { require_positive("x", bad); }), "") << bad;
  }
}

TEST(Require, NamesTheValue) {
  using ::testing::HasSubstr;
  EXPECT_THAT(complaint_of([] { require_confidence(1.5); }), HasSubstr("confidence = 1.5"));
  EXPECT_THAT(complaint_of([] { require_probability(-0.25); }), HasSubstr("probability = -0.25"));
  EXPECT_THAT(complaint_of([] { require_fraction("share", 2.0); }), HasSubstr("share = 2"));
  EXPECT_THAT(complaint_of([] { require_positive("dof", -3.0); }), HasSubstr("dof = -3"));
}

}  // namespace
}  // namespace credence::internal
