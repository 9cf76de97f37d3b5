#pragma once

#include <initializer_list>
#include <vector>

#include "datasets/replay/carpark_findings.h"

/// @file
/// Studies of the car park made of traces alone, as its replays gave them.

namespace credence::internal {

inline LongHorizonResult horizon_of_traces(std::initializer_list<double> traces) {
  LongHorizonResult result;
  for (const double trace : traces) result.loops.push_back({0, trace});
  return result;
}

/// Every variant from every P0: the order of the paper's figures, and a map that with one anchor depends on
/// P0.
inline CarparkStudy carpark_study_of_traces() {
  CarparkStudy study;
  study.plan.loops = 10;
  std::vector<InitialDeviations> all = carpark_initials();
  for (const InitialDeviations& initial : independence_initials()) all.push_back(initial);
  for (const CarparkVariant& variant : carpark_variants())
    for (const InitialDeviations& initial : all) study.runs.push_back({variant, initial, {}});
  for (CarparkVariantRun& run : study.runs) {
    const bool five = paper_figure(run.variant) == "Figure 5", six = paper_figure(run.variant) == "Figure 6";
    const bool pairwise = run.variant.solution == InflationSolution::pairwise;
    run.result.covariance.vehicle_max = five ? 100 : six ? 3 : 1;
    run.result.covariance.landmarks_final = five ? 70 : six ? (pairwise ? 9000 : 50) : 20;
    if (run.variant.anchors == 1 && run.initial.heading_std_deg == 15)
      run.result.covariance.landmarks_final *= 2.5;
  }
  return study;
}

/// The same with what the study of the paper's data gave beside it, so that every finding holds.
inline CarparkStudy carpark_study_that_holds() {
  CarparkStudy study = carpark_study_of_traces();
  for (CarparkVariantRun& run : study.runs) {
    run.result.observations = run.result.associated = 888;
    run.result.scans_with_observations = 505;
    run.result.landmark_rms_aligned = 0.05;
    run.result.nis.add(0.14);
    const bool six = paper_figure(run.variant) == "Figure 6";
    if (six && run.variant.solution == InflationSolution::min_trace)
      run.result.covariance.landmarks_final = 60;
  }
  const auto add = [&](Inflation inflation, InflationSolution solution,
                       std::initializer_list<double> traces) {
    LongHorizonResult result = horizon_of_traces(traces);
    result.ok = true;
    study.horizon.push_back({{inflation, solution, 0}, result});
  };
  add(Inflation::none, InflationSolution::pairwise, {5, 4, 4, 4, 4, 4});
  add(Inflation::full, InflationSolution::pairwise, {1, 2, 4, 8, 16, 32});
  add(Inflation::map, InflationSolution::pairwise, {1, 2, 3, 4, 5, 6});
  add(Inflation::map, InflationSolution::min_trace, {4, 4, 4, 4, 4, 4});
  add(Inflation::full, InflationSolution::min_trace, {1, 1.06, 1.12, 1.18, 1.24, 1.30});
  return study;
}

}  // namespace credence::internal
