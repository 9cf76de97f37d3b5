#include "core/models/linear_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace credence::internal {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(LinearModel, MonobotIsThatOfThePaper) {
  // [Vidal-Calleja 2004], eqs (13)-(15), with N = 2.
  const LinearModel model = monobot_model(2, 0, 0.1, 0.2, 3.0);
  Matrix H(2, 3);
  H << -1, 1, 0, -1, 0, 1;
  EXPECT_EQ(model.H, H);
  EXPECT_EQ(model.F, Matrix(Matrix::Identity(3, 3)));
  EXPECT_EQ(model.G, Matrix(Vector::Unit(3, 0)));
  EXPECT_EQ(model.Q, Matrix(Matrix::Constant(1, 1, 0.1)));
  EXPECT_EQ(model.R, Matrix(0.2 * Matrix::Identity(2, 2)));
  EXPECT_EQ(model.P0, Matrix(3.0 * Matrix::Identity(3, 3)));
  EXPECT_EQ(model.state_dim(), 3);
  EXPECT_EQ(model.measurement_dim(), 2);
  EXPECT_EQ(model.layout.vehicle, 1);
  EXPECT_EQ(model.layout.landmark, 1);
  EXPECT_EQ(model.layout.landmarks, 2);
}

TEST(LinearModel, AnchorsAreTheFirstRows) {
  const LinearModel model = monobot_model(2, 1, 0.1, 0.1, 1.0);
  // z less the anchor's place is −r.
  const Vector x = Eigen::Vector3d(2.0, 5.0, 9.0);
  EXPECT_EQ(Vector(model.H * x), Vector(Eigen::Vector3d(-2.0, 3.0, 7.0)));
  EXPECT_EQ(model.R.rows(), 3);
  EXPECT_EQ(monobot_model(0, 2, 0.1, 0.1, 1.0).H, Matrix(Matrix::Constant(2, 1, -1.0)));
}

TEST(LinearModel, RepeatsItsPeriodFromStepOneOn) {
  const std::vector<LinearModel> period = {monobot_model(1, 0, 1.0, 1.0, 1.0),
                                           monobot_model(2, 0, 1.0, 1.0, 1.0),
                                           monobot_model(3, 0, 1.0, 1.0, 1.0)};
  const Index expected[] = {1, 2, 3, 1, 2, 3, 1};
  for (Index k = 1; k <= 7; ++k) EXPECT_EQ(model_at(period, k).layout.landmarks, expected[k - 1]) << k;
}

TEST(LinearModel, RefusesWhatCannotBe) {
  const auto refused = [](const char* text) { return ThrowsMessage<std::invalid_argument>(HasSubstr(text)); };
  EXPECT_THAT([] { monobot_model(0, 0, 1, 1, 1); }, refused("landmarks = 0, anchors = 0"));
  EXPECT_THAT([] { monobot_model(-1, 2, 1, 1, 1); }, refused("landmarks = -1"));
  EXPECT_THAT([] { monobot_model(2, -1, 1, 1, 1); }, refused("anchors = -1"));
  EXPECT_THAT([] { monobot_model(1, 0, -0.5, 1, 1); }, refused("process_variance = -0.5 must be"));
  EXPECT_THAT([] { monobot_model(1, 0, 1, std::nan(""), 1); }, refused("measurement_variance = nan"));
  EXPECT_THAT([] { monobot_model(1, 0, 1, 1, std::numeric_limits<double>::infinity()); },
              refused("initial_variance = inf"));
  EXPECT_NO_THROW(monobot_model(1, 0, 0.0, 0.0, 0.0)) << "singular is legal";
}

}  // namespace
}  // namespace credence::internal
