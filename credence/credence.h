#pragma once

/// @file
/// Everything that a program of one's own needs of Credence: link Credence::reports and include this.
///
/// An installation has the headers named here and what they include, and no others. What they hold in the
/// namespace credence is the interface (docs/cpp.md); credence::internal may change at any time.

// A filter and a world of one's own, judged: judge_model, judge_filter, judge_experiment (docs/plugin.md).
#include "montecarlo/worlds/plugged/function_bound.h"
#include "montecarlo/worlds/plugged/function_ukf.h"
#include "reports/document/judge/judge_filter.h"

// A planar SLAM filter of one's own in the planar worlds of the scenarios (docs/own_filter.md).
#include "montecarlo/worlds/planar/planar_experiment.h"

// Scenarios and logs of any filter, judged: judge_scenario, check_logs.
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "reports/document/judge/judge_scenario.h"
#include "reports/document/logs/check_logs.h"

// Lie groups, their charts, P carried between charts, and an extended Kalman filter in any of them.
#include "core/filters/chart_ekf.h"
#include "core/manifold/se2.h"
#include "core/manifold/sek3.h"

// Does P stay bounded? Inflation, Riccati equations, ranks.
#include "analysis/stability/stability_analysis.h"
#include "core/inflation/inflation.h"

#include "core/version.h"

namespace credence {

// What the functions above take or give, and is used within as well.
using internal::Anchor, internal::ArrowCovariance, internal::BlockLayout, internal::MapBound;
using internal::MinTraceOptions, internal::MinTraceState, internal::RiccatiProblem;
using internal::PlacedLandmark, internal::PredictedRangeBearing, internal::RunAverages, internal::RunSum;

}  // namespace credence
