#pragma once

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// --input ulog: the innovations that PX4's estimator wrote into a flight log.
///
/// Taken are the topics estimator_aid_src_* where there are any, else estimator_innovations joined with
/// estimator_innovation_variances by timestamp_sample. A topic says the last value of a sensor again and
/// again: what does not change is no new innovation. Of several estimators that ran side by side (multi-EKF)
/// one is judged, the first or LogReadOptions::instance.
LogFormat ulog_format();

}  // namespace credence::internal
