#pragma once

#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/monobot/monobot_world.h"

/// @file
/// Monobots that miss measurements.

namespace credence::internal {

inline Scenario intermittent_monobot(Index landmarks, Index anchors, double probability) {
  Scenario s = default_scenario("monobot");
  s.world.landmarks = landmarks;
  s.world.observability = anchors > 0 ? Observability::full : Observability::partial;
  s.world.anchors = anchors;
  s.noise.detection_probability = probability;
  s.study.steps = 30;
  return s;
}

struct IntermittentCase {
  std::string name;
  Scenario scenario;
};

/// Every kernel of the lanes, with every rule that goes in them, and a filter that is wrong about Q and R.
inline std::vector<IntermittentCase> intermittent_cases() {
  std::vector<IntermittentCase> all;
  for (const Index landmarks : {0, 1, 2, 6}) {
    for (const Index anchors : {0, 1, 2}) {
      if (landmarks + anchors == 0) continue;
      for (const FilterInflation inflation :
           {FilterInflation::none, FilterInflation::full, FilterInflation::map, FilterInflation::rank}) {
        if (inflation == FilterInflation::rank && landmarks == 0) continue;
        Scenario s = intermittent_monobot(landmarks, anchors, 0.7);
        s.filter.inflation = inflation;
        s.filter.inflation_scale = 0.02;
        s.filter.measurement_scale = 0.8;
        s.filter.process_scale = 1.3;
        all.push_back({std::to_string(landmarks) + " landmarks, " + std::to_string(anchors) + " anchors, " +
                           std::string(to_string(inflation)),
                       s});
      }
    }
  }
  return all;
}

}  // namespace credence::internal
