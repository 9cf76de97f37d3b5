#include "analysis/laws/joint/multiple_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "analysis/laws/require.h"

namespace credence::internal {
namespace {

// Positions of the tests with a p-value.
std::vector<std::size_t> members(std::span<const double> p_values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p_values.size(); ++i) {
    if (std::isnan(p_values[i])) continue;
    if (!(p_values[i] >= 0.0 && p_values[i] <= 1.0)) {
      throw std::invalid_argument(fmt::format("p-value {} of test {} must lie in [0, 1]", p_values[i], i));
    }
    order.push_back(i);
  }
  return order;
}

// The members with the smallest p-value first; ties in the order of the input.
std::vector<std::size_t> ascending_order(std::span<const double> p_values) {
  std::vector<std::size_t> order = members(p_values);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  return order;
}

}  // namespace

std::vector<double> holm(std::span<const double> p_values) {
  return weighted_holm(p_values, std::vector<double>(p_values.size(), 1.0));
}

std::vector<double> weighted_holm(std::span<const double> p_values, std::span<const double> weights) {
  if (p_values.size() != weights.size()) {
    throw std::invalid_argument(fmt::format("{} p-values but {} weights", p_values.size(), weights.size()));
  }
  std::vector<std::size_t> order = members(p_values);
  for (const std::size_t i : order) require_positive("weight", weights[i]);
  // p_a / w_a < p_b / w_b, without a division.
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return p_values[a] * weights[b] < p_values[b] * weights[a];
  });
  std::vector<double> adjusted(p_values.begin(), p_values.end());
  std::vector<double> remaining(order.size());
  double weight = 0.0;
  for (std::size_t rank = order.size(); rank > 0; --rank) {
    weight += weights[order[rank - 1]];
    remaining[rank - 1] = weight;
  }
  double largest = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const std::size_t i = order[rank];
    largest = std::max(largest, std::min(1.0, p_values[i] / weights[i] * remaining[rank]));
    adjusted[i] = largest;
  }
  return adjusted;
}

std::vector<double> benjamini_yekutieli(std::span<const double> p_values) {
  std::vector<double> adjusted(p_values.begin(), p_values.end());
  const std::vector<std::size_t> order = ascending_order(p_values);
  const double tests = static_cast<double>(order.size());
  double harmonic = 0.0, smallest = 1.0;
  for (std::size_t rank = 1; rank <= order.size(); ++rank) harmonic += 1.0 / static_cast<double>(rank);
  for (std::size_t rank = order.size(); rank > 0; --rank) {
    const std::size_t i = order[rank - 1];
    smallest = std::min(smallest, p_values[i] * harmonic * tests / static_cast<double>(rank));
    adjusted[i] = smallest;
  }
  return adjusted;
}

}  // namespace credence::internal
