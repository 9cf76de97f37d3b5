#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/laws/mean/run_mean.h"
#include "core/nan.h"
#include "core/types.h"
#include "montecarlo/engine/moments.h"

/// @file
/// Whether each component of an innovation is as large as its variance says.
///
/// Of a consistent filter ν_j²/S_jj is χ²(1) and independent from step to step, so that of N steps the sum is
/// χ²(N). Of a step with several observations, as of landmarks, whose innovations are correlated, their
/// average counts, once: it has mean 1 and at most the spread of χ²(1).

namespace credence::internal {

/// One component.
struct ComponentVariance {
  double mean = kNaN;                 ///< of ν_j²/S_jj: the factor on S_jj that makes it right
  double lower = kNaN, upper = kNaN;  ///< at `confidence`, of this component alone
  std::int64_t count = 0;             ///< steps
  DirectedPValues p_value{};          ///< two-sided, of this component alone
};

/// All components of a sensor.
struct ComponentTest {
  std::vector<ComponentVariance> components{};
  DirectedPValues p_value{};  ///< two-sided, Bonferroni over the components: each is compared with α itself
  Index worst = -1;           ///< the component of the least p-value
  std::string_view reason = {};  ///< why there is no test, else empty
};

/// values: the moments of ν_j²/S_jj over the steps, one for each component. A single component is no test
/// beside that of NIS. Where steps are correlated in time N of them are taken as N/correlation_time
/// (square_correlation.h). Throws std::invalid_argument unless 0 < confidence < 1.
ComponentTest test_components(std::span<const Moments> values, double confidence,
                              double correlation_time = 1.0);

}  // namespace credence::internal
