#pragma once

#include <string>

#include "analysis/tuning/tuning.h"
#include "reports/document/report_table.h"
#include "reports/render/json_numbers.h"

/// @file
/// What every tuning shows, whatever was tuned.

namespace credence::internal {

/// The number, or a dash for NaN.
std::string or_dash(double value, int significant = 4);

/// A parameter as a table has it: "noise.speed_std (m/s)", with the unit of the key of that name.
std::string tuned_name(const std::string& name);

/// "0.08 … 0.12", or a dash for NaN.
std::string tuned_interval_text(double lower, double upper);

/// What can be known, before anything is tuned.
ReportTable tune_forecast_table(const TuningForecast& forecast);

/// Values, intervals and limits. `engine`: "linear filter, exact gradient".
ReportTable tuned_noise_table(const std::string& name, const std::string& engine, const Tuning& tuning);

/// Log score, NIS and lag-one correlation before and after, on the data tuned on.
ReportTable score_gain_table(const Tuning& tuning);

/// "Likelihood ratio 31.2 with 2 dof, p = 1e-7."
std::string likelihood_ratio_text(const Tuning& tuning);

/// "The innovations ask for filter.Q[1,1] = 0.1 (0.08 … 0.12) and agree with the present value in …", of what
/// was found: the data ask for what their interval does not hold the present value of, and for all of it
/// together where only the likelihood ratio speaks against all present values at once. Of a search that did
/// not converge that comes first.
std::string asked_noise_text(const std::string& data, const Tuning& tuning);

/// The answer where nothing was found: why.
ReportAnswer nothing_told(const Tuning& tuning);

/// The members of docs/formats.md that every tuning has: forecast, parameters, correlation, log_score …
Json tuning_json(const Tuning& tuning);

}  // namespace credence::internal
