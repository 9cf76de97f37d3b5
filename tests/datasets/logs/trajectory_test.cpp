#include "datasets/logs/trajectory.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "datasets/data_error.h"
#include "datasets/logs/trajectory_errors.h"
#include "tests/datasets/data_folder.h"

namespace credence::internal {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// R of a rotation vector.
Quaterniond rotation_exp(const Vector3d& v) {
  return v.norm() == 0.0 ? Quaterniond::Identity() : Quaterniond(AngleAxisd(v.norm(), v.normalized()));
}

std::string pose_text(double t, const SpatialPose& pose, const char* separator = " ") {
  const Vector3d& p = pose.position;
  const Quaterniond& q = pose.orientation;
  return fmt::format("{1}{0}{2}{0}{3}{0}{4}{0}{5}{0}{6}{0}{7}{0}{8}", separator, t, p.x(), p.y(), p.z(),
                     q.x(), q.y(), q.z(), q.w());
}

/// Poses along a curve, one every 0.1 s.
std::vector<SpatialPose> curve(int count) {
  std::vector<SpatialPose> poses;
  for (int i = 0; i < count; ++i) {
    const double t = 0.1 * i;
    poses.push_back(
        {Vector3d(std::cos(t), 2.0 * std::sin(t), 0.3 * t), rotation_exp(Vector3d(0.2 * t, -0.1, t))});
  }
  return poses;
}

const Vector3d kPositionError(0.3, -0.2, 0.1), kTilt(0.02, -0.05, 0.03);

class TrajectoryFiles : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }

  std::filesystem::path write_truth(const std::vector<SpatialPose>& poses) const {
    std::string text = "# t x y z qx qy qz qw\n";
    for (std::size_t i = 0; i < poses.size(); ++i)
      text += pose_text(0.1 * static_cast<double>(i), poses[i]) + "\n";
    return write("truth.txt", text);
  }

  TemporaryFolder folder_;
};

TEST(RotationLog, InvertsTheExponentialUpToHalfATurn) {
  for (const double angle : {0.0, 1e-12, 1e-7, 0.3, 2.0, 3.1415}) {
    const Vector3d v = angle * Vector3d(1, -2, 2) / 3.0;
    EXPECT_LT((rotation_log(rotation_exp(v)) - v).norm(), 1e-12) << angle;
    Quaterniond minus = rotation_exp(v);
    minus.coeffs() *= -1.0;  // the same rotation
    EXPECT_LT((rotation_log(minus) - v).norm(), 1e-12) << angle;
  }
}

TEST_F(TrajectoryFiles, OpenVinsHasTheRotationBlockFirstAndErrorsInTheBody) {
  const auto truth = curve(5);
  std::string text = "# timestamp(s) tx ty tz qx qy qz qw Pr11 …\n";
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SpatialPose estimate{truth[i].position + kPositionError,
                               truth[i].orientation * rotation_exp(kTilt)};
    text += pose_text(0.1 * static_cast<double>(i), estimate) + " 1 0.1 0.2 2 0.3 3 10 1 2 20 3 30\n";
  }
  const Trajectory estimate = read_estimate(write("e.txt", text), TrajectoryFormat::openvins, {});
  const TrajectoryErrors errors = trajectory_errors(estimate, read_truth(write_truth(truth)), {});
  EXPECT_FALSE(errors.layout.joint_covariance);
  ASSERT_EQ(errors.rows.size(), 5U);
  double way_m = 0.0;
  for (std::size_t i = 0; i < 5; ++i) {
    if (i > 0) way_m += (truth[i].position - truth[i - 1].position).norm();
    EXPECT_NEAR(errors.travelled_m.at(i), way_m, 1e-9);
  }
  for (const Step& row : errors.rows) {
    EXPECT_LT((row.error.head<3>() - kPositionError).norm(), 1e-12);
    EXPECT_LT((row.error.tail<3>() - kTilt).norm(), 1e-12);
    EXPECT_EQ(row.P(0, 0), 10.0);
    EXPECT_EQ(row.P(1, 2), 3.0);
    EXPECT_EQ(row.P(5, 4), 0.3);
    EXPECT_EQ(row.P(3, 5), 0.2);
    EXPECT_EQ(row.P(0, 3), 0.0);
  }
}

TEST_F(TrajectoryFiles, TumHoldsAJointCovarianceWithErrorsInTheAxesThatOneNames) {
  const auto truth = curve(3);
  std::string text;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SpatialPose estimate{truth[i].position, rotation_exp(kTilt) * truth[i].orientation};
    text += pose_text(0.1 * static_cast<double>(i), estimate);
    for (int c = 1; c <= 21; ++c) text += fmt::format(" {}", c);
    text += "\n";
  }
  const auto file = write("e.txt", text);
  const Trajectory truth_read = read_truth(write_truth(truth));
  const Trajectory world =
      read_estimate(file, TrajectoryFormat::tum, {.orientation = OrientationError::world});
  const Trajectory body = read_estimate(file, TrajectoryFormat::tum, {});
  const Step in_world = trajectory_errors(world, truth_read, {}).rows.at(2);
  const Step in_body = trajectory_errors(body, truth_read, {}).rows.at(2);
  EXPECT_LT((in_world.error.tail<3>() - kTilt).norm(), 1e-12);
  EXPECT_LT((in_body.error.tail<3>() - truth[2].orientation.conjugate() * kTilt).norm(), 1e-12);
  EXPECT_EQ(in_world.P(0, 5), 6.0);
  EXPECT_EQ(in_world.P(1, 1), 7.0);
  EXPECT_EQ(in_world.P(5, 5), 21.0);
}

TEST_F(TrajectoryFiles, ACsvOfPosesHoldsTheWholeCovariance) {
  const std::string header = "stamp_sec,stamp_nsec,x,y,z,qx,qy,qz,qw";
  const auto file_with = [&](const std::string& entry_1_0) {
    std::string text = header, row;
    for (int i = 0; i < 36; ++i) {
      text += fmt::format(",cov{}", i);
      row += fmt::format(",{}", i == 6 ? entry_1_0 : i == 1 ? "0.5" : i % 7 == 0 ? "2" : "0");
    }
    return write("e.csv", text + "\n1700000000,250000000,1,2,3,0,0,0,1" + row + "\n");
  };
  const PoseErrorAxes world{.orientation = OrientationError::world};
  const Trajectory read = read_estimate(file_with("0.5"), TrajectoryFormat::poses, world);
  ASSERT_EQ(read.poses.size(), 1U);
  EXPECT_DOUBLE_EQ(read.time_s[0], 1700000000.25);
  EXPECT_EQ(read.poses[0].position, Vector3d(1, 2, 3));
  EXPECT_EQ(read.covariances[0](0, 1), 0.5);
  EXPECT_EQ(read.covariances[0](5, 5), 2.0);
  EXPECT_EQ(read.axes, world);
  EXPECT_THROW(read_estimate(file_with("0.4"), TrajectoryFormat::poses, world), DataError);
  EXPECT_THROW(read_estimate(write("f.csv", header + "\n"), TrajectoryFormat::poses, world), DataError);
}

TEST_F(TrajectoryFiles, ATruthMayBeACsvWithoutAHeaderOrWithNames) {
  const Trajectory plain = read_truth(write("a.csv", "0.5,1,2,3,0,0,0.6,0.8\n1.5,1,2,3,0,0,0.6,0.8\n"));
  ASSERT_EQ(plain.poses.size(), 2U);
  EXPECT_EQ(plain.poses[0].orientation.w(), 0.8);
  const Trajectory named =
      read_truth(write("b.csv", "timestamp,x,y,z,qw,qx,qy,qz\n1700000000250000000,1,2,3,0.8,0,0,0.6\n"));
  EXPECT_DOUBLE_EQ(named.time_s.at(0), 1700000000.25);  // beyond 1e16: of nanoseconds
  EXPECT_EQ(named.poses[0].orientation.w(), 0.8);
}

TEST_F(TrajectoryFiles, ATruthMayBePositionsAlone) {
  for (const char* text : {"1 4 5 6\n2 4 5 7\n", "# t x y z\n1 4 5 6\n2 4 5 7\n", "1,4,5,6\n2,4,5,7\n",
                           "Time (s),X (m),Y (m),Z (m),markers\n1,4,5,6,3\n2,4,5,7,3\n"}) {
    const Trajectory truth = read_truth(write("p.txt", text));
    ASSERT_EQ(truth.poses.size(), 2U) << text;
    EXPECT_FALSE(truth.has_orientation) << text;
    EXPECT_EQ(truth.time_s, (std::vector{1.0, 2.0})) << text;
    EXPECT_EQ(truth.poses[1].position, Eigen::Vector3d(4, 5, 7)) << text;
  }
  // OptiTrack's names of a quaternion; three of four are none.
  EXPECT_EQ(
      read_truth(write("o.csv", "Time,X,Y,Z,RX,RY,RZ,RW\n1,4,5,6,0,0,0.6,0.8\n")).poses[0].orientation.z(),
      0.6);
  EXPECT_THROW(read_truth(write("a.csv", "Time,X,Y,Z,RX,RY,RZ\n1,4,5,6,0,0,0.6\n")), DataError);
  Trajectory truth = read_truth(write_truth(curve(3))), estimate = truth;
  truth.has_orientation = false;
  estimate.covariances.assign(3, PoseCovariance::Identity());
  EXPECT_EQ(trajectory_errors(estimate, truth, {}).rows.at(0).error.size(), 3);
}

TEST_F(TrajectoryFiles, PositionsOfATruthAreInTheUnitOfTheirNames) {
  for (const auto& [unit, metres] : {std::pair("mm", 1e-3), {"cm", 1e-2}, {"m", 1.0}, {"km", 1e3}}) {
    const Trajectory truth =
        read_truth(write("t.csv", fmt::format("t,x [{0}],y [{0}],z ({0})\n1,4,5,6\n", unit)));
    EXPECT_EQ(truth.poses.at(0).position, metres * Vector3d(4, 5, 6)) << unit;
  }
  const auto refusal = [&](const std::string& names, const auto& read) -> std::string {
    try {
      read(write("t.csv", names + "\n1,4,5,6\n"));
      return "none";
    } catch (const DataError& error) {
      return error.what();
    }
  };
  EXPECT_NE(refusal("t,x [ft],y [ft],z [ft]", read_truth)
                .find("positions in [ft], [ft], [ft]: accepted is [m], or of all three [mm], [cm] or [km]"),
            std::string::npos);
  EXPECT_NE(refusal("t,x [mm],y [mm],z", read_truth).find("positions in [mm], [mm], []"), std::string::npos);
  // Beside a covariance nobody could say of which unit it is.
  std::string names = "t,x [mm],y [mm],z [mm],qx,qy,qz,qw";
  for (int i = 0; i < 36; ++i) names += fmt::format(",cov_{}", i);
  const auto read_poses = [](const std::filesystem::path& file) {
    return read_estimate(file, TrajectoryFormat::poses, {});
  };
  EXPECT_NE(refusal(names, read_poses).find("accepted is [m], with a covariance in m² and rad²"),
            std::string::npos);
}

TEST_F(TrajectoryFiles, CnspySaysItsAxesInAColumn) {
  const auto truth = curve(3);
  const Trajectory truth_read = read_truth(write_truth(truth));
  const auto error_of = [&](const char* type, const SpatialPose& estimate) {
    const std::string text =
        "t,tx,ty,tz,qx,qy,qz,qw,pxx,pxy,pxz,pyy,pyz,pzz,qrr,qrp,qry,qpp,qpy,qyy,est_err_type,err_"
        "representation\n" +
        pose_text(0.1, estimate, ",") + ",1,0,0,2,0,3,4,0,0,5,0,6," + type + ",theta_R\n";
    return trajectory_errors(read_estimate(write("e.csv", text), TrajectoryFormat::cnspy, {}), truth_read, {})
        .rows.at(0);
  };
  const SpatialPose& t = truth[1];
  // type1: p = p̂ + R̂ e, R = R̂ Exp(e); the estimate is off by −e.
  const Quaterniond R_hat = t.orientation * rotation_exp(kTilt);
  const Step body = error_of("type1", {t.position + R_hat * kPositionError, R_hat});
  EXPECT_LT((body.error.head<3>() - kPositionError).norm(), 1e-12);
  EXPECT_LT((body.error.tail<3>() - kTilt).norm(), 1e-12);
  const Step mixed = error_of("type5", {t.position + kPositionError, R_hat});
  EXPECT_LT((mixed.error.head<3>() - kPositionError).norm(), 1e-12);
  EXPECT_LT((mixed.error.tail<3>() - kTilt).norm(), 1e-12);
  const Step world = error_of("type6", {t.position + kPositionError, rotation_exp(kTilt) * t.orientation});
  EXPECT_LT((world.error.tail<3>() - kTilt).norm(), 1e-12);
  EXPECT_EQ(world.P.diagonal(), (Vector(6) << 1, 2, 3, 4, 5, 6).finished());
  EXPECT_THROW(error_of("type3", t), DataError);
}

TEST_F(TrajectoryFiles, EurocTruthIsInNanosecondsWithTheScalarFirst) {
  const Trajectory truth = read_truth(write("g.csv",
                                            "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w "
                                            "[], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n"
                                            "1403636580838555648,4.6,-1.7,0.7,0.5,0.5,0.5,-0.5,0."
                                            "1\n1403636580843555648,4.6,-1.8,0.7,0.5,0.5,0.5,-0.5,0.1\n"));
  ASSERT_EQ(truth.poses.size(), 2U);
  EXPECT_NEAR(truth.time_s[1] - truth.time_s[0], 0.005, 1e-6);
  EXPECT_EQ(truth.poses[0].orientation.w(), 0.5);
  EXPECT_EQ(truth.poses[0].orientation.z(), -0.5);
  EXPECT_EQ(truth.poses[1].position.y(), -1.8);
}

TEST(TruthAt, IsInterpolatedOrNearestWithinItsTolerance) {
  Trajectory truth;
  truth.time_s = {1.0, 2.0, 5.0};
  truth.poses = {{Vector3d(0, 0, 0), rotation_exp(Vector3d(0, 0, 0))},
                 {Vector3d(1, 0, 0), rotation_exp(Vector3d(0, 0, 1))},
                 {Vector3d(4, 0, 0), rotation_exp(Vector3d(0, 0, 2))}};
  const TrajectoryMatching between{.max_time_difference_s = 0.9};
  const auto middle = truth_at(truth, 1.25, between);
  ASSERT_TRUE(middle.has_value());
  EXPECT_DOUBLE_EQ(middle->pose.position.x(), 0.25);
  EXPECT_NEAR(rotation_log(middle->pose.orientation).z(), 0.25, 1e-12);
  EXPECT_FALSE(truth_at(truth, 2.5, between).has_value());  // 5.0 is too far
  EXPECT_FALSE(truth_at(truth, 0.9, between).has_value());  // nothing before
  EXPECT_TRUE(truth_at(truth, 5.0, between).has_value());
  EXPECT_TRUE(truth_at(truth, 5.0000005, between).has_value());  // rounded times
  EXPECT_TRUE(truth_at(truth, 0.9999995, between).has_value());
  const TrajectoryMatching nearest{.max_time_difference_s = 0.9, .truth_time = TruthTime::nearest};
  EXPECT_EQ(truth_at(truth, 1.25, nearest)->pose.position.x(), 0.0);
  EXPECT_EQ(truth_at(truth, 2.5, nearest)->pose.position.x(), 1.0);
  EXPECT_FALSE(truth_at(truth, 3.5, nearest).has_value());
}

TEST_F(TrajectoryFiles, AlignmentMovesTheTruthAlone) {
  const auto truth = curve(30);
  const Quaterniond turn = rotation_exp(Vector3d(0, 0, 0.7));
  const Quaterniond tilt = rotation_exp(Vector3d(0.3, -0.2, 0.7));
  const Vector3d shift(3, -1, 2);
  const auto worst = [&](const Quaterniond& by, TruthAlignment alignment) {
    Trajectory estimate, given;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      given.time_s.push_back(static_cast<double>(i));
      given.poses.push_back(truth[i]);
      estimate.time_s.push_back(static_cast<double>(i));
      estimate.lines.push_back(1);
      estimate.poses.push_back({by * truth[i].position + shift, by * truth[i].orientation});
      estimate.covariances.push_back(PoseCovariance::Identity());
    }
    double largest = 0.0;
    for (const Step& row : trajectory_errors(estimate, given, {.alignment = alignment}).rows) {
      EXPECT_EQ(row.P, Matrix::Identity(6, 6));
      largest = std::max(largest, row.error.cwiseAbs().maxCoeff());
    }
    return largest;
  };
  EXPECT_LT(worst(turn, TruthAlignment::yaw), 1e-12);
  EXPECT_LT(worst(turn, TruthAlignment::se3), 1e-12);
  EXPECT_LT(worst(tilt, TruthAlignment::se3), 1e-12);
  EXPECT_NEAR(worst(turn, TruthAlignment::se2), 2.0, 1e-12);  // the height stays
  EXPECT_GT(worst(tilt, TruthAlignment::yaw), 0.1);           // a tilt is not a heading
  EXPECT_GT(worst(turn, TruthAlignment::none), 1.0);
}

TEST_F(TrajectoryFiles, EveryMalformedInputIsOneErrorWithFileAndLine) {
  const std::string pose = "1 0 0 0 0 0 0 1", covariance = " 1 0 0 1 0 1 1 0 0 1 0 1\n";
  const std::pair<std::string, std::string> cases[] = {
      {"", "e.txt: is empty"},
      {"# nothing\n", "e.txt: holds no poses"},
      {pose + "\n",
       "e.txt:1: 8 fields where 20 are expected: poses without a covariance, as a truth has them"},
      {pose + covariance + pose + covariance, "e.txt:2: time 1.000000000 s does not increase"},
      {"1 0 0 nan 0 0 0 1" + covariance, "e.txt:1: field 4: 'nan' is not a finite number"},
      {"1 0 0 0 0 0 0 2" + covariance, "e.txt:1: the quaternion has length 2, not 1"},
      {pose + " 1 0 0 1 0 1 1 0 0 1 0 1", "e.txt:1: the last line has no end"}};
  for (const auto& [text, expected] : cases) {
    try {
      read_estimate(write("e.txt", text), TrajectoryFormat::openvins, {});
      ADD_FAILURE() << "no error: " << expected;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(read_estimate(write("e.csv", "t,tx\n1,2\n"), TrajectoryFormat::cnspy, {}), DataError);
  EXPECT_THROW(read_truth(folder_.path() / "absent"), DataError);
  const Trajectory early = read_estimate(write("e.txt", pose + covariance), TrajectoryFormat::openvins, {});
  const Trajectory late = read_truth(write("t.txt", "9 0 0 0 0 0 0 1\n"));
  EXPECT_THROW(trajectory_errors(early, late, {}), DataError);
}

TEST_F(TrajectoryFiles, RowsBeforeAnErrorAreAPart) {
  const std::string row = " 0 0 0 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n";
  const auto file = write("e.txt", "1" + row + "2" + row + "3 0 0 0 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 x\n");
  Trajectory part;
  EXPECT_THROW(read_estimate(file, TrajectoryFormat::openvins, {}, &part), DataError);
  EXPECT_EQ(part.time_s, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(part.poses.size(), 2U);
  EXPECT_EQ(part.covariances.size(), 2U);
}

TEST_F(TrajectoryFiles, NoBytesMakeItDoAnythingElseThanReadOrRefuse) {
  const std::string good =
      "# t\n1 0 0 0 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n2 0 0 0 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n";
  const std::string euroc = "#timestamp [ns], p\n1000,1,2,3,1,0,0,0\n2000,1,2,3,1,0,0,0\n";
  std::mt19937 random(11);
  for (int i = 0; i < 400; ++i) {
    std::string text = i % 2 == 0 ? good : euroc;
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0) {
        text[at] = static_cast<char>(random() % 256);
      } else {
        text.erase(at, 1 + random() % 6);
      }
      if (text.empty()) text = "\n";
    }
    try {
      const auto file = write("f.txt", text);
      const Trajectory read =
          i % 2 == 0 ? read_estimate(file, TrajectoryFormat::openvins, {}) : read_truth(file);
      for (const SpatialPose& pose : read.poses) ASSERT_TRUE(pose.position.allFinite());
    } catch (const DataError&) {
    }
  }
}

}  // namespace
}  // namespace credence::internal
