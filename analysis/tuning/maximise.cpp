#include "analysis/tuning/maximise.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <nlopt.hpp>
#include <stdexcept>

namespace credence::internal {
namespace {

constexpr int kMostEvaluations = 500;
constexpr double kTolerance = 1e-3;        // of the scales
constexpr double kGainOfRestart = 1e-3;    // of the sum of the scores
constexpr double kLongestFirstStep = 1.0;  // in φ
constexpr int kMostRestartsOfSearch = 5;   // from the best point, where some have no scores

/// The search in the free coordinates over their scales, with the best point so far.
class Search {
 public:
  Search(const ScoreFunction& model, const Vector& start, const SearchBox& box, const std::vector<bool>& free,
         const Vector& scale)
      : model_(model), best_{.phi = start}, box_(box), scale_(scale) {
    if ((start.array() < box.lower.array()).any() || (start.array() > box.upper.array()).any()) {
      throw std::invalid_argument("the search begins outside its bounds");
    }
    for (Index i = 0; i < start.size(); ++i) {
      if (!free[static_cast<std::size_t>(i)]) continue;
      free_.push_back(i);
      lower_.push_back(box.lower[i] / scale[i]);
      upper_.push_back(box.upper[i] / scale[i]);
    }
  }

  Maximum run() {
    const UnitScores first = model_.scores(best_.phi, false);
    best_.ok = first.ok;
    if (!first.ok) return best_;
    best_.value = worst_ = first.sum();
    if (free_.empty()) return best_;
    if (model_.has_gradient()) soften();
    double step = 1.0;
    for (int i = 0; i <= kMostRestartsOfSearch; ++i) {
      const double before = best_.value;
      refused_ = 0;
      search_from_best(step);
      // Points without scores bend the model of what is around them.
      if (refused_ == 0 || (i > 0 && best_.value < before + kGainOfRestart)) break;
      step *= 0.5;
    }
    return best_;
  }

 private:
  void search_from_best(double first_step) {
    std::vector<double> x;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      x.push_back(std::clamp(best_.phi[free_[i]] / scale_[free_[i]], lower_[i], upper_[i]));
    }
    nlopt::opt search(model_.has_gradient() ? nlopt::LD_SLSQP : nlopt::LN_BOBYQA,
                      static_cast<unsigned>(free_.size()));
    search.set_max_objective(&Search::objective, this);
    search.set_lower_bounds(lower_);
    search.set_upper_bounds(upper_);
    search.set_xtol_abs(kTolerance);
    search.set_maxeval(kMostEvaluations);
    if (!model_.has_gradient()) search.set_initial_step(first_step);
    double value = 0.0;
    try {
      search.optimize(x, value);
    } catch (const std::runtime_error&) {
      // A line search that rounding ends, where the best point is kept all the same, or what the model threw.
    }
    if (thrown_) std::rethrow_exception(thrown_);
  }

  /// The first step is as long as the gradient: from far away it would jump over everything.
  void soften() {
    const Vector gradient = model_.scores(best_.phi, true).gradient.rowwise().sum();
    double longest = 0.0;
    for (const Index i : free_) longest = std::max(longest, std::abs(gradient[i]) * scale_[i] * scale_[i]);
    if (longest > kLongestFirstStep) softening_ = kLongestFirstStep / longest;
  }

  /// NLopt would make its own of an exception of the model.
  static double objective(const std::vector<double>& x, std::vector<double>& gradient, void* search) {
    auto& self = *static_cast<Search*>(search);
    try {
      return self.evaluate(x, gradient);
    } catch (...) {
      self.thrown_ = std::current_exception();
      throw nlopt::forced_stop();
    }
  }

  double evaluate(const std::vector<double>& x, std::vector<double>& gradient) {
    Vector phi = best_.phi;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const Index c = free_[i];
      phi[c] = std::clamp(x[i] * scale_[c], box_.lower[c], box_.upper[c]);  // rounding may leave the box
    }
    const UnitScores scores = model_.scores(phi, !gradient.empty());
    if (!scores.ok) {
      for (double& g : gradient) g = 0.0;
      ++refused_;
      return (worst_ - 1.0) * softening_;
    }
    for (std::size_t i = 0; i < gradient.size(); ++i) {
      gradient[i] = scores.gradient.row(free_[i]).sum() * scale_[free_[i]] * softening_;
    }
    const double value = scores.sum();
    worst_ = std::min(worst_, value);
    if (value > best_.value) {
      best_.value = value;
      best_.phi = phi;
    }
    return value * softening_;
  }

  const ScoreFunction& model_;
  Maximum best_;
  const SearchBox& box_;
  const Vector& scale_;
  std::vector<Index> free_;
  std::vector<double> lower_, upper_;
  double softening_ = 1.0;  ///< of the objective
  double worst_ = 0.0;      ///< score so far
  int refused_ = 0;         ///< points of this search without scores
  std::exception_ptr thrown_{};
};

}  // namespace

Maximum maximise(const ScoreFunction& model, const Vector& start, const SearchBox& box,
                 const std::vector<bool>& free, const Vector& scale) {
  return Search(model, start, box, free, scale).run();
}

}  // namespace credence::internal
