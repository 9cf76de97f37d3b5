#include "python/tuned_filter.h"

#include <pybind11/stl.h>

#include <utility>

#include "analysis/tuning/black_box_score.h"
#include "analysis/tuning/tuning.h"
#include "core/nan.h"
#include "reports/document/tuning/tuning_tables.h"

namespace py = pybind11;

namespace credence::internal {
namespace {

std::vector<FilterFactor> named(const std::vector<std::pair<std::string, double>>& factors) {
  std::vector<FilterFactor> all;
  for (const auto& [name, start] : factors) all.push_back({name, start});
  return all;
}

/// The score of a filter that Python plays.
class PlayedInPython final : public BlackBoxScore {
 public:
  PlayedInPython(const std::vector<std::pair<std::string, double>>& factors, std::int64_t runs,
                 const py::function& play)
      : BlackBoxScore(named(factors)), runs_(runs), play_(play) {}

  Index units() const override { return runs_; }

 protected:
  UnitScores play(const std::vector<double>& factors) const override {
    const auto played = play_(factors).cast<PlayedScores>();
    UnitScores scores;
    scores.value = taken(std::get<0>(played));
    scores.nis = taken(std::get<1>(played));
    scores.lag_one = taken(std::get<2>(played));
    scores.steps = std::get<3>(played);
    scores.dof = std::get<4>(played);
    scores.composite = std::get<6>(played);
    scores.ok = std::get<5>(played) && scores.value.allFinite() && scores.steps > 0.0;
    return scores;
  }

 private:
  Vector taken(const py::array_t<double>& numbers) const {
    const auto all = numbers.unchecked<1>();
    Vector taken(all.shape(0));
    for (Index i = 0; i < taken.size(); ++i) taken[i] = all(i);
    return taken;
  }

  Index runs_;
  py::function play_;
};

Document filter_document(const Tuning& tuning) {
  Document document;
  document.json = [tuning] {
    Json j = tuning_json(tuning);
    j["notes"] = tuning.notes;
    return text_of_json(j);
  };
  document.show_apart({tune_forecast_table(tuning.forecast),
                       tuned_noise_table("filter", "filter as a black box, common random numbers", tuning),
                       score_gain_table(tuning)});
  document.show(tuning.notes);
  return document;
}

}  // namespace

Told tune_filter(const std::vector<std::pair<std::string, double>>& factors, std::int64_t runs,
                 double confidence, const py::function& play) {
  const PlayedInPython score(factors, runs, play);
  return {.p_value = kNaN,
          .document = filter_document(tune(score, Vector::Zero(score.parameters()), confidence))};
}

}  // namespace credence::internal
