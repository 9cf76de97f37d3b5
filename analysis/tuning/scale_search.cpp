#include "analysis/tuning/scale_search.h"

#include <cmath>
#include <vector>

#include "analysis/tuning/maximise.h"

namespace credence::internal {
namespace {

/// A factor on each covariance that is free, as its logarithm.
class ScoreOfScales final : public ScoreFunction {
 public:
  ScoreOfScales(const ScoreModel& model, const Vector& start) : model_(model), start_(start) {}

  bool has_gradient() const override { return model_.has_gradient(); }
  UnitScores scores(const Vector& t, bool gradient) const override {
    const Vector phi = model_.scaled(start_, t);
    UnitScores scores = model_.scores(phi, gradient);
    if (gradient && scores.ok) scores.gradient = model_.scale_directions(phi).transpose() * scores.gradient;
    return scores;
  }

 private:
  const ScoreModel& model_;
  const Vector& start_;
};

}  // namespace

Vector best_scales(const ScoreModel& model, const Vector& start, double reach) {
  const Index covariances = model.scale_directions(start).cols();
  if (covariances == 0 || covariances == model.parameters()) return start;
  const Vector end = Vector::Constant(covariances, std::log(reach));
  const std::vector<bool> all(static_cast<std::size_t>(covariances), true);
  const Maximum best = maximise(ScoreOfScales(model, start), Vector::Zero(covariances), {-end, end}, all,
                                Vector::Ones(covariances));
  return best.ok ? model.scaled(start, best.phi) : start;
}

}  // namespace credence::internal
