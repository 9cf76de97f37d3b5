#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/evidence/study_analysis.h"
#include "analysis/laws/sample_size.h"
#include "analysis/tuning/black_box_score.h"
#include "analysis/tuning/noise_parameters.h"
#include "analysis/tuning/scenario_noise.h"
#include "analysis/tuning/score_shape.h"
#include "analysis/tuning/tuning.h"
#include "montecarlo/engine/engine.h"

namespace credence::internal {

/// What is asked.
struct TuneRequest {
  std::vector<FreeNoise> free = {{NoiseMatrix::Q, NoiseForm::factor}, {NoiseMatrix::R, NoiseForm::factor}};
  int threads = 0;
  const std::atomic<bool>* stop = nullptr;
  PlayCount::Watch watch{};                              ///< of the search
  std::function<void(const StudyProgress&)> progress{};  ///< of the two studies with fresh noise together
};

/// The same study with fresh noise, of the present and of the tuned filter.
struct HeldOut {
  StudyAnalysis before, after;
  DetectableFactors detectable{};  ///< factors on S that these runs find with 80 % power, either way
};

/// A scenario, tuned.
struct ScenarioTuning {
  Scenario scenario{}, tuned{};            ///< equal where nothing could be told
  std::unique_ptr<ScenarioScore> score{};  ///< of the runs tuned on
  Tuning tuning{};                         ///< parameters named by their keys, in the unit of these
  std::vector<RidgePoint> ridge{};         ///< of process against measurement noise, where both are free
  std::optional<std::pair<Index, Index>> ridge_of{};  ///< coordinates of it
  std::optional<HeldOut> held_out{};                  ///< none where nothing could be told
};

/// Tunes the noise that the filter of a scenario believes in by the runs of the study, and judges the result
/// by as many runs with other noise: those of the next seed.
///
/// Throws std::invalid_argument as make_scenario_score and tune do; nothing where request.stop was set.
std::optional<ScenarioTuning> tune_scenario(const Scenario& scenario, const TuneRequest& request);

}  // namespace credence::internal
