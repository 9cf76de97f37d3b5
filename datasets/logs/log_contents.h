#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/nan.h"

namespace credence::internal {

/// One series of messages, or one array, in a log.
struct LogTopic {
  std::string name;
  std::string type;
  std::int64_t count = 0;
  double rate_hz = kNaN;  ///< messages but one, over the time between first and last; NaN: not known
  /// What it can be: "estimate", "truth", "innovations", … "" where nothing here can use it.
  std::string use;
  bool covariance = false;
};

/// What is in a log, without judging it.
struct LogContents {
  std::vector<LogTopic> topics;
  std::string remark;  ///< a sentence, or nothing
};

/// (count − 1) / (last − first), times in seconds; NaN for fewer than two.
double message_rate(std::int64_t count, double first_s, double last_s);

}  // namespace credence::internal
