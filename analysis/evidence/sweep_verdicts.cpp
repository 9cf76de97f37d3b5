#include "analysis/evidence/sweep_verdicts.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/multiple_tests.h"

namespace credence::internal {
std::vector<double> sweep_p_values(std::span<const StudyAnalysis> analyses) {
  std::vector<double> p_values;
  p_values.reserve(analyses.size());
  for (const StudyAnalysis& a : analyses) p_values.push_back(a.stop ? a.stop->p_value : a.word.p_value);
  return benjamini_yekutieli(p_values);
}

}  // namespace credence::internal
