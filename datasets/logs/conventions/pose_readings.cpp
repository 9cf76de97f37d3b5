#include "datasets/logs/conventions/pose_readings.h"

#include <fmt/format.h>

#include <utility>

#include "core/manifold/angle.h"

namespace credence::internal {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// W ← D W D, D of these numbers, the rotation's rows where the chart has them.
void scale(PoseCovariance& written, const PoseChart& chart, double position,
           const Eigen::Vector3d& rotation) {
  Vector6 factors;
  if (chart.rotation_first) {
    factors << rotation, Eigen::Vector3d::Constant(position);
  } else {
    factors << Eigen::Vector3d::Constant(position), rotation;
  }
  written = (factors.asDiagonal() * written * factors.asDiagonal()).eval();
}

/// x y z w, read from the file in this order, were w x y z.
Eigen::Quaterniond scalar_first(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

/// Signed squares: of standard deviations, and of sign(c) √|c|.
void square(PoseCovariance& written) { written = written.cwiseProduct(written.cwiseAbs()).eval(); }

bool invert(PoseCovariance& written, std::span<const Index> components) {
  const Matrix block = written(components, components);
  const Eigen::LLT<Matrix> factor(block);
  if (factor.info() != Eigen::Success) return false;
  const Matrix inverse = factor.solve(Matrix::Identity(block.rows(), block.cols()));
  written(components, components) = inverse;
  return true;
}

/// The upper triangle by rows was the lower one: the k-th number of either stands elsewhere.
void swap_triangles(PoseCovariance& written) {
  PoseCovariance meant;
  Index i = 0, j = 0;  // in the lower triangle
  for (Index row = 0; row < 6; ++row) {
    for (Index column = row; column < 6; ++column) {
      meant(i, j) = meant(j, i) = written(row, column);
      if (j++ == i) {
        ++i;
        j = 0;
      }
    }
  }
  written = meant;
}

/// North, east, down where east, north, up is meant.
void swap_axes(PoseCovariance& written) {
  Eigen::Matrix3d swap;
  swap << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0;
  PoseCovariance both = PoseCovariance::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = swap;
  written = (both * written * both.transpose()).eval();
}

template <class Change>
auto always(Change change) {
  return [change](PoseSample& sample) {
    change(sample);
    return true;
  };
}

class MistakeList {
 public:
  explicit MistakeList(const PoseChart& declared) : declared_(declared) {}

  void add(std::string cause, std::string repair, std::function<bool(PoseSample&)> change) {
    list_.push_back({std::move(cause), std::move(repair), declared_, std::move(change)});
  }
  void add_chart(const PoseChart& chart, std::string cause, std::string repair) {
    for (const PoseReading& reading : list_) {
      if (same(reading.chart, chart) && !reading.change) return;
    }
    if (!same(chart, declared_)) list_.push_back({std::move(cause), std::move(repair), chart});
  }
  std::vector<PoseReading> take() { return std::move(list_); }

 private:
  static bool same(const PoseChart& a, const PoseChart& b) {
    return a.axes == b.axes && a.rotation_first == b.rotation_first;
  }

  const PoseChart& declared_;
  std::vector<PoseReading> list_;
};

void add_charts(const PoseChart& declared, MistakeList& list) {
  for (const PoseChart& chart : pose_charts()) {
    if (chart.axes.orientation == OrientationError::planar) continue;
    list.add_chart(chart, fmt::format("it is written in the chart {}: {}", chart.name, chart.says),
                   fmt::format("--chart {}", chart.name));
  }
  PoseChart swapped = declared;
  swapped.rotation_first = !declared.rotation_first;
  list.add_chart(swapped,
                 declared.rotation_first ? "its rows are in the order position, rotation"
                                         : "its rows are in the order rotation, position",
                 "write the blocks in the order of the chart");
  if (declared.axes.unit == RotationUnit::vector) {
    PoseChart half = declared;
    half.axes.unit = RotationUnit::half_vector;
    list.add_chart(half, "its rotation is of half angles, the vector part of a quaternion",
                   "times 4 on the rotation's block, times 2 on its rows beside it");
  } else {
    PoseChart whole = declared;
    whole.axes.unit = RotationUnit::vector;
    list.add_chart(whole, "its rotation is of whole angles, not of half ones",
                   "a chart whose rotation is a vector of angles");
  }
  if (declared.axes.position != PositionError::twist) {
    PoseChart turned = declared;
    turned.axes.position =
        declared.axes.position == PositionError::body ? PositionError::world : PositionError::body;
    list.add_chart(turned,
                   declared.axes.position == PositionError::body ? "its position is in the axes of the world"
                                                                 : "its position is in the axes of the body",
                   "turn the position's block, or a chart that has it so");
  }
}

std::function<bool(PoseSample&)> scaled(const PoseChart& chart, double position,
                                        const Eigen::Vector3d& rotation) {
  return always([=](PoseSample& s) { scale(s.written, chart, position, rotation); });
}

void add_numbers(const PoseChart& declared, MistakeList& list) {
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  list.add("its rotation is in degrees", "radians", scaled(declared, 1.0, kRadiansPerDegree * one));
  list.add("its position is in millimetres", "metres", scaled(declared, 1e-3, one));
  list.add("its position is in centimetres", "metres", scaled(declared, 1e-2, one));
  list.add("it holds standard deviations, not variances", "squares",
           always([](PoseSample& s) { square(s.written); }));
  list.add("it is the information matrix", "its inverse",
           [components = estimated_components(declared.axes)](PoseSample& s) {
             return invert(s.written, components);
           });
}

/// Those of six rows.
void add_rows(const PoseChart& declared, MistakeList& list) {
  constexpr std::string_view kNames[] = {"first", "second", "third"};
  for (Index i = 0; i < 3; ++i) {
    Eigen::Vector3d one = Eigen::Vector3d::Ones();
    one[i] = kRadiansPerDegree;
    list.add(fmt::format("the {} of its rotation angles is in degrees, the others are not",
                         kNames[static_cast<std::size_t>(i)]),
             "radians in every row", scaled(declared, 1.0, one));
  }
  list.add("its numbers are those of the lower triangle by rows", "the upper triangle by rows",
           always([](PoseSample& s) { swap_triangles(s.written); }));
  list.add("its axes are north, east, down, those of the poses east, north, up (or the reverse)",
           "the axes of the poses", always([](PoseSample& s) { swap_axes(s.written); }));
}

void add_poses(MistakeList& list) {
  struct Body {
    const char* name;
    SpatialPose PoseSample::*pose;
  };
  for (const Body body : {Body{"estimate", &PoseSample::estimate}, Body{"truth", &PoseSample::truth}}) {
    const auto pose = body.pose;
    list.add(fmt::format("the quaternions of the {} have the scalar first (w x y z)", body.name), "x y z w",
             always([pose](PoseSample& s) { (s.*pose).orientation = scalar_first((s.*pose).orientation); }));
    list.add(fmt::format("the quaternions of the {} are transposed, from the world to the body", body.name),
             "their conjugates",
             always([pose](PoseSample& s) { (s.*pose).orientation = (s.*pose).orientation.conjugate(); }));
    list.add(fmt::format("the poses of the {} are inverted, the world in the body", body.name),
             "their inverses", always([pose](PoseSample& s) { s.*pose = inverse(s.*pose); }));
    list.add(fmt::format("the positions of the {} are in millimetres", body.name), "metres",
             always([pose](PoseSample& s) { (s.*pose).position *= 1e-3; }));
  }
}

}  // namespace

bool PoseReading::read(PoseSample sample, PoseError& error, PoseCovariance& P) const {
  if (change && !change(sample)) return false;
  error = pose_error(sample.estimate, sample.truth, chart.axes);
  P = chart.position_first(sample.written);
  if (!sample.truth_covariance.isZero(0.0)) {
    P += transported(sample.truth_covariance, sample.truth, kFixedAxes, chart.axes);
  }
  if (chart.axes.unit != RotationUnit::vector) {
    error.tail<3>() *= 2.0;
    P.bottomRows<3>() *= 2.0;
    P.rightCols<3>() *= 2.0;
  }
  return true;
}

std::vector<PoseReading> mistaken_readings(const PoseChart& declared) {
  MistakeList list(declared);
  add_numbers(declared, list);
  if (declared.axes.orientation != OrientationError::planar) {
    add_charts(declared, list);
    add_rows(declared, list);
  }
  add_poses(list);
  return list.take();
}

}  // namespace credence::internal
