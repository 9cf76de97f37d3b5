#pragma once

#include <span>
#include <string>

#include "core/record/run_layout.h"
#include "core/record/step.h"

namespace credence::internal {

/// The steps of one run as the arrays of docs/logs.md, error, P, innovation and S, in the bytes of an .npz
/// file. States and measurements that are not there are NaN; without any innovation there is no such array.
/// The steps are not none. step_s: the time of a step, s, for the array time; 0: none.
std::string run_arrays(const RunLayout& layout, std::span<const Step> steps, double step_s = 0.0);

}  // namespace credence::internal
