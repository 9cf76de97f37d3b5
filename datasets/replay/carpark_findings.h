#pragma once

#include <string>
#include <vector>

#include "datasets/replay/carpark_study.h"

namespace credence::internal {

/// One statement on the car park run with what was measured.
struct CarparkFinding {
  std::string id;          ///< "carpark.order.vehicle.pairwise"
  std::string source;      ///< of the statement in the paper
  std::string statement;   ///< what was to be shown
  std::string measured{};  ///< the numbers
  bool holds = false;
  std::string meaning{};  ///< for the paper's claim; may be empty
  std::string refutes{};  ///< the claim of the paper that fails where this holds; empty: the statement is one
};

/// Everything that the study was made for: the reference, the order of Figures 5 to 7 with both bounds and
/// both P0, independence of P0 with one and with two anchors, and what grows in the long run.
///
/// Precondition: the study is complete. Traces in m², of the vehicle its position, at the end or the largest
/// of the run.
std::vector<CarparkFinding> carpark_findings(const CarparkStudy& study);

/// "flat", "grows slowly", "linear", "exponential" or "falls": flat for a fitted exponent within 0.02,
/// exponential when the growth of a loop exceeds that of the one before by more than 10 %, slow for an
/// exponent below 0.8.
std::string growth_words(const LongHorizonResult& result);

/// Largest over smallest final landmark trace of a variant over the P0 of independence_initials().
double spread_over_initials(const CarparkStudy& study, const CarparkVariant& variant);

}  // namespace credence::internal
