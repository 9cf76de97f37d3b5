#include "reports/document/logs/log_contents_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/number_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

/// What can be judged comes first.
ReportTable contents_table(const ListedLog& log) {
  using enum ColumnAlign;
  ReportTable table{.title = fmt::format("{} ({})", log.file, log.format),
                    .columns = {{"topic", words},
                                {"type", words},
                                {"messages"},
                                {"Hz", words},
                                {"covariance", words},
                                {"can be", words}}};
  std::vector<LogTopic> topics = log.contents.topics;
  std::stable_partition(topics.begin(), topics.end(),
                        [](const LogTopic& topic) { return !topic.use.empty() && topic.count > 0; });
  for (const LogTopic& topic : topics) {
    table.add({topic.name, topic.type, topic.count,
               std::isnan(topic.rate_hz) ? "–" : number_text(topic.rate_hz, 3),
               topic.covariance ? "yes" : "–", topic.use.empty() ? "–" : topic.use});
  }
  if (!log.contents.remark.empty()) table.notes.push_back(log.contents.remark);
  return table;
}

std::string contents_json(std::span<const ListedLog> logs) {
  Json j;
  j["schema"] = kSchema;
  j["logs"] = json_list(logs, [](const ListedLog& log) -> Json {
    Json topics = json_list(log.contents.topics, [](const LogTopic& topic) -> Json {
      return {{"name", topic.name},
              {"type", topic.type},
              {"messages", topic.count},
              {"rate_hz", topic.rate_hz},
              {"covariance", topic.covariance},
              {"use", topic.use}};
    });
    return {{"file", log.file},
            {"format", log.format},
            {"topics", std::move(topics)},
            {"remark", log.contents.remark}};
  });
  j["null_reason"] = "null: a rate needs two messages with times";
  return text_of_json(j);
}

}  // namespace

Document contents_document(std::vector<ListedLog> logs) {
  Document document("What is in the logs");
  for (const ListedLog& log : logs) document.brief.emplace_back(contents_table(log));
  document.json = [logs = std::move(logs)] { return contents_json(logs); };
  return document;
}

}  // namespace credence::internal
