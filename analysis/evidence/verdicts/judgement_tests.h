#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/evidence/verdicts/judgement.h"

/// @file
/// The test suite, by name.

namespace credence::internal {

inline constexpr const char* kNisBody = "NIS against its law, body";
inline constexpr const char* kNisTails = "NIS against its law, tails";
inline constexpr const char* kWhiteness = "whiteness of the innovation";
inline constexpr const char* kInnovationMean = "mean of the innovation";
inline constexpr const char* kComponents = "components of the innovation";
inline constexpr const char* kPairs = "pairs of components of the innovation";
inline constexpr const char* kErrorMean = "mean of the errors";
inline constexpr const char* kErrorCorrelation = "correlation of the whitened errors";
inline constexpr const char* kHeavyTails = "tails of NEES and NIS";
inline constexpr const char* kNisOverTime = "NIS over time";

/// The name of that test.
std::string over_time_test(const NeesOverTime& nees);

/// The name of a test of two sensors.
std::string pair_test(const SensorPairJudgement& pair);

/// The name of a test of one sensor.
std::string of_sensor(const char* test, const SensorJudgement& sensor);

/// "component 2 of radar", or of the innovation.
std::string component_name(const SensorJudgement& sensor, Index component);

/// The direction of SensorJudgement::pairs: "components 1 + 2 of radar", each over its σ.
std::string pair_name(const SensorJudgement& sensor, Index direction);

/// All tests that were made or have a reason why not, adjusted for being so many (Holm).
std::vector<NamedTest> list_tests(const Evidence& evidence, const Judgement& judged);

/// Whether a test speaks against the filter when the whole suite is taken together; a cause named for less
/// would be a guess.
bool speaks(const Judgement& judged, std::string_view name);

/// Whether NEES of one of the blocks does, each by itself.
bool any_block_is_wrong(const Judgement& judged);

}  // namespace credence::internal
