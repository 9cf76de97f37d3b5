#include "reports/document/check_logs.h"

#include <utility>

#include "datasets/logs/log_name.h"
#include "reports/document/checked_logs.h"
#include "reports/document/judged.h"

namespace credence {

JudgedFilter check_logs(std::span<const std::string> logs, const CheckOptions& options) {
  CheckedLogs checked = checked_logs(log_files(logs), options, {.keep_first_run = true});
  checked.name = options.name.empty() ? log_name(logs.front()) : options.name;
  return JudgedFilter(judged_logs(std::move(checked)));
}

}  // namespace credence
