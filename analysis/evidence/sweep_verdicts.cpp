#include "analysis/evidence/sweep_verdicts.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/multiple_tests.h"

namespace credence {
namespace {

double p_value_of(const StudyAnalysis& a) {
  if (a.stop) return a.stop->p_value;
  if (std::isnan(a.nees.p_value)) return a.nis.p_value;
  if (std::isnan(a.nis.p_value)) return a.nees.p_value;
  return std::min(1.0, 2.0 * std::min(a.nees.p_value, a.nis.p_value));
}

}  // namespace

std::vector<double> sweep_p_values(std::span<const StudyAnalysis> analyses) {
  std::vector<double> p_values;
  p_values.reserve(analyses.size());
  for (const StudyAnalysis& a : analyses) p_values.push_back(p_value_of(a));
  return benjamini_yekutieli(p_values);
}

}  // namespace credence
