#pragma once

#include <string>

#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// What the ScenarioError says that `load` throws; "accepted" where it throws none.
template <class Load>
std::string scenario_refusal(const Load& load) {
  try {
    load();
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace credence::internal
