#include "reports/document/sweep/shard_report.h"

#include <utility>

#include "reports/document/sweep/swept_values.h"
#include "reports/document/verdict_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

std::string shard_json(const SweepPlan& plan, const ShardRuns& shard) {
  std::int64_t asked = 0, done = 0;
  Json configurations = Json::array();
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    const ShardRuns::Configuration& of = shard.configurations[i];
    asked += of.asked;
    done += of.done;
    configurations.push_back({{"configuration", plan.points[i].id},
                              {"swept", swept_json(plan, plan.points[i])},
                              {"runs", of.done},
                              {"remaining", of.asked - of.done}});
  }
  Json j;
  j["schema"] = kSchema;
  j["name"] = plan.name;
  j["points"] = plan.points.size();
  j["skipped_impossible"] = plan.skipped;
  j["shard"] = {{"number", shard.number},
                {"of", shard.of},
                {"directory", shard.directory},
                {"complete", done == asked},
                {"runs", done},
                {"remaining", asked - done},
                {"configurations", std::move(configurations)}};
  j["configurations"] = Json::array();
  return text_of_json(j);
}

}  // namespace

Document shard_document(const SweepPlan& plan, const ShardRuns& shard) {
  Document document(plan.name);
  document.json = [plan, shard] { return shard_json(plan, shard); };
  return document;
}

}  // namespace credence::internal
