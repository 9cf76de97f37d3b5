#include "datasets/logs/log_contents.h"

namespace credence::internal {

double message_rate(std::int64_t count, double first_s, double last_s) {
  return count > 1 && last_s > first_s ? static_cast<double>(count - 1) / (last_s - first_s) : kNaN;
}

}  // namespace credence::internal
