#pragma once

#include <span>
#include <vector>

/// @file
/// P-values of several tests, adjusted so that each may be compared with the level of the whole family.
///
/// A NaN p-value (a test without data) is no member of the family and stays NaN. A value outside [0, 1]
/// throws std::invalid_argument. Results are in the order of the input.

namespace credence::internal {

/// The confidence of each of so many intervals or tests (≥ 1) that all together have this one (Bonferroni).
template <class Count>
double confidence_of_each(double confidence, Count of) {
  return 1.0 - (1.0 - confidence) / static_cast<double>(of);
}

/// [Holm 1979]: P(any false rejection) ≤ α under any dependence, never weaker than Bonferroni.
std::vector<double> holm(std::span<const double> p_values);

/// `adjusted` of all items from their `p_value`, by holm.
template <class Item>
void adjust_by_holm(std::vector<Item>& items) {
  std::vector<double> p_values;
  p_values.reserve(items.size());
  for (const Item& item : items) p_values.push_back(item.p_value);
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < items.size(); ++i) items[i].adjusted = adjusted[i];
}

/// Holm's procedure with weights (his section 4): p_i is compared in the order of p_i / w_i, adjusted to
/// max over j before i of min(1, p_j / w_j Σ_{l not before j} w_l). Each test gets the share of the level
/// that its weight has among those not yet rejected. Weights need not sum to one; equal ones give `holm`.
/// Throws std::invalid_argument for sizes that differ or a weight of a member that is not finite and
/// positive.
std::vector<double> weighted_holm(std::span<const double> p_values, std::span<const double> weights);

/// [Benjamini 2001]: expected share of false among the rejections ≤ α under any dependence, by the procedure
/// of [Benjamini 1995] at the price of a factor Σ 1/i.
std::vector<double> benjamini_yekutieli(std::span<const double> p_values);

}  // namespace credence::internal
