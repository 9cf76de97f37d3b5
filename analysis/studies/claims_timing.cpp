#include <fmt/format.h>

#include <algorithm>

#include "analysis/studies/claims.h"

namespace credence::internal {
namespace {

/// Between linear and quadratic.
constexpr double kDividingExponent = 1.5;

const GrowthFit* find_fit(std::span<const GrowthFit> fits, TimedFilter filter) {
  const auto fit = std::ranges::find(fits, filter, &GrowthFit::filter);
  return fit == fits.end() ? nullptr : &*fit;
}

std::string exponent_text(const PowerLaw& law) {
  return fmt::format("N^{:.2f} (95 % {:.2f} … {:.2f})", law.exponent, law.lower, law.upper);
}

}  // namespace

Claim linear_time_claim(std::span<const FilterTime> times) {
  Claim claim{.id = "linear-time",
              .source = "section 5",
              .statement = "a decorrelated map makes the filter linear in the number of landmarks",
              .measured = "too few sizes of the map were timed"};
  const std::vector<GrowthFit> fits = fit_growth(times);
  const GrowthFit *map = find_fit(fits, TimedFilter::map), *full = find_fit(fits, TimedFilter::full);
  if (map == nullptr || full == nullptr) return claim;
  Index largest = 0;
  for (const FilterTime& time : times) largest = std::max(largest, time.landmarks);
  claim.measured =
      fmt::format("time of a step with {} landmarks in view, to N = {}: block diagonal map {}, full P {}",
                  map->observed, largest, exponent_text(map->law), exponent_text(full->law));
  if (map->law.upper < kDividingExponent) {
    claim.verdict = ClaimVerdict::holds;
  } else if (map->law.lower > kDividingExponent) {
    claim.verdict = ClaimVerdict::fails;
  } else {
    claim.measured += fmt::format("; the interval holds {}: time it again on a machine that is less busy",
                                  kDividingExponent);
  }
  return claim;
}

std::vector<Claim> timing_claims(const std::atomic<bool>* stop) {
  const FilterTimingPlan plan{
      .landmarks = {300, 600, 1200, 2400, 9600, 38'400}, .observed = {2}, .timing = {.repetitions = 7}};
  const std::vector<FilterTime> times = time_filter_steps(plan, stop);
  if (times.empty()) return {};
  return {linear_time_claim(times)};
}

}  // namespace credence::internal
