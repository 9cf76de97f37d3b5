#include "analysis/stability/unobservable_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "analysis/stability/dense_svd.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

constexpr int kListedComponents = 4;
constexpr double kLargestSine = 1e-6;  // of a symmetry to the space

bool is_line(const BlockLayout& layout) { return layout.vehicle == 1 && layout.landmark == 1; }
bool is_plane(const BlockLayout& layout) { return layout.vehicle == 3 && layout.landmark == 2; }

void require_sizes(const Matrix& unobservable, const BlockLayout& layout, const Vector& point,
                   const Matrix& anchors) {
  const Index n = layout.state_dim();
  if (unobservable.rows() != n) {
    throw std::invalid_argument(
        fmt::format("directions have {} components and the layout {} states", unobservable.rows(), n));
  }
  if (point.size() != 0 && point.size() != n) {
    throw std::invalid_argument(
        fmt::format("the linearisation point has {} states, not {}", point.size(), n));
  }
  if (anchors.size() != 0 && anchors.rows() != 2) {
    throw std::invalid_argument(fmt::format("anchors have {} rows and must have 2", anchors.rows()));
  }
}

/// Everything moves by one metre along axis 0 (x) or 1 (y).
Vector translation(const BlockLayout& layout, Index axis) {
  Vector direction = Vector::Zero(layout.state_dim());
  direction[axis] = 1.0;
  for (Index i = 0; i < layout.landmarks; ++i) direction[layout.landmark_offset(i) + axis] = 1.0;
  return direction;
}

/// Everything turns by one radian about a centre.
Vector rotation(const BlockLayout& layout, const Vector& point, const Eigen::Vector2d& centre) {
  Vector direction = Vector::Zero(layout.state_dim());
  const auto turn = [&](Index offset) {
    direction[offset] = -(point[offset + 1] - centre.y());
    direction[offset + 1] = point[offset] - centre.x();
  };
  turn(0);
  direction[2] = 1.0;
  for (Index i = 0; i < layout.landmarks; ++i) turn(layout.landmark_offset(i));
  return direction;
}

/// The symmetries that SLAM with this layout could have, in the order in which they are looked for.
std::vector<NamedDirection> candidates(const BlockLayout& layout, const Vector& point,
                                       const Matrix& anchors) {
  std::vector<NamedDirection> found;
  if (is_line(layout)) found.push_back({"common translation", translation(layout, 0)});
  if (!is_plane(layout)) return found;
  found.push_back({"common translation x", translation(layout, 0)});
  found.push_back({"common translation y", translation(layout, 1)});
  if (point.size() == 0) return found;
  found.push_back({"rotation about the origin", rotation(layout, point, Eigen::Vector2d::Zero())});
  for (Index i = 0; i < anchors.cols(); ++i) {
    const Eigen::Vector2d anchor = anchors.col(i);
    found.push_back({fmt::format("rotation about the anchor ({:g}, {:g})", anchor.x(), anchor.y()),
                     rotation(layout, point, anchor)});
  }
  return found;
}

/// What of the space is left to name: an orthonormal basis, made smaller by each name given.
class Remainder {
 public:
  explicit Remainder(const Matrix& basis) : space_(basis), left_(basis) {}

  bool contains(const Vector& unit) const {
    return (unit - space_ * (space_.transpose() * unit)).norm() <= kLargestSine;
  }

  /// The direction is not spanned by those named before.
  bool is_new(const Vector& unit) const { return (left_.transpose() * unit).norm() > kLargestSine; }

  void remove(const Vector& unit) {
    const Vector along = left_.transpose() * unit;
    const DenseSvd svd = dense_svd(along, SvdVectors::full_left);
    left_ = (left_ * svd.U.rightCols(left_.cols() - 1)).eval();
  }

  const Matrix& left() const { return left_; }

 private:
  Matrix space_, left_;
};

/// The name of a combination of the planar symmetries: a rotation about some point, or an oblique shift.
std::string name_of_motion(const Vector& point, const Vector& unit) {
  const double turn = unit[2];
  const double size = unit.norm();
  if (std::abs(turn) <= 1e-9 * size) {
    const double length = std::hypot(unit[0], unit[1]);
    const double sign = unit[0] < 0.0 ? -1.0 : 1.0;
    return fmt::format("common translation along ({:.3g}, {:.3g})", sign * unit[0] / length,
                       sign * unit[1] / length);
  }
  // v = (−(y − c_y), x − c_x) · turn for the vehicle.
  const double centre_x = point[0] - unit[1] / turn;
  const double centre_y = point[1] + unit[0] / turn;
  return fmt::format("rotation about the point ({:.4g}, {:.4g})", centre_x, centre_y);
}

/// Combinations of planar symmetries that lie in what is left.
void name_combinations(const BlockLayout& layout, const Vector& point, Remainder& remainder,
                       std::vector<NamedDirection>& names) {
  Matrix motions(layout.state_dim(), point.size() == 0 ? 2 : 3);
  motions.col(0) = translation(layout, 0);
  motions.col(1) = translation(layout, 1);
  if (point.size() != 0) motions.col(2) = rotation(layout, point, Eigen::Vector2d::Zero());
  const Matrix basis = dense_svd(motions, SvdVectors::left).U;
  while (remainder.left().cols() > 0) {
    const DenseSvd common = dense_svd(basis.transpose() * remainder.left(), SvdVectors::right);
    const Vector unit = remainder.left() * common.V.col(0);
    if ((unit - basis * (basis.transpose() * unit)).norm() > kLargestSine) return;
    names.push_back({name_of_motion(point, unit), unit});
    remainder.remove(unit);
  }
}

std::string list_components(const Vector& unit, const std::vector<std::string>& states) {
  std::vector<Index> order(static_cast<std::size_t>(unit.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, [&](Index a, Index b) { return std::abs(unit[a]) > std::abs(unit[b]); });
  const double largest = std::abs(unit[order.front()]);
  std::string text;
  int listed = 0;
  for (const Index i : order) {
    if (std::abs(unit[i]) < 0.01 * largest) break;
    if (listed++ == kListedComponents) return text + ", …";
    append_item(text, fmt::format("{:.2f} {}", unit[i], states[static_cast<std::size_t>(i)]));
  }
  return text;
}

}  // namespace

std::vector<NamedDirection> name_unobservable(const Matrix& unobservable, const BlockLayout& layout,
                                              const Vector& linearisation_point, const Matrix& anchors) {
  require_sizes(unobservable, layout, linearisation_point, anchors);
  std::vector<NamedDirection> names;
  Remainder remainder(unobservable);
  for (NamedDirection& candidate : candidates(layout, linearisation_point, anchors)) {
    candidate.direction.normalize();
    if (!remainder.contains(candidate.direction)) continue;
    if (!remainder.is_new(candidate.direction)) continue;
    remainder.remove(candidate.direction);
    names.push_back(std::move(candidate));
  }
  if (is_plane(layout)) name_combinations(layout, linearisation_point, remainder, names);
  for (NamedDirection& listed : name_unobservable(remainder.left(), state_names(layout))) {
    names.push_back(std::move(listed));
  }
  return names;
}

std::vector<NamedDirection> name_unobservable(const Matrix& unobservable,
                                              const std::vector<std::string>& states) {
  if (unobservable.rows() != std::ssize(states)) {
    throw std::invalid_argument(fmt::format("directions have {} components and there are {} names",
                                            unobservable.rows(), states.size()));
  }
  std::vector<NamedDirection> names;
  for (Index j = 0; j < unobservable.cols(); ++j) {
    const Vector unit = unobservable.col(j);
    names.push_back({list_components(unit, states), unit});
  }
  return names;
}

std::vector<std::string> state_names(const BlockLayout& layout) {
  std::vector<std::string> names;
  if (is_line(layout)) {
    names.push_back("r");
    for (Index i = 1; i <= layout.landmarks; ++i) names.push_back(fmt::format("f{}", i));
  } else if (is_plane(layout)) {
    names = {"x", "y", "heading"};
    for (Index i = 1; i <= layout.landmarks; ++i) {
      names.push_back(fmt::format("f{}x", i));
      names.push_back(fmt::format("f{}y", i));
    }
  } else {
    for (Index i = 1; i <= layout.state_dim(); ++i) names.push_back(fmt::format("x{}", i));
  }
  return names;
}

}  // namespace credence::internal
