#include "analysis/stability/unobservable_names.h"

#include <gmock/gmock.h>

#include <Eigen/QR>
#include <stdexcept>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;

constexpr BlockLayout kPlaneOfOne{.vehicle = 3, .landmark = 2, .landmarks = 1};

// A vehicle at (1, 2) with a heading of 0.3, a landmark at (4, 6).
const Vector kPointOfOne{{1.0, 2.0, 0.3, 4.0, 6.0}};

const Vector kShiftX{{1.0, 0.0, 0.0, 1.0, 0.0}}, kShiftY{{0.0, 1.0, 0.0, 0.0, 1.0}};

// One radian about (x, y): (−(p_y − y), p_x − x) of each point.
Vector turn_about(double x, double y) { return Vector{{y - 2.0, 1.0 - x, 1.0, y - 6.0, 4.0 - x}}; }

Matrix orthonormal_span(const std::vector<Vector>& directions) {
  Matrix columns(5, std::ssize(directions));
  for (Index j = 0; j < columns.cols(); ++j) columns.col(j) = directions[static_cast<std::size_t>(j)];
  const Matrix Q = columns.householderQr().householderQ();
  return Q.leftCols(columns.cols());
}

std::vector<std::string> texts_of(const std::vector<NamedDirection>& named) {
  std::vector<std::string> names;
  for (const NamedDirection& direction : named) names.push_back(direction.name);
  return names;
}

TEST(UnobservableNames, DirectionsAreThoseThatTheNamesSay) {
  const Matrix space = orthonormal_span({turn_about(7.0, -3.0), kShiftX, kShiftY});
  const std::vector<NamedDirection> named = name_unobservable(space, kPlaneOfOne, kPointOfOne);
  ASSERT_THAT(texts_of(named),
              ElementsAre("common translation x", "common translation y", "rotation about the origin"));
  EXPECT_LT((named[0].direction - kShiftX.normalized()).norm(), 1e-14);
  EXPECT_LT((named[1].direction - kShiftY.normalized()).norm(), 1e-14);
  EXPECT_LT((named[2].direction - turn_about(0.0, 0.0).normalized()).norm(), 1e-14);
  // Turns about two points of the x axis are one about the origin and a shift along y, which come first.
  const Matrix turns = orthonormal_span({turn_about(2.0, 0.0), turn_about(5.0, 0.0)});
  const Matrix anchors{{2.0, 5.0}, {0.0, 0.0}};
  EXPECT_THAT(texts_of(name_unobservable(turns, kPlaneOfOne, kPointOfOne, anchors)),
              ElementsAre("common translation y", "rotation about the origin"));
}

TEST(UnobservableNames, WhatIsLeftOfATurnTurnsAboutAPoint) {
  // Beside the shift along x a turn about (2, −1) may be about (2, y) for any y: the one that is orthogonal
  // to the shift has the mean height of both points, 4.
  const Matrix space = orthonormal_span({turn_about(2.0, -1.0), kShiftX});
  EXPECT_THAT(texts_of(name_unobservable(space, kPlaneOfOne, kPointOfOne)),
              ElementsAre("common translation x", "rotation about the point (2, 4)"));
  const Matrix anchor{{2.0}, {-1.0}};
  const std::vector<NamedDirection> anchored = name_unobservable(space, kPlaneOfOne, kPointOfOne, anchor);
  ASSERT_THAT(texts_of(anchored), ElementsAre("common translation x", "rotation about the anchor (2, -1)"));
  EXPECT_LT((anchored[1].direction - turn_about(2.0, -1.0).normalized()).norm(), 1e-14);
  // Without the states of the linearisation point no turn is looked for: (−2, 2.5, 1, −6, 5.5)/√77.5.
  EXPECT_THAT(texts_of(name_unobservable(turn_about(-1.5, 0.0).normalized(), kPlaneOfOne)),
              ElementsAre("-0.68 f1x, 0.62 f1y, 0.28 y, -0.23 x, …"));
}

TEST(UnobservableNames, ASymmetryCountsWithinTheTolerance) {
  // (1, t, …) is off the shift along x by a sine of t/√2.
  const auto names = [](double tilt) {
    Vector tilted = kShiftX;
    tilted[2] = tilt;
    return texts_of(name_unobservable(tilted.normalized(), kPlaneOfOne, kPointOfOne));
  };
  EXPECT_THAT(names(1.3e-6), ElementsAre("common translation x"));
  EXPECT_THAT(names(1.7e-6), ElementsAre(::testing::StartsWith("0.71 ")));
}

TEST(UnobservableNames, ListsTheLargestComponents) {
  const std::vector<std::string> states = {"a", "b", "c", "d", "e"};
  const Vector many = Vector{{1.0, -5.0, 3.0, 2.0, 4.0}} / std::sqrt(55.0);
  EXPECT_THAT(texts_of(name_unobservable(many, states)), ElementsAre("-0.67 b, 0.54 e, 0.40 c, 0.27 d, …"));
  // Below a hundredth of the largest nothing is listed.
  const Vector few = Vector{{1.0, 0.0099, 0.0101, 0.0, 0.0}};
  EXPECT_THAT(texts_of(name_unobservable(few, states)), ElementsAre("1.00 a, 0.01 c"));
  EXPECT_THAT(state_names({.vehicle = 1, .landmark = 1, .landmarks = 2}), ElementsAre("r", "f1", "f2"));
  EXPECT_THAT(state_names(kPlaneOfOne), ElementsAre("x", "y", "heading", "f1x", "f1y"));
  EXPECT_THAT(state_names({.vehicle = 2, .landmark = 1, .landmarks = 1}), ElementsAre("x1", "x2", "x3"));
}

TEST(UnobservableNames, SizesThatDoNotMatchAreNamed) {
  const auto message = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_EQ(message([] { name_unobservable(Matrix::Identity(4, 1), kPlaneOfOne); }),
            "directions have 4 components and the layout 5 states");
  EXPECT_EQ(message([] { name_unobservable(Matrix::Identity(5, 1), kPlaneOfOne, Vector::Zero(3)); }),
            "the linearisation point has 3 states, not 5");
  EXPECT_EQ(message([] {
              name_unobservable(Matrix::Identity(5, 1), kPlaneOfOne, kPointOfOne, Matrix::Zero(3, 1));
            }),
            "anchors have 3 rows and must have 2");
  EXPECT_EQ(message([] { name_unobservable(Matrix::Identity(2, 1), std::vector<std::string>{"a"}); }),
            "directions have 2 components and there are 1 names");
}

}  // namespace
}  // namespace credence::internal
