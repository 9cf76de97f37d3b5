#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/filters/chart_ekf.h"
#include "montecarlo/worlds/plugged/scenario_plug.h"

/// @file
/// Worlds whose state lies in a Lie group, and their extended Kalman filter in any chart: a world states its
/// model, and has both.

namespace credence::internal {

/// What is measured of the outside at one step.
struct Aiding {
  Vector z{};
  std::vector<Index> landmarks{};  ///< those in z, in this order; empty where z is of none
};

/// f(x̂) with its Jacobian F and the covariance Q of its noise, by right perturbations.
template <LieGroup G>
struct ChartedMotion {
  G moved;
  typename G::Jacobian F, Q;
};

/// ν = z − h(x̂) with the Jacobian H by right perturbations, and R.
template <LieGroup G>
struct ChartedInnovation {
  Vector nu;
  typename ChartEkf<G>::Rows H;
  Matrix R;
};

/// In which charts a filter lives and is judged.
struct ChartSettings {
  Chart filter = Chart::componentwise;
  Chart judged = Chart::componentwise;
  CovarianceReset reset = CovarianceReset::none;
};

/// A model: where the filter starts, the truth's way and what is read of it (the noise handed in), and what
/// the filter believes. All const and safe to call from several threads.
template <class Model>
concept ChartedModel = LieGroup<typename Model::Group> &&
    requires(const Model& model, const typename Model::Group& x, const typename Model::Input& u,
             const Aiding& seen, std::int64_t k, NoiseDraw& noise) {
  { model.start() } -> std::convertible_to<typename Model::Group>;
  { model.initial_std() } -> std::convertible_to<typename Model::Group::Tangent>;  ///< componentwise
  { model.step(x, k, noise) } -> std::same_as<typename Model::Group>;
  { model.input(x, k, noise) } -> std::same_as<typename Model::Input>;
  { model.measure(x, k, noise) } -> std::same_as<std::optional<Aiding>>;
  { model.motion(x, u) } -> std::same_as<ChartedMotion<typename Model::Group>>;
  { model.innovation(x, seen) } -> std::same_as<ChartedInnovation<typename Model::Group>>;
  { model.layout() } -> std::convertible_to<RunLayout>;
};

/// The world of a model; errors are stated in the chart in which the filter is judged.
template <ChartedModel Model>
class ChartedWorld {
 public:
  using Group = typename Model::Group;

  ChartedWorld(std::shared_ptr<const Model> model, Chart judged)
      : model_(std::move(model)), judged_(judged) {}

  /// The covariance is componentwise.
  Prior<Group> prior() const {
    return {model_->start(), Matrix(model_->initial_std().cwiseAbs2().asDiagonal())};
  }
  Group initial(NoiseDraw& noise) const {
    typename Group::Tangent error = noise.normals(Group::kDim);
    error = error.cwiseProduct(model_->initial_std()).eval();
    return credence::plus(model_->start(), error, Chart::componentwise);
  }
  Group step(const Group& x, std::int64_t k, NoiseDraw& noise) const { return model_->step(x, k, noise); }
  auto input(const Group& x, std::int64_t k, NoiseDraw& noise) const { return model_->input(x, k, noise); }
  auto measure(const Group& x, std::int64_t k, NoiseDraw& noise) const {
    return model_->measure(x, k, noise);
  }
  Vector minus(const Group& a, const Group& b) const { return credence::minus(a, b, judged_); }
  Group plus(const Group& x, const Vector& d) const {
    return credence::plus(x, typename Group::Tangent(d), judged_);
  }
  Vector coordinates(const Group& x) const { return x.split().Log(); }
  RunLayout layout() const {
    RunLayout layout = model_->layout();
    layout.componentwise = judged_ == Chart::componentwise || judged_ == Chart::componentwise_left;
    return layout;
  }

 private:
  std::shared_ptr<const Model> model_;
  Chart judged_;
};

/// The extended Kalman filter of a model.
template <ChartedModel Model>
class ChartedFilter {
 public:
  using Group = typename Model::Group;

  ChartedFilter(std::shared_ptr<const Model> model, const ChartSettings& charts)
      : model_(std::move(model)), judged_(charts.judged), ekf_(charts.filter, charts.reset) {}

  void reset(const Group& mean, const Matrix& P) { ekf_.reset(mean, P, Chart::componentwise); }
  void predict(const typename Model::Input& u) {
    const auto motion = model_->motion(ekf_.state(), u);
    ekf_.predict(motion.moved, motion.F, motion.Q);
  }
  bool update(const Aiding& seen) {
    const auto innovation = model_->innovation(ekf_.state(), seen);
    return ekf_.update(innovation.nu, innovation.H, innovation.R);
  }
  const Group& state() const { return ekf_.state(); }
  Matrix covariance() const { return ekf_.covariance(judged_); }
  const Vector& innovation() const { return ekf_.innovation(); }
  const Matrix& innovation_covariance() const { return ekf_.innovation_covariance(); }

 private:
  std::shared_ptr<const Model> model_;
  Chart judged_;
  ChartEkf<Group> ekf_;
};

}  // namespace credence::internal
