#include "analysis/laws/shape/second_moments.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// Eigenvalues of every symmetric matrix within lower ≤ A ≤ upper, entry by entry, by Weyl's inequality: those
// of the centre, give or take the largest eigenvalue of the radii.
ChiSquareBounds eigenvalue_range(const Matrix& lower, const Matrix& upper) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!lower.allFinite() || !upper.allFinite()) return {-kInfinity, kInfinity};
  const auto eigenvalues = [](const Matrix& A) {
    return Vector(Eigen::SelfAdjointEigenSolver<Matrix>(A, Eigen::EigenvaluesOnly).eigenvalues());
  };
  const Vector centre = eigenvalues(0.5 * (lower + upper));
  const double radius = eigenvalues(0.5 * (upper - lower)).maxCoeff();
  return {centre.minCoeff() - radius, centre.maxCoeff() + radius};
}

ChiSquareBounds factor_range(const SecondMoments& moments, double confidence) {
  const Index dim = moments.dim();
  Matrix lower(dim, dim);
  Matrix upper(dim, dim);
  const std::vector<SecondMomentDirection> directions = second_moment_directions(dim);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& [p, q, sign] = directions[i];
    const MeanInterval interval = run_mean_interval(moments.along()[i], confidence);
    if (sign == 0) {
      lower(p, p) = interval.lower;
      upper(p, p) = interval.upper;
    } else if (sign > 0) {
      // A_pq is half the difference of the averages along + and −, which comes next.
      const MeanInterval minus = run_mean_interval(moments.along()[i + 1], confidence);
      lower(p, q) = lower(q, p) = 0.5 * (interval.lower - minus.upper);
      upper(p, q) = upper(q, p) = 0.5 * (interval.upper - minus.lower);
    }
  }
  return eigenvalue_range(lower, upper);
}

}  // namespace

std::vector<SecondMomentDirection> second_moment_directions(Index dim) {
  std::vector<SecondMomentDirection> directions;
  directions.reserve(static_cast<std::size_t>(dim * dim));
  for (Index p = 0; p < dim; ++p) {
    directions.push_back({p, p, 0});
    for (Index q = 0; q < p; ++q) {
      directions.push_back({p, q, 1});
      directions.push_back({p, q, -1});
    }
  }
  return directions;
}

SecondMoments::SecondMoments(Index dim, std::vector<SkewedMoments> along)
    : dim_(dim), along_(std::move(along)) {
  if (dim < 0 || dim > std::ssize(along_) || std::ssize(along_) != dim * dim) {
    throw std::invalid_argument(fmt::format("{} directions of {} dimensions", along_.size(), dim));
  }
}

void SecondMoments::add(MatrixRef run_average) {
  if (run_average.rows() != run_average.cols() || run_average.rows() == 0 ||
      (dim_ != 0 && run_average.rows() != dim_)) {
    throw std::invalid_argument(fmt::format("the average is {}x{}, expected {}x{}", run_average.rows(),
                                            run_average.cols(), dim_, dim_));
  }
  dim_ = run_average.rows();
  const std::vector<SecondMomentDirection> directions = second_moment_directions(dim_);
  along_.resize(directions.size());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& [p, q, sign] = directions[i];
    along_[i].add(0.5 * (run_average(p, p) + run_average(q, q)) + sign * run_average(p, q));
  }
}

void SecondMoments::merge(const SecondMoments& other) {
  if (other.dim_ == 0) return;
  if (dim_ == 0) {
    *this = other;
    return;
  }
  if (dim_ != other.dim_) throw std::invalid_argument(fmt::format("dimension {} and {}", dim_, other.dim_));
  for (std::size_t i = 0; i < along_.size(); ++i) along_[i].merge(other.along_[i]);
}

Matrix mean_of(const SecondMoments& moments) {
  Matrix mean = Matrix::Zero(moments.dim(), moments.dim());
  const std::vector<SecondMomentDirection> directions = second_moment_directions(moments.dim());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& [p, q, sign] = directions[i];
    const double along = moments.along()[i].mean;
    mean(p, q) += sign == 0 ? along : 0.5 * sign * along;
    mean(q, p) = mean(p, q);
  }
  return mean;
}

SecondMomentTest test_second_moments(const SecondMoments& moments, double confidence) {
  require_confidence(confidence);
  SecondMomentTest test;
  test.runs = moments.runs();
  test.p_value = {.optimistic = kNaN, .pessimistic = kNaN};
  test.least_factor = test.largest_factor = kNaN;
  if (moments.dim() == 0) {
    test.reason = "no runs";
    return test;
  }
  std::vector<double> p_values;
  for (const SkewedMoments& along : moments.along()) {
    const DirectedPValues p = run_mean_p_values(along, 1.0);
    p_values.push_back(p.optimistic);
    p_values.push_back(p.pessimistic);
  }
  if (std::ranges::any_of(p_values, [](double p) { return std::isnan(p); })) {
    test.reason = "an average is not finite or not positive semidefinite";
    return test;
  }
  const std::vector<double> adjusted = holm(p_values);
  test.p_value = {};
  for (std::size_t i = 0; i < adjusted.size(); ++i) {
    double& least = i % 2 == 0 ? test.p_value.optimistic : test.p_value.pessimistic;
    least = std::min(least, adjusted[i]);
  }
  const double each = confidence_of_each(confidence, moments.along().size());
  const auto worst = static_cast<std::size_t>(std::ranges::min_element(p_values) - p_values.begin()) / 2;
  test.mean = mean_of(moments);
  const std::vector<SecondMomentDirection> directions = second_moment_directions(moments.dim());
  const auto least_of_side = [&](std::size_t side) {
    std::size_t least = 0;
    for (std::size_t i = 1; i < directions.size(); ++i) {
      if (p_values[2 * i + side] < p_values[2 * least + side]) least = i;
    }
    return directions[least];
  };
  test.worst_direction = directions[worst];
  test.most_optimistic = least_of_side(0);
  test.most_pessimistic = least_of_side(1);
  test.worst = run_mean_interval(moments.along()[worst], each);
  const ChiSquareBounds range = factor_range(moments, each);
  test.least_factor = std::max(0.0, range.lower);
  test.largest_factor = range.upper;
  return test;
}

}  // namespace credence::internal
