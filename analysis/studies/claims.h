#pragma once

#include <atomic>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/studies/filter_timing.h"

/// @file
/// What the paper claims, each with what is measured of it.

namespace credence::internal {

enum class ClaimVerdict {
  holds,
  conditional,  ///< it holds under a condition that the paper does not state
  fails,
  not_measured,  ///< the evidence needs data that is not at hand; `measured` says which
};

/// "holds", "conditional", "fails", "not measured".
std::string_view to_string(ClaimVerdict verdict);

/// One claim with its evidence.
struct Claim {
  std::string id;          ///< short and stable: "unit-eigenvalue"
  std::string source;      ///< equation, figure or section of the paper
  std::string statement;   ///< what the paper says
  std::string measured;    ///< with the paper's size of the problem; numbers computed now
  std::string long_run{};  ///< what happens far beyond the paper's 100 steps, or what it means; empty:
                           ///< nothing is to be added
  ClaimVerdict verdict = ClaimVerdict::not_measured;
};

/// The claims on the monobot, with the paper's Q = R = 0.1, P0 = I and 100 steps (theory, sections 3 to 6).
/// Everything is computed from covariances and single runs; no Monte Carlo. Takes about a second.
std::vector<Claim> monobot_claims();

/// What the fitted exponents of time against the size of the map say of "linear in the number of landmarks":
/// it holds where that of the block diagonal map is below 1.5, interval and all, fails where it is above, and
/// is not measured where the interval holds 1.5 or there is no fit, as on a machine that is busy.
Claim linear_time_claim(std::span<const FilterTime> times);

/// The claim on time, from short interleaved timings of a few seconds; empty when stopped.
std::vector<Claim> timing_claims(const std::atomic<bool>* stop = nullptr);

/// The claims on the plane: ranks and growth along so many loops, at least four, of a circle with six
/// landmarks and a range of 12 m (theory, section 5). Twenty take a few seconds.
std::vector<Claim> planar_claims(Index loops = 20);

}  // namespace credence::internal
