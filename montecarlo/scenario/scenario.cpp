#include "montecarlo/scenario/scenario.h"

namespace credence {

using namespace internal;

std::string_view to_string(Observability value) {
  switch (value) {
    case Observability::partial: return "partial";
    case Observability::full: return "full";
  }
  return "";
}

std::string_view to_string(VehicleKind value) {
  switch (value) {
    case VehicleKind::unicycle: return "unicycle";
    case VehicleKind::bicycle: return "bicycle";
    case VehicleKind::car: return "car";
  }
  return "";
}

std::string_view to_string(PathShape value) {
  switch (value) {
    case PathShape::circle: return "circle";
    case PathShape::eight: return "eight";
    case PathShape::line: return "line";
  }
  return "";
}

std::string_view to_string(FilterInflation value) {
  switch (value) {
    case FilterInflation::none: return "none";
    case FilterInflation::full: return "full";
    case FilterInflation::map: return "map";
    case FilterInflation::rank: return "rank";
  }
  return "";
}

std::string_view to_string(InflationSolution value) {
  switch (value) {
    case InflationSolution::pairwise: return "pairwise";
    case InflationSolution::min_trace: return "min-trace";
    case InflationSolution::sequential: return "sequential";
    case InflationSolution::batch: return "batch";
    case InflationSolution::drop: return "drop";
  }
  return "";
}

std::string_view to_string(InflationRange value) {
  switch (value) {
    case InflationRange::generic: return "generic";
    case InflationRange::map: return "map";
    case InflationRange::with_vehicle: return "with-vehicle";
    case InflationRange::difference: return "difference";
  }
  return "";
}

std::string_view to_string(StopVerdict value) {
  switch (value) {
    case StopVerdict::none: return "none";
    case StopVerdict::inconsistent: return "inconsistent";
    case StopVerdict::either: return "either";
  }
  return "";
}

}  // namespace credence
