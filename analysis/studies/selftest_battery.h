#pragma once

#include <string_view>
#include <vector>

#include "analysis/evidence/advice_cause.h"
#include "analysis/evidence/consistency_correlated.h"
#include "analysis/laws/effective_sample.h"
#include "analysis/studies/selftest_study.h"

namespace credence {

/// How near the false-alarm rate of a test is to its level.
enum class Exactness {
  exact,         ///< equal
  approximate,   ///< nearly equal: a limit law, or matched cumulants
  conservative,  ///< at most, by proof
};

/// "exact", "approximate" or "conservative".
std::string_view to_string(Exactness exactness);

/// One test of the battery on one study.
struct BatteryResult {
  std::string_view name;
  Exactness exactness = Exactness::exact;
  double p_value = 1.0;  ///< NaN where a test has no data
};

/// What the battery knows of a filter before any study.
struct BatteryLaws {
  NeesTimeLaw time_law;
  CorrelatedSteps correlated;
};
BatteryLaws battery_laws(const SyntheticFilter& filter, int runs);

/// Every test of the battery on one study, always in the same order; the last is all of them together, by
/// Holm.
std::vector<BatteryResult> battery_results(const SyntheticFilter& filter, const BatteryLaws& laws,
                                           const SyntheticStudy& study);

/// What find_causes says of one study at this confidence.
std::vector<CauseFound> battery_causes(const SyntheticFilter& filter, const SyntheticStudy& study,
                                       double confidence);

}  // namespace credence
