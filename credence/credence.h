#pragma once

/// @file
/// Everything that a program of one's own needs of Credence: link Credence::reports and include this.
///
/// An installation has the headers named here and what they include, and no others.

// A filter and a world of one's own, judged: judge_model, judge_filter, judge_experiment (docs/plugin.md).
#include "reports/document/judge_filter.h"

// A planar SLAM filter of one's own in the planar worlds of the scenarios (docs/own_filter.md).
#include "montecarlo/worlds/planar/planar_experiment.h"

// Lie groups, their charts, P carried between charts, and an extended Kalman filter in any of them.
#include "core/filters/chart_ekf.h"
#include "core/manifold/se2.h"
#include "core/manifold/sek3.h"

// Scenarios, their studies, and what is reported of them.
#include "analysis/evidence/study_analysis.h"
#include "analysis/evidence/sweep_analysis.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/sweep_plan.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study_report.h"
#include "reports/document/sweep_report.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"

// Logs of any filter, judged.
#include "datasets/logs/judge_logs.h"
#include "datasets/logs/log_format.h"
#include "reports/document/log_report.h"

// Does P stay bounded? Inflation, Riccati equations, ranks.
#include "analysis/stability/stability_analysis.h"
#include "core/inflation/inflation.h"

#include "core/version.h"
