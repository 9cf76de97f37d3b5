#include "analysis/stability/trace_growth.h"

#include <cmath>

#include "core/enum_words.h"

namespace credence {

using namespace internal;

std::string_view to_string(LongRun verdict) { return word_of(verdict, {"bounded", "growing", "failed"}); }

TraceGrowth judge_growth(const std::vector<double>& trace, double resolution) {
  TraceGrowth growth;
  const std::size_t last = trace.size();
  if (last < 4) return growth;
  const auto at = [&trace](std::size_t sample) { return trace[sample - 1]; };
  const std::size_t half = last / 2;
  const double late = at(last) - at(half), early = at(half) - at(last / 4);
  growth.per_sample = late / static_cast<double>(last - half);
  growth.exponent = at(half) > 0.0 ? std::log2(at(last) / at(half)) : 0.0;
  const bool steadily = late > resolution * at(last) && late > 0.75 * early;
  growth.verdict = growth.exponent > 0.5 || steadily ? LongRun::growing : LongRun::bounded;
  return growth;
}

}  // namespace credence
