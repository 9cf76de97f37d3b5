#include "analysis/studies/selftest_tests.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/evidence/sequential_e_value.h"
#include "analysis/laws/betting_e_value.h"
#include "core/nan.h"

namespace credence {
namespace {

double betting_e_value_p(const RunAverages& runs) {
  if (runs.first.empty()) return kNaN;
  const BettingPrices prices = betting_prices(static_cast<double>(runs.least_dof));
  RunBetting betting;
  for (const double average : runs.first) betting.add(average, prices);
  return std::exp(-betting.log_e_value());
}

double smallest_adjusted(const std::vector<SigmaBin>& bins) {
  double smallest = kNaN;
  for (const SigmaBin& bin : bins) smallest = std::fmin(smallest, bin.adjusted);
  return smallest;
}

}  // namespace

std::vector<TestResult> shipped_tests(const Evidence& e, const Judgement& j, const Calibration& c) {
  constexpr Exactness kConservative = Exactness::conservative;
  std::vector<TestResult> results;
  double smallest = 1.0;
  for (const NamedTest& test : j.tests) {
    results.push_back({test.name, test.exactness, test.p_value});
    if (!std::isnan(test.adjusted)) smallest = std::min(smallest, test.adjusted);
  }
  results.push_back({"errors by claimed σ, Holm", kConservative, smallest_adjusted(c.bins)});
  results.push_back({"NEES of runs left out, scaled", Exactness::approximate, c.with_factor.p_value});
  results.push_back(
      {"NEES of runs left out, scaled by part", Exactness::approximate, c.with_part_factors.p_value});
  const StudyStatistics& s = e.study;
  const double e_nees = log_e_nees(s.series(Quantity::nees), s.dofs(Quantity::nees));
  const double e_nis = log_e_nis(s.series(Quantity::nis), s.dofs(Quantity::nis));
  results.push_back({"e-value of NEES, steps", kConservative, std::exp(-e_nees)});
  results.push_back({"e-value of NEES, betting over runs", kConservative, betting_e_value_p(s.nees_of_runs)});
  results.push_back({"e-value of NIS", kConservative, std::exp(-e_nis)});
  results.push_back({"all tests together, Holm", kConservative, smallest});
  results.push_back({"the word", kConservative, j.word.p_value});
  return results;
}

}  // namespace credence
