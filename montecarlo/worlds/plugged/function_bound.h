#pragma once

#include "montecarlo/worlds/plugged/model_plug.h"
#include "montecarlo/worlds/plugged/plugged_experiment.h"
#include "montecarlo/worlds/posterior_bound.h"

namespace credence {

/// The posterior Cramér-Rao bound of a model, each step measured with probability `detection`. It has a
/// reason where Q is singular and f is not linear, as its Jacobian or differences say, and where R is
/// singular. Its truths are those of PluggedExperiment.
PosteriorBound posterior_bound(const FunctionModel& model, const PlugSettings& settings,
                               double detection = 1.0, std::int64_t runs = internal::kBoundRuns);

}  // namespace credence
