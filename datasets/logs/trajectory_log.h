#pragma once

#include "datasets/logs/log_format.h"

/// @file
/// Trajectories in text files as formats of logs; their truth is in files of its own.

namespace credence::internal {

LogFormat tum_format();
LogFormat openvins_format();
LogFormat cnspy_format();
LogFormat pose_csv_format();

}  // namespace credence::internal
