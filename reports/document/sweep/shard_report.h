#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "montecarlo/scenario/sweep_plan.h"
#include "reports/document/document.h"

namespace credence::internal {

/// What a shard of a sweep has done.
struct ShardRuns {
  int number = 1, of = 1;
  std::string directory;  ///< where it is stored
  struct Configuration {
    std::int64_t asked = 0, done = 0;  ///< runs of this shard
  };
  std::vector<Configuration> configurations;  ///< one for each point of the plan
};

/// What `credence sweep --shard i/n` says: a part has no verdict, so that there is only what was done of it,
/// as data (docs/formats.md).
Document shard_document(const SweepPlan& plan, const ShardRuns& shard);

}  // namespace credence::internal
