#include "analysis/evidence/sums/step_normaliser.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "analysis/laws/correlation/lateness.h"
#include "core/linear_algebra/logarithm.h"
#include "core/record/certain_states.h"
#include "core/record/normalised_error.h"
#include "core/record/piece_covariances.h"
#include "core/record/take_block.h"

namespace credence::internal {
void StepPlaces::find(const std::vector<Index>& step_states, const RunLayout& layout) {
  if (step_states == states && of_block.size() == layout.blocks.size()) return;
  states = step_states;
  lead = lead_block(layout);
  position = position_block(layout);
  of_block.resize(layout.blocks.size());
  std::vector<Index> place(layout.states.size(), -1);
  angles.clear();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto state = static_cast<std::size_t>(states[i]);
    place[state] = static_cast<Index>(i);
    if (layout.angles[state]) angles.push_back(static_cast<Index>(i));
  }
  for (std::size_t b = 0; b < of_block.size(); ++b) {
    of_block[b].clear();
    for (const Index state : layout.blocks[b].states) {
      if (const Index at = place[static_cast<std::size_t>(state)]; at >= 0) of_block[b].push_back(at);
    }
  }
}

Index position_block(const RunLayout& layout) {
  const auto found = std::ranges::find(layout.blocks, Part::position, &Block::part);
  return found == layout.blocks.end() || !layout.has_truth ? -1 : found - layout.blocks.begin();
}

Index lead_block(const RunLayout& layout) {
  constexpr std::ptrdiff_t kLargest = 24;
  const auto rank = [](const Block& block) {
    const std::ptrdiff_t size = std::ssize(block.states);
    const int part = block.part == Part::pose ? 0 : block.part == Part::position ? 1 : 2;
    return std::tuple(part, size > kLargest ? 1 : -size, std::string_view(block.name));
  };
  const auto found = std::ranges::min_element(layout.blocks, {}, rank);
  return found == layout.blocks.end() ? -1 : found - layout.blocks.begin();
}

namespace {

bool is_planar_pose(const Block& block) { return block.part == Part::pose && block.states.size() == 3; }
bool is_planar_landmark(const Block& block) {
  return block.part == Part::landmark && block.states.size() == 2;
}

}  // namespace

bool has_planar_map(const RunLayout& layout) {
  return layout.has_truth && std::ranges::any_of(layout.blocks, is_planar_pose) &&
         std::ranges::any_of(layout.blocks, is_planar_landmark);
}

void StepNormaliser::take_moving(const Step& step, const RunLayout& layout, const StepPlaces& at,
                                 NormalisedStep& normalised) {
  MovingPart& moving = normalised.moving;
  moving.places.clear();
  if (step.states.empty() || !layout.componentwise || step.estimate.size() != step.error.size()) {
    normalised.estimate.resize(0);
    return;
  }
  normalised.estimate = step.estimate;
  const Index position = at.position;
  if (has_planar_map(layout)) {
    const std::vector<Index>* pose = nullptr;
    std::vector<const std::vector<Index>*> landmarks;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
      if (is_planar_pose(layout.blocks[b])) pose = &at.of_block[b];
      if (is_planar_landmark(layout.blocks[b])) landmarks.push_back(&at.of_block[b]);
    }
    const auto landmark = [&](Index i) -> const std::vector<Index>& {
      return *landmarks[static_cast<std::size_t>(i)];
    };
    const Index chosen =
        landmark_in_turn(step.step, std::ssize(landmarks), [&](Index i) { return landmark(i).size() == 2; });
    if (pose->size() != 3 || chosen < 0) return;
    moving.places = *pose;
    moving.places.insert(moving.places.end(), landmark(chosen).begin(), landmark(chosen).end());
  } else if (position >= 0) {
    moving.places = at.of_block[static_cast<std::size_t>(position)];
    if (moving.places.size() != layout.blocks[static_cast<std::size_t>(position)].states.size())
      moving.places.clear();
  } else if (layout.joint_covariance && step.states.size() == layout.states.size()) {
    for (Index i = 0; i < step.error.size(); ++i) {
      if (!std::isnan(step.estimate[i])) moving.places.push_back(i);
    }
    if (std::ssize(moving.places) > RunLateness::kLargest) moving.places.clear();
  }
  const auto is_error_alone = [&](Index at) { return std::isnan(step.estimate[at]); };
  if (std::ranges::any_of(moving.places, is_error_alone)) moving.places.clear();
  take_block(step.error, step.P, moving.places, moving.error, moving.P);
}

void StepNormaliser::Solved::clear() {
  of.value = 0.0;
  of.dof = -1;
  factorised = false;
  problem = {};
}

bool StepNormaliser::Solved::factor_few(const VectorRef& e, const MatrixRef& covariance) {
  const Index n = covariance.rows();
  for (Index i = 0; i < n; ++i) {
    if (!(covariance(i, i) > 0.0)) return false;
  }
  if (!factor.compute(covariance)) return false;
  const double least = NeesSolver::least_pivot(n);
  for (Index i = 0; i < n; ++i) {
    const double pivot = factor.pivot(i);
    if (!(pivot * pivot > least * covariance(i, i))) return false;
  }
  of.whitened = e;
  factor.solve_lower(of.whitened);
  const double value = of.whitened.squaredNorm();
  if (!std::isfinite(value)) return false;
  of.value = value;
  of.dof = n;
  return true;
}

bool StepNormaliser::Solved::factor_by_solver(const VectorRef& e, const MatrixRef& covariance) {
  if (!(covariance.diagonal().array() > 0.0).all()) return false;
  const NeesValue nees = solver.solve(e, covariance);
  if (nees.dof < 0 || !std::isfinite(nees.value) || !solver.well_conditioned(covariance)) return false;
  of.value = nees.value;
  of.whitened = solver.whitened();
  of.dof = nees.dof;
  return true;
}

void StepNormaliser::Solved::normalise(const VectorRef& e, const MatrixRef& covariance) {
  clear();
  wide = covariance.rows() > SmallCholesky::kMost;
  // The common case, with the arithmetic of the engine.
  factorised = wide ? factor_by_solver(e, covariance) : factor_few(e, covariance);
  if (!factorised) normalise_by_rank(e, covariance);
}

void StepNormaliser::Solved::normalise_innovation(const VectorRef& nu, const MatrixRef& S) {
  clear();
  factorised = factor_by_solver(nu, S);
  if (!factorised) normalise_by_rank(nu, S);
}

double StepNormaliser::Solved::log_determinant() const {
  return wide ? solver.log_determinant() : log_determinant_of_factor(factor.lower());
}

void StepNormaliser::Solved::normalise_by_rank(const VectorRef& e, const MatrixRef& covariance) {
  const NormalisedError general = normalised_error(e, covariance);
  if (!general.ok) {
    problem = general.reason;
  } else if (!std::isfinite(general.value)) {
    const bool is_finite = std::isfinite(general.whitened.squaredNorm());
    problem = is_finite ? kClaimedCertainty : "an error too large to be squared";
  } else {
    of.value = general.value;
    of.whitened = general.whitened;
    of.dof = general.dof;
  }
}

void StepNormaliser::Solved::normalise(double e, double variance) {
  const double u = e / std::sqrt(variance), squared = u * u;
  if (!(variance > 0.0) || !std::isfinite(squared)) {
    normalise(Vector::Constant(1, e), Matrix::Constant(1, 1, variance));
    return;
  }
  clear();
  of.value = squared;
  of.whitened.resize(1);
  of.whitened[0] = u;
  of.dof = 1;
}

namespace {

constexpr double kLargestError = 1e140;  // standard deviations, whose square is finite in any direction of P

/// Whether the square of an error over its variance may not be a number; not of NIS alone, which has no S.
bool is_beyond_squares(const VectorRef& errors, const MatrixRef& covariance, Index i) {
  if (i >= covariance.rows() || !std::isfinite(errors[i])) return false;
  const double scaled = errors[i] * (1.0 / kLargestError), variance = covariance(i, i);
  return variance > 0.0 && scaled * scaled > variance;
}

bool is_beyond_squares(const VectorRef& errors, const MatrixRef& covariance) {
  for (Index i = 0; i < errors.size(); ++i)
    if (is_beyond_squares(errors, covariance, i)) return true;
  return false;
}

/// Brings such ones to that size: they are evidence, as any error of so many standard deviations.
void keep_squarable(Vector& errors, const MatrixRef& covariance) {
  for (Index i = 0; i < errors.size(); ++i) {
    if (is_beyond_squares(errors, covariance, i))
      errors[i] = std::copysign(kLargestError * std::sqrt(covariance(i, i)), errors[i]);
  }
}

bool is_beyond_squares(const Step& step) {
  return is_beyond_squares(step.error, step.P) ||
         std::ranges::any_of(step.innovations, [](const auto& of) { return is_beyond_squares(of.nu, of.S); });
}

}  // namespace

std::string_view StepNormaliser::normalise(const Step& step, const RunLayout& layout,
                                           const StepPlaces& places, NormalisedStep& normalised) {
  state_.clear();
  normalised.wrongly_certain.clear();
  if (!step.problem.empty()) return step.problem;
  find_certain_states(step.estimate, step.error, step.P, certain_);
  find_wrongly_certain_states(step.error, step.P, wrong_);
  const bool beyond = is_beyond_squares(step);
  if (certain_.empty() && wrong_.empty() && !beyond) return normalise_known(step, layout, places, normalised);
  Step known = step;
  if (beyond) {
    keep_squarable(known.error, known.P);
    for (auto& innovation : known.innovations) keep_squarable(innovation.nu, innovation.S);
  }
  make_certain(certain_, known.error, known.P);
  make_certain(wrong_, known.error, known.P);
  const std::string_view problem = normalise_known(known, layout, places, normalised);
  for (const Index i : wrong_) {
    normalised.error[i] = step.error[i];
    normalised.wrongly_certain.push_back(step.states[static_cast<std::size_t>(i)]);
  }
  return problem;
}

std::string_view StepNormaliser::normalise_known(const Step& step, const RunLayout& layout,
                                                 const StepPlaces& places, NormalisedStep& normalised) {
  normalised.step = step.step;
  normalised.line = step.line;
  normalised.states = step.states;
  normalised.error = step.error;
  normalised.variance = step.P.diagonal();
  take_moving(step, layout, places, normalised);
  const std::string_view problem = normalise_state(step, layout, places, normalised);
  return problem.empty() ? normalise_innovations(step, layout, normalised) : problem;
}

std::string_view StepNormaliser::normalise_state(const Step& step, const RunLayout& layout,
                                                 const StepPlaces& at, NormalisedStep& normalised) {
  NormalisedSquare& whole = normalised.whole;
  whole = {};
  if (!layout.joint_covariance || step.P.rows() > kLargestTold) normalised.P.resize(0, 0);
  normalised.log_determinant = kNaN;
  blocks_.resize(layout.blocks.size());
  normalised.blocks.resize(layout.blocks.size());
  for (NormalisedSquare& block : normalised.blocks) block = {};
  if (step.states.empty()) return {};
  if (layout.joint_covariance) {
    state_.normalise(step.error, step.P);
    if (!state_.problem.empty()) return state_.problem;
    whole = state_.of;
    if (step.P.rows() <= kLargestTold) normalised.P = step.P;
    if (state_.factorised) normalised.log_determinant = state_.log_determinant();
  } else {
    whole.dof = 0;
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::vector<Index>& places = at.of_block[b];
    Solved& block = blocks_[b];
    block.clear();
    const bool all = std::ssize(places) == step.error.size() && layout.joint_covariance;
    const bool single = places.size() == 1;
    const bool leads = static_cast<Index>(b) == at.lead, position = static_cast<Index>(b) == at.position;
    BlockError& own = leads ? normalised.lead : position ? normalised.position : block.block;
    if (leads || position || !(all || single)) take_block(step.error, step.P, places, own.error, own.P);
    if (leads && position) normalised.position = normalised.lead;
    if (places.empty()) continue;
    if (all) {
      normalised.blocks[b] = state_.of;
      continue;
    }
    if (single) {
      block.normalise(step.error[places[0]], step.P(places[0], places[0]));
    } else {
      block.normalise(own.error, own.P);
    }
    if (!block.problem.empty()) return block.problem;
    normalised.blocks[b] = block.of;
    if (layout.joint_covariance) continue;
    whole.value += block.of.value;
    whole.dof += block.of.dof;
  }
  return {};
}

std::string_view StepNormaliser::normalise_innovations(const Step& step, const RunLayout& layout,
                                                       NormalisedStep& normalised) {
  innovations_.resize(step.innovations.size());
  normalised.innovations.resize(step.innovations.size());
  for (std::size_t i = 0; i < step.innovations.size(); ++i) {
    const Innovation& innovation = step.innovations[i];
    NormalisedInnovation& value = normalised.innovations[i];
    value.dof = -1;
    value.noise_share = kNaN;
    if (innovation.nu.size() == 0) continue;
    if (layout.sensors[i].nis_alone) {
      constexpr double kMost = 1e300;  // of which many can be added
      if (!(innovation.nu[0] >= 0.0 && innovation.nu[0] <= kMost)) return "a NIS that cannot be added up";
      value = {};  // the slot may have been that of a sensor with ν and S
      value.value = innovation.nu[0];
      value.dof = layout.sensors[i].dim;
      continue;
    }
    Solved& solved = innovations_[i];
    solved.normalise_innovation(innovation.nu, innovation.S);
    if (!solved.problem.empty()) return "S of an innovation is not positive semidefinite";
    static_cast<NormalisedVector&>(value) = solved.of;
    value.nu = innovation.nu;
    value.variance = innovation.S.diagonal();
    take_piece_covariances(innovation.S, layout.sensors[i].piece, value.covariance);
    value.complete = innovation.complete;
    if (!solved.factorised) continue;
    const std::vector<double>& variances = layout.sensors[i].variances;
    if (innovation.R.size() > 0) {
      value.noise_share = solved.solver.noise_share(innovation.S, innovation.R);
    } else if (!variances.empty()) {
      value.noise_share = solved.solver.noise_share(variances);
    }
  }
  return {};
}

}  // namespace credence::internal
