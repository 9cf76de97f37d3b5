#include "montecarlo/scenario/scenario.h"

#include "core/enum_words.h"

namespace credence {

using namespace internal;

std::string_view to_string(Observability value) { return word_of(value, {"partial", "full"}); }

std::string_view to_string(VehicleKind value) { return word_of(value, {"unicycle", "bicycle", "car"}); }

std::string_view to_string(PathShape value) { return word_of(value, {"circle", "eight", "line"}); }

std::string_view to_string(FilterInflation value) { return word_of(value, {"none", "full", "map", "rank"}); }

std::string_view to_string(InflationSolution value) {
  return word_of(value, {"pairwise", "min-trace", "sequential", "batch", "drop"});
}

std::string_view to_string(InflationRange value) {
  return word_of(value, {"generic", "map", "with-vehicle", "difference"});
}

std::string_view to_string(StopVerdict value) { return word_of(value, {"none", "inconsistent", "either"}); }

}  // namespace credence
