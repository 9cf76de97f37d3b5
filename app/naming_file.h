#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

#include "montecarlo/scenario/scenario.h"

namespace credence::internal {

/// What `work` returns. The libraries know keys and values but no files: what they refuse
/// (std::invalid_argument) is thrown on as a ScenarioError that begins with the file of these values.
template <class Work>
auto naming_file(const std::string& file, Work work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace credence::internal
