#pragma once

#include <string>

/// @file
/// Scenarios that several tests of the program run.

namespace credence::internal {

/// Two landmarks on a line: a study of some milliseconds.
inline const std::string kMonobot =
    "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[study]\nruns = 300\nsteps = 30\n";

/// Six configurations of it.
inline const std::string kMonobotSweep =
    "[world]\nmodel = \"monobot\"\n[study]\nruns = 200\nsteps = 30\n[sweep]\n\"world.landmarks\" = \"1:3\"\n"
    "\"filter.inflation\" = \"none, map\"\n";

/// 150 runs with inflation: three chunks.
inline const std::string kLine =
    "[world]\nmodel = \"monobot\"\nlandmarks = 2\n[filter]\ninflation = \"map\"\n[study]\nruns = 150\nsteps "
    "= 12\n";

/// One chunk of its runs takes the better part of an hour.
inline const std::string kLongChunk =
    "[world]\nmodel = \"planar\"\nlandmarks = 100\n[study]\nruns = 64\nsteps = 20000\n";

}  // namespace credence::internal
