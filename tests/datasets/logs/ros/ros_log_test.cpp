#include "datasets/logs/ros/ros_log.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "datasets/data_error.h"
#include "datasets/logs/geodesy.h"
#include "tests/datasets/data_folder.h"
#include "tests/datasets/logs/hostile.h"
#include "tests/datasets/logs/recorded_sink.h"
#include "tests/datasets/logs/ros/ros_writers.h"

namespace credence::internal {
namespace {

using testing::BagContent;
using ::testing::HasSubstr;
using testing::MessageWriter;
using ::testing::Not;
using testing::Packing;
using testing::RecordedSink;
using Kind = MessageWriter::Kind;

const Eigen::Vector3d kShift(0.3, -0.2, 0.1), kTurn(0.02, -0.05, 0.03);

Eigen::Quaterniond rotation(const Eigen::Vector3d& v) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(v.norm(), v.normalized()));
}

SpatialPose true_pose(int i) {
  const double t = 0.1 * i;
  return {{std::cos(t), 2.0 * std::sin(t), 0.3 * t}, rotation({0.4, -0.3, 0.5 + t})};
}

/// The truth, moved by kShift and turned by kTurn about the axes of the world.
SpatialPose estimated_pose(int i) {
  const SpatialPose truth = true_pose(i);
  return {truth.position + kShift, rotation(kTurn) * truth.orientation};
}

PoseCovariance covariance(int i) {
  PoseCovariance P = PoseCovariance::Identity() * (1.0 + 0.01 * i);
  P(0, 5) = P(5, 0) = 0.25;
  return P;
}

double time_of(int i) { return 1000.0 + 0.125 * i; }

std::string odometry(Kind kind, int i, const PoseCovariance& P) {
  MessageWriter message(kind);
  message.header(time_of(i), "map").text("base").pose(estimated_pose(i)).matrix(P);
  message.vector({1, 2, 3}).vector({4, 5, 6}).matrix(covariance(i));  // the twist
  return message.bytes();
}

std::string pose_stamped(Kind kind, int i) {
  return MessageWriter(kind).header(time_of(i), "map").pose(true_pose(i)).bytes();
}

/// An estimate and its truth, 12 messages of each.
BagContent bag(Kind kind, const std::function<PoseCovariance(int)>& P = covariance) {
  BagContent content{.topics = {{"/odom", "nav_msgs/Odometry"},
                                {"/truth", "geometry_msgs/PoseStamped"},
                                {"/words", "std_msgs/String"}},
                     .messages = {}};
  for (int i = 0; i < 12; ++i) {
    content.messages.push_back({0, time_of(i), odometry(kind, i, P(i))});
    content.messages.push_back({1, time_of(i), pose_stamped(kind, i)});
    content.messages.push_back({2, time_of(i), MessageWriter(kind).text("hello").bytes()});
  }
  return content;
}

LogReading with_truth(const std::string& topic = "/truth") {
  LogReading options;
  options.truth_topic = topic;
  return options;
}

RecordedSink read_mcap(const BagContent& content, const LogReading& options) {
  const TemporaryFolder folder;
  RecordedSink sink;
  mcap_format().read(folder.write("log.mcap", testing::mcap_bytes(content, Packing::none)), options, sink);
  return sink;
}

void expect_the_run(const RecordedSink& sink, const std::string& what) {
  ASSERT_EQ(sink.runs.size(), 1U) << what;
  ASSERT_EQ(sink.runs[0].steps.size(), 12U) << what;
  for (int i = 0; i < 12; ++i) {
    const Step& step = sink.runs[0].steps[static_cast<std::size_t>(i)];
    EXPECT_EQ(step.step, i + 1);
    EXPECT_LT((step.error.head<3>() - kShift).norm(), 1e-12) << what;
    EXPECT_LT((step.error.tail<3>() - kTurn).norm(), 1e-12) << what;
    EXPECT_EQ(step.P, Matrix(covariance(i))) << what;
    EXPECT_TRUE(step.problem.empty()) << what;
  }
}

TEST(RosLog, ATruthOfTwoTypesIsRefused) {
  BagContent content = bag(Kind::cdr);
  content.topics.push_back({"/truth", "nav_msgs/Odometry"});
  for (int i = 0; i < 12; i += 2)
    content.messages.push_back({3, time_of(12 + i), odometry(Kind::cdr, 12 + i, covariance(i))});
  EXPECT_THAT([&] { read_mcap(content, with_truth()); },
              ::testing::ThrowsMessage<std::invalid_argument>(
                  HasSubstr("--truth-topic /truth: messages of two types, geometry_msgs/PoseStamped and "
                            "nav_msgs/Odometry")));
}

TEST(RosLog, TheSamePosesComeOutOfEveryContainerPackedInEveryWay) {
  const TemporaryFolder folder;
  for (const Kind kind : {Kind::cdr, Kind::cdr_big_endian, Kind::cdr2}) {
    RecordedSink sink;
    mcap_format().read(folder.write("log.mcap", testing::mcap_bytes(bag(kind), Packing::outside_chunks)),
                       with_truth(), sink);
    expect_the_run(sink, fmt::format("serialisation {}", static_cast<int>(kind)));
  }
  for (const Packing packing : {Packing::none, Packing::lz4, Packing::zstd}) {
    RecordedSink sink;
    mcap_format().read(folder.write("log.mcap", testing::mcap_bytes(bag(Kind::cdr), packing)), with_truth(),
                       sink);
    expect_the_run(sink, fmt::format("mcap {}", static_cast<int>(packing)));
  }
  RecordedSink ros1_in_mcap;
  mcap_format().read(folder.write("log.mcap", testing::mcap_bytes(bag(Kind::ros1), Packing::zstd, true)),
                     with_truth(), ros1_in_mcap);
  expect_the_run(ros1_in_mcap, "ROS 1 in MCAP");
  for (const Packing packing : {Packing::outside_chunks, Packing::none, Packing::lz4, Packing::bz2}) {
    RecordedSink sink;
    ros1_bag_format().read(folder.write("log.bag", testing::ros1_bag_bytes(bag(Kind::ros1), packing)),
                           with_truth(), sink);
    expect_the_run(sink, fmt::format("bag {}", static_cast<int>(packing)));
  }
  RecordedSink sink;
  testing::write_ros2_sqlite(folder / "log.db3", bag(Kind::cdr));
  ros2_sqlite_format().read(folder / "log.db3", with_truth(), sink);
  expect_the_run(sink, "db3");
}

// A node that was started again, or two nodes: containers know each as a connection of its own.
TEST(RosLog, APublisherMoreIsNoTopicMore) {
  const auto two_each = [](Kind kind) {
    BagContent content = bag(kind);
    content.topics.push_back(content.topics[0]);
    content.topics.push_back(content.topics[1]);
    for (std::size_t i = content.messages.size() / 2; i < content.messages.size(); ++i) {
      if (content.messages[i].topic < 2) content.messages[i].topic += 3;
    }
    return content;
  };
  const TemporaryFolder folder;
  testing::write_ros2_sqlite(folder / "log.db3", two_each(Kind::cdr));
  const std::pair<LogFormat, std::filesystem::path> logs[] = {
      {mcap_format(), folder.write("log.mcap", testing::mcap_bytes(two_each(Kind::cdr), Packing::none))},
      {ros1_bag_format(),
       folder.write("log.bag", testing::ros1_bag_bytes(two_each(Kind::ros1), Packing::lz4))},
      {ros2_sqlite_format(), folder / "log.db3"}};
  for (const auto& [format, file] : logs) {
    for (const char* topic : {"", "/odom"}) {
      LogReading options = with_truth();
      options.topic = topic;
      RecordedSink sink;
      format.read(file, options, sink);
      expect_the_run(sink, std::string(format.name));
      EXPECT_THAT(sink.remarks, ::testing::Contains(HasSubstr("/odom: 2 publishers"))) << format.name;
      EXPECT_THAT(sink.remarks, ::testing::Contains(HasSubstr("/truth: 2 publishers"))) << format.name;
    }
    const LogContents contents = format.list(file);
    ASSERT_EQ(contents.topics.size(), 3U) << format.name;
    EXPECT_EQ(contents.topics[0].count, 12) << format.name;
  }
}

TEST(RosLog, ListsTopicsTypesCountsAndRates) {
  const TemporaryFolder folder;
  const auto file = folder.write("log.mcap", testing::mcap_bytes(bag(Kind::cdr), Packing::lz4));
  const LogContents contents = mcap_format().list(file);
  ASSERT_EQ(contents.topics.size(), 3U);
  EXPECT_EQ(contents.topics[0].name, "/odom");
  EXPECT_EQ(contents.topics[0].type, "nav_msgs/Odometry");
  EXPECT_EQ(contents.topics[0].count, 12);
  EXPECT_NEAR(contents.topics[0].rate_hz, 8.0, 1e-9);
  EXPECT_TRUE(contents.topics[0].covariance);
  EXPECT_EQ(contents.topics[0].use, "estimate, truth");
  EXPECT_EQ(contents.topics[1].use, "truth");
  EXPECT_FALSE(contents.topics[1].covariance);
  EXPECT_EQ(contents.topics[2].use, "");
}

TEST(RosLog, SentinelsLeaveTheDofAndAreTold) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto sentinels = [&](int i) {
    PoseCovariance P = covariance(i);
    P(0, 5) = P(5, 0) = 0.0;
    P(1, 1) = 0.0;
    P(2, 2) = 1e6;
    P(3, 3) = i < 6 ? infinity : 1.0;
    P(4, 4) = 1e308;
    return P;
  };
  const RecordedSink sink = read_mcap(bag(Kind::cdr, sentinels), with_truth());
  EXPECT_EQ(sink.runs[0].steps[0].states, (std::vector<Index>{0, 5}));
  EXPECT_EQ(sink.runs[0].steps[11].states, (std::vector<Index>{0, 3, 5}));
  EXPECT_EQ(sink.runs[0].steps[0].error.size(), 2);
  EXPECT_THAT(sink.said(),
              HasSubstr("a variance of 0 means “not estimated”, and is left out of the dof: y in every row"));
  EXPECT_THAT(sink.said(),
              HasSubstr("at or above 1e5 means “not estimated”, and is left out of the dof: z, rotation y "
                        "in every row"));
  EXPECT_THAT(sink.said(),
              HasSubstr("not finite means “not estimated”, and is left out of the dof: rotation x in 6 of "
                        "12 rows"));
}

TEST(RosLog, ThatOnlyThePlaneIsEstimatedIsToldWhereThereIsATruth) {
  const auto plane = [](int i) {
    PoseCovariance P = PoseCovariance::Zero();
    P(0, 0) = P(1, 1) = P(5, 5) = 1.0 + 0.01 * i;
    return P;
  };
  const std::string advice = "with --chart planar it is also told where P lies";
  EXPECT_THAT(read_mcap(bag(Kind::cdr, plane), with_truth()).said(), HasSubstr(advice));
  EXPECT_THAT(read_mcap(bag(Kind::cdr, plane), {}).said(), Not(HasSubstr(advice)));
  EXPECT_THAT(read_mcap(bag(Kind::cdr), with_truth()).said(), Not(HasSubstr(advice)));
}

TEST(RosLog, AVarianceJustBelowTheSentinelIsOne) {
  const auto large = [](int) { return PoseCovariance(PoseCovariance::Identity() * 99999.0); };
  EXPECT_EQ(read_mcap(bag(Kind::cdr, large), with_truth()).runs[0].steps[0].states.size(), 6U);
}

TEST(RosLog, MinusOneInTheFirstElementSaysThatNothingIsKnown) {
  const auto unknown = [](int i) {
    PoseCovariance P = covariance(i);
    if (i >= 4) P(0, 0) = -1.0;
    return P;
  };
  const RecordedSink sink = read_mcap(bag(Kind::cdr, unknown), with_truth());
  EXPECT_EQ(sink.runs[0].steps.size(), 4U);
  EXPECT_THAT(sink.said(), HasSubstr("−1 in the first element says in 8 of 12 rows"));
}

TEST(RosLog, ACovarianceThatNeverChangesIsCalledAConstant) {
  const auto constant = [](int) { return covariance(0); };
  EXPECT_THAT(read_mcap(bag(Kind::cdr, constant), with_truth()).said(),
              HasSubstr("/odom: the covariance never changes over 12 rows while the body moves"));
  EXPECT_THAT(read_mcap(bag(Kind::cdr), with_truth()).said(), Not(HasSubstr("never changes")));
}

TEST(RosLog, ACovarianceThatIsNotSymmetricIsARejectedRow) {
  const auto lopsided = [](int i) {
    PoseCovariance P = covariance(i);
    if (i == 3) P(0, 5) = 0.1;
    return P;
  };
  const RecordedSink sink = read_mcap(bag(Kind::cdr, lopsided), with_truth());
  EXPECT_EQ(sink.runs[0].steps[3].problem, "a covariance is not symmetric");
  EXPECT_EQ(sink.runs[0].steps[3].line, 4);
}

TEST(RosLog, WithoutATruthItSaysWhatCannotBeKnown) {
  const auto constant = [](int) { return covariance(0); };
  const RecordedSink sink = read_mcap(bag(Kind::cdr, constant), {});
  EXPECT_FALSE(sink.runs.at(0).layout.has_truth);
  EXPECT_EQ(sink.runs[0].steps.size(), 12U);
  EXPECT_THAT(sink.said(), HasSubstr("cannot be known from this log"));
  EXPECT_THAT(sink.said(),
              HasSubstr("by --truth-topic, if it is, /truth (geometry_msgs/PoseStamped, 12 messages)"));
  EXPECT_THAT(sink.said(), HasSubstr("never changes"));
}

TEST(RosLog, TheOrientationsErrorIsTakenAsNamedAndAllMeaningsAreCompared) {
  const RecordedSink world = read_mcap(bag(Kind::cdr), with_truth());
  LogReading options = with_truth();
  options.chart = pose_chart_named("body");
  const RecordedSink body = read_mcap(bag(Kind::cdr), options);
  const Eigen::Vector3d turned = true_pose(5).orientation.conjugate() * kTurn;
  EXPECT_LT((body.runs[0].steps[5].error.tail<3>() - turned).norm(), 1e-12);
  options.chart = pose_chart_named("rpy");
  const Step rpy = read_mcap(bag(Kind::cdr), options).runs[0].steps[5];
  EXPECT_LT((rpy.error.tail<3>() -
             (roll_pitch_yaw(estimated_pose(5).orientation) - roll_pitch_yaw(true_pose(5).orientation)))
                .norm(),
            1e-12);
  options.chart = pose_chart_named("planar");
  const RecordedSink planar = read_mcap(bag(Kind::cdr), options);
  EXPECT_EQ(planar.runs[0].layout.states,
            (std::vector<std::string>{"vehicle.x", "vehicle.y", "vehicle.heading"}));
  const Step& step = planar.runs[0].steps[5];
  ASSERT_EQ(step.error.size(), 3);
  EXPECT_NEAR(step.error[2], rpy.error[5], 1e-15);
  EXPECT_EQ(step.P(0, 2), 0.25);  // rows 0, 1, 5 of the message
}

TEST(RosLog, MeaningsOfTheOrientationThatDifferAreToldWithTheirNees) {
  // Of the world's rotation only that about z is known well, and the error is about x: the body, which is
  // tilted, sees another one.
  const auto sharp = [](int i) {
    PoseCovariance P = covariance(i);
    P(0, 5) = P(5, 0) = 0.0;
    P(5, 5) = 1e-4;
    return P;
  };
  EXPECT_THAT(read_mcap(bag(Kind::cdr, sharp), with_truth()).said(),
              HasSubstr("if what is written were of the chart: ros 9"));
  const auto round = [](int i) { return PoseCovariance(PoseCovariance::Identity() * (1.0 + i)); };
  EXPECT_THAT(read_mcap(bag(Kind::cdr, round), with_truth()).said(), Not(HasSubstr("mean NEES of the pose")));
}

TEST(RosLog, EstimateAndTruthThatLookSwappedAreTold) {
  BagContent content = bag(Kind::cdr);
  content.topics[1].type = "nav_msgs/Odometry";
  int row = 0;
  for (BagContent::Message& message : content.messages) {
    if (message.topic == 1) message.bytes = odometry(Kind::cdr, row++, PoseCovariance::Zero());
  }
  LogReading swapped;
  swapped.topic = "/truth";
  swapped.truth_topic = "/odom";
  const RecordedSink sink = read_mcap(content, swapped);
  EXPECT_TRUE(sink.runs.at(0).steps.empty());
  EXPECT_THAT(sink.said(), HasSubstr("are estimate and truth swapped?"));
}

TEST(RosLog, ATruthMayBePositionsAlone) {
  BagContent content = bag(Kind::cdr);
  content.topics[1].type = "geometry_msgs/PointStamped";
  for (auto& message : content.messages) {
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    if (message.topic == 1) {
      message.bytes =
          MessageWriter(Kind::cdr).header(time_of(i), "map").vector(true_pose(i).position).bytes();
    }
  }
  const RecordedSink sink = read_mcap(content, with_truth());
  EXPECT_EQ(sink.runs[0].layout.states.size(), 3U);
  EXPECT_LT((sink.runs[0].steps[7].error - kShift).norm(), 1e-12);
  EXPECT_EQ(sink.runs[0].steps[7].P, Matrix(covariance(7).topLeftCorner<3, 3>()));
}

/// A bag of 12 estimates and truths; those for which this is true have a quaternion of zeros.
BagContent bag_without_orientation(const std::function<bool(int)>& estimate,
                                   const std::function<bool(int)>& truth) {
  const Eigen::Quaterniond zeros(0.0, 0.0, 0.0, 0.0);
  BagContent content = bag(Kind::cdr);
  for (auto& message : content.messages) {
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    MessageWriter writer(Kind::cdr);
    writer.header(time_of(i), "map");
    if (message.topic == 0 && estimate(i)) {
      writer.text("base").pose({estimated_pose(i).position, zeros}).matrix(covariance(i));
      message.bytes = writer.vector({0, 0, 0}).vector({0, 0, 0}).matrix(covariance(i)).bytes();
    } else if (message.topic == 1 && truth(i)) {
      message.bytes = writer.pose({true_pose(i).position, zeros}).bytes();
    }
  }
  return content;
}

bool none(int) { return false; }
bool all(int) { return true; }

TEST(RosLog, ATruthWhoseQuaternionsAreZerosIsPositionsAlone) {
  const RecordedSink sink = read_mcap(bag_without_orientation(none, all), with_truth());
  EXPECT_EQ(sink.runs[0].layout.states.size(), 3U);
  EXPECT_LT((sink.runs[0].steps[7].error - kShift).norm(), 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("/truth: 12 messages have a quaternion of zeros, which is no "
                                     "orientation: positions alone are compared."));
}

TEST(RosLog, MessagesOfATruthWhoseQuaternionIsZerosAreLeftOut) {
  const RecordedSink sink =
      read_mcap(bag_without_orientation(none, [](int i) { return i == 0; }), with_truth());
  ASSERT_EQ(sink.runs[0].steps.size(), 11U) << "nothing is known of the first estimate";
  EXPECT_LT((sink.runs[0].steps[0].error.tail<3>() - kTurn).norm(), 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("/truth: 1 message has a quaternion of zeros, which is no orientation: "
                                     "left out."));
}

TEST(RosLog, AnEstimateWhoseQuaternionIsZerosIsJudgedByItsPosition) {
  const BagContent content = bag_without_orientation([](int i) { return i % 2 == 1; }, none);
  const RecordedSink sink = read_mcap(content, with_truth());
  EXPECT_EQ(sink.runs[0].steps[0].states.size(), 6U);
  EXPECT_EQ(sink.runs[0].steps[1].states, (std::vector<Index>{0, 1, 2}));
  EXPECT_LT((sink.runs[0].steps[1].error - kShift).norm(), 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("/odom: 6 messages have a quaternion of zeros, which is no "
                                     "orientation: the position alone is judged there."));
  // Where the error of a position is told along the axes of the body, nothing is known without them.
  LogReading options = with_truth();
  options.chart = pose_chart_named("gtsam");
  const RecordedSink body = read_mcap(content, options);
  EXPECT_EQ(body.runs[0].steps.size(), 6U);
  EXPECT_THAT(body.said(), HasSubstr("which is no orientation: nothing is judged there."));
}

const SpatialPose kLever{{0.4, -0.2, 0.7}, rotation({0.1, 0.2, -0.3})};

/// A bag whose truth is at kLever on the body, of poses with a covariance or of points.
BagContent bag_with_lever(const std::string& type, const PoseCovariance& truth_covariance) {
  BagContent content = bag(Kind::cdr);
  content.topics[1].type = type;
  for (auto& message : content.messages) {
    if (message.topic != 1) continue;
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    SpatialPose truth = true_pose(i);
    truth = {truth.position + truth.orientation * kLever.position, truth.orientation * kLever.orientation};
    MessageWriter writer(Kind::cdr);
    writer.header(time_of(i), "map");
    if (type == "geometry_msgs/PointStamped") {
      writer.vector(truth.position);
    } else {
      writer.pose(truth).matrix(truth_covariance);
    }
    message.bytes = writer.bytes();
  }
  return content;
}

TEST(RosLog, ATruthWithOrientationsIsMovedAlongTheLeverArm) {
  const PoseCovariance C = 0.5 * PoseCovariance::Identity();
  LogReading options = with_truth();
  options.matching.lever_arm = kLever;
  const BagContent content = bag_with_lever("geometry_msgs/PoseWithCovarianceStamped", C);
  const RecordedSink sink = read_mcap(content, options);
  for (int i = 0; i < 12; ++i) {
    const Step& step = sink.runs.at(0).steps.at(static_cast<std::size_t>(i));
    EXPECT_LT((step.error.head<3>() - kShift).norm(), 1e-12);
    EXPECT_LT((step.error.tail<3>() - kTurn).norm(), 1e-12);
    // p = p' − R l: the turns of the truth reach its position over the arm, [R l]× of them.
    const Eigen::Vector3d arm = true_pose(i).orientation * kLever.position;
    Eigen::Matrix3d cross;
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    PoseCovariance J = PoseCovariance::Identity();
    J.topRightCorner<3, 3>() = cross;
    EXPECT_LT((step.P - Matrix(covariance(i) + J * C * J.transpose())).norm(), 1e-12);
  }
}

TEST(RosLog, ATruthOfPointsTakesTheEstimateToTheEndOfTheLeverArm) {
  LogReading options = with_truth();
  options.matching.lever_arm = SpatialPose{kLever.position, Eigen::Quaterniond::Identity()};
  const BagContent content = bag_with_lever("geometry_msgs/PointStamped", PoseCovariance::Zero());
  const RecordedSink sink = read_mcap(content, options);
  for (int i = 0; i < 12; ++i) {
    const Step& step = sink.runs.at(0).steps.at(static_cast<std::size_t>(i));
    const Eigen::Vector3d arm = estimated_pose(i).orientation * kLever.position;
    const Eigen::Vector3d error = kShift + arm - true_pose(i).orientation * kLever.position;
    EXPECT_LT((step.error - error).norm(), 1e-12);
    Eigen::Matrix<double, 3, 6> J;  // p̂' = p̂ + Exp(e) R̂ l
    J << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
    J.rightCols<3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    EXPECT_LT((step.P - Matrix(J * covariance(i) * J.transpose())).norm(), 1e-12);
  }
  // What is not estimated stays out of the position.
  const auto sentinels = [](int i) {
    PoseCovariance P = covariance(i);
    P.diagonal().tail<3>().setConstant(1e6);
    P(0, 5) = P(5, 0) = 0.0;
    return P;
  };
  BagContent unknown = bag_with_lever("geometry_msgs/PointStamped", PoseCovariance::Zero());
  for (auto& message : unknown.messages) {
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    if (message.topic == 0) message.bytes = odometry(Kind::cdr, i, sentinels(i));
  }
  const RecordedSink without = read_mcap(unknown, options);
  EXPECT_LT((without.runs.at(0).steps.at(3).P - Matrix(covariance(3).topLeftCorner<3, 3>())).norm(), 1e-12);
  EXPECT_THAT(without.said(), HasSubstr("the orientation is not estimated in every row"));
}

TEST(RosLog, TheTruthsOwnCovarianceIsAdded) {
  BagContent content = bag(Kind::cdr);
  content.topics[1].type = "geometry_msgs/PoseWithCovarianceStamped";
  for (auto& message : content.messages) {
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    if (message.topic == 1) {
      message.bytes = MessageWriter(Kind::cdr)
                          .header(time_of(i), "map")
                          .pose(true_pose(i))
                          .matrix(PoseCovariance(2.0 * PoseCovariance::Identity()))
                          .bytes();
    }
  }
  const RecordedSink sink = read_mcap(content, with_truth());
  EXPECT_EQ(sink.runs[0].steps[7].P, Matrix(covariance(7) + 2.0 * PoseCovariance::Identity()));
  EXPECT_THAT(sink.said(), HasSubstr("the truth has a covariance of its own"));
  // The truth could be the estimate as well.
  EXPECT_THAT([&] { read_mcap(content, {}); },
              ::testing::ThrowsMessage<std::invalid_argument>(
                  HasSubstr("name one by --topic: /odom (nav_msgs/Odometry, 12 messages), /truth "
                            "(geometry_msgs/PoseWithCovarianceStamped, 12 messages)")));
}

TEST(RosLog, WhatLiesBetweenTwoRowsOfASlowTruthIsLeftOutWhereItMatters) {
  const auto by_a_slow_truth = [](double variance) {
    BagContent content =
        bag(Kind::cdr, [variance](int) -> PoseCovariance { return variance * PoseCovariance::Identity(); });
    std::erase_if(content.messages, [odd = false](const auto& message) mutable {
      if (message.topic == 1) odd = !odd;
      return message.topic == 1 && !odd;
    });
    LogReading options = with_truth();
    options.matching.max_time_difference_s = 0.2;
    return read_mcap(content, options);
  };
  const RecordedSink sure = by_a_slow_truth(1e-6), unsure = by_a_slow_truth(1.0);
  EXPECT_EQ(sure.runs.at(0).steps.size(), 6U);
  EXPECT_EQ(sure.unmatched_rows, 6);
  EXPECT_THAT(sure.said(),
              HasSubstr("5 rows are left out, whose truth lies between two of its rows, 0.25 s"));
  EXPECT_EQ(unsure.runs.at(0).steps.size(), 11U);
  EXPECT_THAT(unsure.said(), Not(HasSubstr("left out")));
}

TEST(RosLog, TransformsOfSeveralFramesNeedTheNameOfOne) {
  BagContent content = bag(Kind::cdr);
  content.topics[1] = {"/tf", "tf2_msgs/TFMessage"};
  for (auto& message : content.messages) {
    if (message.topic != 1) continue;
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    MessageWriter tf(Kind::cdr);
    tf.add<std::uint32_t>(2).header(time_of(i), "map").text("wheel").pose(SpatialPose{});
    tf.header(time_of(i), "map").text("base").pose(true_pose(i));
    message.bytes = tf.bytes();
  }
  expect_the_run(read_mcap(content, with_truth("/tf:base")), "tf");
  EXPECT_THAT(
      [&] { read_mcap(content, with_truth("/tf")); },
      ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("name one as /tf:FRAME, of base, wheel")));
}

TEST(RosLog, PlacesOnTheEarthAreATruthInEastNorthUp) {
  const Eigen::Vector3d origin(0.7, 0.1, 120.0);
  BagContent content = bag(Kind::cdr);
  content.topics[1].type = "sensor_msgs/NavSatFix";
  const Eigen::Vector3d start = true_pose(0).position;
  for (auto& message : content.messages) {
    if (message.topic != 1) continue;
    const int i = static_cast<int>(std::lround((message.time_s - 1000.0) / 0.125));
    const Eigen::Vector3d place =
        geodetic(earth_fixed(origin) + east_north_up(origin).transpose() * (true_pose(i).position - start));
    const double degree = std::numbers::pi / 180.0;
    MessageWriter fix(Kind::cdr);
    fix.header(time_of(i), "gps").add<std::int8_t>(i == 11 ? -1 : 0).add<std::uint16_t>(1);
    fix.add(place.x() / degree).add(place.y() / degree).add(place.z());
    fix.matrix(Eigen::Matrix3d(Eigen::Matrix3d::Identity() * 0.5)).add<std::uint8_t>(2);
    message.bytes = fix.bytes();
  }
  const RecordedSink sink = read_mcap(content, with_truth());
  ASSERT_EQ(sink.runs[0].steps.size(), 11U);  // the last has no fix
  EXPECT_EQ(sink.unmatched_rows, 1);
  for (const Step& step : sink.runs[0].steps) EXPECT_LT((step.error - kShift - start).norm(), 1e-6);
  EXPECT_NEAR(sink.runs[0].steps[0].P(1, 1), 1.5, 1e-12);
  EXPECT_THAT(sink.said(), HasSubstr("The estimate is in the frame 'map', the truth in 'gps'"));
  EXPECT_THAT(sink.said(),
              HasSubstr(": 1 message without a fix, or with a position that is not finite, is left out"));
}

TEST(RosLog, MessagesOutOfOrderAreLeftOutAndCounted) {
  BagContent content = bag(Kind::cdr);
  content.messages.push_back({0, time_of(12), odometry(Kind::cdr, 3, covariance(3))});
  const RecordedSink sink = read_mcap(content, with_truth());
  EXPECT_EQ(sink.runs[0].steps.size(), 12U);
  EXPECT_THAT(sink.said(),
              HasSubstr("/odom: 1 message with a time no later than the one before is left out"));
}

TEST(RosLog, ErrorsSayWhatIsThere) {
  const auto fails_with = [](const BagContent& content, const LogReading& options,
                             const std::string& message) {
    try {
      read_mcap(content, options);
      ADD_FAILURE() << "no error: " << message;
    } catch (const std::exception& error) {
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  };
  LogReading options = with_truth();
  options.topic = "/nowhere";
  fails_with(bag(Kind::cdr), options,
             "--topic /nowhere: it holds no poses with covariance under this name; there "
             "are: /odom (nav_msgs/Odometry, 12 messages)");
  fails_with(bag(Kind::cdr), with_truth("/gt"),
             "--truth-topic /gt: no poses of this name are there; there are: "
             "/truth (geometry_msgs/PoseStamped, 12 messages)");
  BagContent words = bag(Kind::cdr);
  words.topics[0].type = "std_msgs/String";
  fails_with(words, {}, "holds no poses with covariance");
  BagContent late = bag(Kind::cdr);
  for (auto& message : late.messages) {
    if (message.topic == 1) message.bytes = MessageWriter(Kind::cdr).header(5.0, "map").pose({}).bytes();
  }
  fails_with(late, with_truth(), "no row has a truth at its time");
  BagContent short_message = bag(Kind::cdr);
  short_message.messages[3].bytes.resize(60);
  fails_with(short_message, with_truth(), "of the chunk at byte");
}

TEST(RosLog, CorruptedContainersAreToldWithTheByte) {
  const TemporaryFolder folder;
  const auto fails_with = [&](const LogFormat& format, const std::string& bytes, const std::string& message) {
    const auto file = folder.write("log", bytes);
    RecordedSink sink;
    EXPECT_THAT([&] { format.read(file, with_truth(), sink); },
                ::testing::ThrowsMessage<DataError>(HasSubstr(message)));
  };
  std::string mcap = testing::mcap_bytes(bag(Kind::cdr), Packing::lz4);
  fails_with(mcap_format(), mcap.substr(0, mcap.size() - 60), "cut off, or corrupted");
  std::string checksum = mcap;
  // After magic, header (25 bytes), attachment (19): the chunk's checksum is 9 + 24 bytes on.
  checksum[8 + 25 + 19 + 9 + 24] ^= 1;
  fails_with(mcap_format(), checksum, "a checksum that is not its own");
  std::string claim = mcap;
  claim[8 + 25 + 19 + 9 + 16 + 3] = 0x7f;  // two gigabytes
  fails_with(mcap_format(), claim, "at most 1 GiB is read at once");
  std::string larger = mcap;
  larger[8 + 25 + 19 + 9 + 16 + 2] ^= 1;  // 65,536 bytes more or fewer
  fails_with(mcap_format(), larger, "lz4 unpacks to");
  const std::string packed = testing::ros1_bag_bytes(bag(Kind::ros1), Packing::bz2);
  std::string corrupted = packed;
  corrupted[packed.size() - 200] ^= 0x55;
  fails_with(ros1_bag_format(), corrupted, ": bz2 ");
  fails_with(ros1_bag_format(), packed.substr(0, packed.size() - 1), "a record of");
  fails_with(ros2_sqlite_format(), "SQLite format 3", "is damaged: what can still be read");
}

TEST(RosLog, WhatComesBeforeACutIsReadIfAskedFor) {
  const TemporaryFolder folder;
  const std::string whole = testing::mcap_bytes(bag(Kind::cdr), Packing::outside_chunks);
  const auto file = folder.write("log", whole.substr(0, whole.size() - 60));
  LogReading options = with_truth();
  options.partial = true;
  RecordedSink sink;
  mcap_format().read(file, options, sink);
  EXPECT_GT(sink.runs.at(0).steps.size(), 1U);
  EXPECT_THAT(sink.said(), HasSubstr("only a part could be read: "));
  EXPECT_THAT(sink.said(), HasSubstr("log:byte "));
}

BagContent short_bag(Kind kind) {
  BagContent content = bag(kind);
  content.messages.resize(2);
  return content;
}

TEST(RosLog, NoCutOrFlippedByteCrashes) {
  EXPECT_EQ(
      testing::unnoticed_cuts(
          mcap_format(), testing::mcap_bytes(short_bag(Kind::cdr), Packing::outside_chunks), with_truth()),
      8U + 20U + 9U);  // what comes after the mark of the end of the data
  testing::unnoticed_cuts(mcap_format(), testing::mcap_bytes(short_bag(Kind::cdr), Packing::lz4),
                          with_truth());
  // A bag of ROS 1 has no end mark: a cut between records leaves a whole one.
  EXPECT_LE(testing::unnoticed_cuts(ros1_bag_format(),
                                    testing::ros1_bag_bytes(short_bag(Kind::ros1), Packing::outside_chunks),
                                    with_truth()),
            4U);  // two topics more, two messages
  testing::unnoticed_cuts(ros1_bag_format(), testing::ros1_bag_bytes(short_bag(Kind::ros1), Packing::bz2),
                          with_truth());
}

TEST(RosLog, NoCutOrFlippedByteOfADatabaseCrashes) {
  const TemporaryFolder folder;
  testing::write_ros2_sqlite(folder / "log.db3", short_bag(Kind::cdr));
  const std::string whole = folder.read("log.db3");
  for (std::size_t at = 0; at < whole.size(); at += 29) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0xff);
    testing::reads(ros2_sqlite_format(), folder.write("flipped.db3", flipped), with_truth(), "flipped");
    testing::reads(ros2_sqlite_format(), folder.write("flipped.db3", whole.substr(0, at)), with_truth(),
                   "cut");
  }
}

TEST(RosLog, SampleBagsHaveTheirCountsAndSentinels) {
  CREDENCE_DATA_OR_SKIP(data, "logs");
  RecordedSink husky, jackal;
  ros1_bag_format().read(data / "husky_odometry.bag", {}, husky);
  EXPECT_EQ(husky.runs.at(0).steps.size(), 3952U);  // 395 s at 10 Hz
  EXPECT_THAT(husky.said(), HasSubstr("the covariance never changes over 3952 rows"));
  ros1_bag_format().read(data / "jackal_sentinels.bag", {}, jackal);
  EXPECT_EQ(jackal.runs.at(0).steps.size(), 3060U);  // 61 s at 50 Hz
  EXPECT_THAT(jackal.said(),
              HasSubstr("at or above 1e5 means “not estimated”, and is left out of the dof: z, rotation "
                        "x, rotation y in every row"));
  EXPECT_THAT(jackal.said(), Not(HasSubstr("--chart planar"))) << "does nothing without a truth";
  const LogContents mcap = mcap_format().list(data / "cdr_test.mcap");
  const LogContents db3 = ros2_sqlite_format().list(data / "cdr_test.db3");
  for (const LogContents* contents : {&mcap, &db3}) {
    ASSERT_EQ(contents->topics.size(), 2U);
    EXPECT_EQ(contents->topics[0].name, "/test_topic");
    EXPECT_EQ(contents->topics[0].count, 3);
    EXPECT_EQ(contents->topics[1].count, 4);
  }
  EXPECT_EQ(mcap_format().list(data / "talker.mcap").topics.at(2).count, 10);
}

}  // namespace
}  // namespace credence::internal
