#include "montecarlo/worlds/estimator_key.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/filters/estimators/estimators.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/estimator_offers.h"

namespace credence::internal {
namespace {

constexpr std::string_view kEstimatorPath = "filter.estimator";

std::vector<std::string_view> all_estimators() {
  std::vector<std::string_view> words;
  for (const EstimatorOffer* offer : {&kPlanarSlamOffer, &kSpatialOffer, &kLinearOffer}) {
    for (const std::string_view name : offer->names(nullptr)) {
      if (std::ranges::find(words, name) == words.end()) words.push_back(name);
    }
  }
  return words;
}

std::string_view estimator_meanings() {
  static const std::string text = [] {
    std::string all;
    for (const EstimatorKind& kind : estimator_kinds())
      all += fmt::format("{}: {}; ", kind.name, kind.meaning);
    return all +
           "in space of these ekf, ideal, fej, invariant, and ekf-se3: pose in SE(3), landmarks by "
           "differences; in a linear world kalman; steady-state: with the gain to which it settles; "
           "smoother: "
           "Rauch-Tung-Striebel; schmidt: filter.considered are not estimated; own-gain: with filter.gain";
  }();
  return text;
}

}  // namespace

KeyRow estimator_key(bool (*in_effect)(const Scenario&)) {
  return {.section = "filter",
          .name = "estimator",
          .unit = "",
          .meaning = estimator_meanings(),
          .field = own_choice(std::string(kEstimatorPath), all_estimators()),
          .in_effect = in_effect};
}

void set_estimator(Scenario& scenario, std::string_view name) {
  const std::vector<std::string_view> words = all_estimators();
  const auto index = std::ranges::find(words, name) - words.begin();
  own_choice(std::string(kEstimatorPath), words).set(scenario, static_cast<std::size_t>(index));
}

void check_estimator(const Scenario& scenario, const Refusal& refuse, const EstimatorOffer& offer) {
  const std::vector<std::string_view> names = offer.names(nullptr);
  if (std::ranges::find(names, word_value(scenario, kEstimatorPath)) != names.end()) return;
  refuse.wrong("filter", "estimator",
               fmt::format("must be one of \"{}\" in this world", fmt::join(names, "\", \"")));
}

}  // namespace credence::internal
