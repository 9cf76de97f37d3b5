#include "datasets/logs/conventions/angle_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "analysis/evidence/sums/evidence.h"
#include "core/manifold/angle.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "datasets/logs/conventions/reading_fit.h"

namespace credence::internal {
namespace {

constexpr double kDegreesOfTurn = 360.0, kRadiansOfTurn = 2.0 * std::numbers::pi;
// A value with its rounding.
constexpr double kSlack = 1.0 + 1e-3;
// Of a turn, from either end of it to a value near that end.
constexpr double kNearEnd = 1.0 / 6.0;
// By which the mean of e²/P is too large where the error alone is in degrees.
constexpr double kSquareOfDegrees = 1.0 / (kRadiansPerDegree * kRadiansPerDegree);

/// Whether a step from a to b is a wrap of an angle with such a turn, counted from 0 or from −half a turn.
bool wraps(double a, double b, double turn) {
  const double low = std::min(a, b), high = std::max(a, b), near = kNearEnd * turn;
  if (!(high - low >= turn - near)) return false;  // also where one is NaN
  const bool about_zero = low >= -0.5 * turn * kSlack && high <= 0.5 * turn * kSlack;
  const bool from_zero = low >= 0.0 && high <= turn * kSlack;
  return about_zero || from_zero;
}

/// Whether values of a state stay within a turn, from 0 or from −half a turn.
bool within_turn(double least, double most, double turn) {
  return (least >= -0.5 * turn * kSlack && most <= 0.5 * turn * kSlack) ||
         (least >= 0.0 && most <= turn * kSlack);
}

/// Whether its unit or its name says that a state is no angle: "m", "position.x", "velocity_north".
bool is_said_to_be_none(const RunLayout& layout, std::size_t state) {
  if (state < layout.units.size() && !layout.units[state].empty()) {
    static constexpr std::string_view kOfAngles[] = {"rad", "deg", "°"};
    if (std::ranges::find(kOfAngles, layout.units[state]) == std::end(kOfAngles)) return true;
  }
  static constexpr std::string_view kNone[] = {"position", "pos",          "velocity", "vel",
                                               "speed",    "acceleration", "landmark", "range",
                                               "height",   "depth",        "altitude"};
  std::string word;
  for (const char c : layout.states[state] + '.') {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      continue;
    }
    if (std::ranges::find(kNone, word) != std::end(kNone)) return true;
    word.clear();
  }
  return false;
}

}  // namespace

void AngleUnits::State::add_estimate(double value) {
  if (std::abs(value - last) >= kRadiansOfTurn - kNearEnd * kRadiansOfTurn) {
    wraps_of_degrees += wraps(last, value, kDegreesOfTurn) ? 1 : 0;
    wraps_of_radians += wraps(last, value, kRadiansOfTurn) ? 1 : 0;
  }
  least = estimates == 0 ? value : std::min(least, value);
  most = estimates == 0 ? value : std::max(most, value);
  last = value;
  ++estimates;
}

void AngleUnits::begin_run(const RunLayout& layout) {
  layout_ = layout;
  states_.resize(layout.states.size());
  for (State& state : states_) state.last = kNaN;
  ForwardingSink::begin_run(layout);
}

void AngleUnits::add(const Step& step) {
  ForwardingSink::add(step);
  if (!step.problem.empty()) return;
  for (std::size_t i = 0; i < step.states.size(); ++i) {
    const auto at = static_cast<Index>(i);
    State& state = states_[static_cast<std::size_t>(step.states[i])];
    if (step.estimate.size() > at) state.add_estimate(step.estimate[at]);
    const double error = step.error[at], variance = step.P(at, at);
    state.least_error = std::min(state.least_error, error);
    state.most_error = std::max(state.most_error, error);
    if (!(variance > 0.0)) continue;
    if (layout_.angles[static_cast<std::size_t>(step.states[i])]) {
      state.square += error * error;
      state.cosine += std::cos(error);
      state.sine += std::sin(error);
    }
    const double square = error * error / variance;
    state.normalised += square;
    state.sigma += std::sqrt(variance);
    state.largest = std::max(state.largest, square);
    ++state.count;
  }
}

std::string AngleUnits::wrap_text(std::size_t i) const {
  const State& state = states_[i];
  const std::string& name = layout_.states[i];
  const bool degrees = state.wraps_of_degrees > 0 && within_turn(state.least, state.most, kDegreesOfTurn);
  if (layout_.angles[i]) {
    if (!degrees) return {};
    return fmt::format(
        "Estimates of {}, an angle, wrap at {:g} like degrees, where radians are expected: write estimate "
        "and truth times π/180 and, unless they are in radians already, its rows and columns of P too.",
        name, state.least < -kRadiansOfTurn ? 0.5 * kDegreesOfTurn : kDegreesOfTurn);
  }
  const bool radians = state.wraps_of_radians > 0 && within_turn(state.least, state.most, kRadiansOfTurn);
  if (!degrees && !radians) return {};
  // Where estimate and truth lie on both sides of the wrap.
  const double turn = degrees ? kDegreesOfTurn : kRadiansOfTurn;
  constexpr double kMostOfTurn = 5.0 / 6.0;
  if (std::max(-state.least_error, state.most_error) < kMostOfTurn * turn) return {};
  return fmt::format(
      "{} jumps by {} like an angle{}, and its errors with it: an angle is marked as one, so that its error "
      "is wrapped (in a CSV {}:angle){}.",
      name, degrees ? "360" : "2π", degrees ? " in degrees" : "", name,
      degrees ? ", and written in radians" : "");
}

// Where estimate, truth and P are all in degrees, e²/P is right, but for what is lost when an error is
// wrapped.
std::string AngleUnits::all_in_degrees_text(std::size_t i) const {
  const State& state = states_[i];
  if (!layout_.angles[i] || state.count < static_cast<std::int64_t>(kFewestForReading)) return {};
  const double sigma = state.sigma / static_cast<double>(state.count);
  if (!(sigma > kWideAngle)) return {};
  if (state.estimates == 0 && in_degrees(i) == InDegrees::nothing) {
    return fmt::format(
        "{} is perhaps in degrees, error and P, where radians are expected: its σ is {} on average, which "
        "leaves an angle unknown.",
        layout_.states[i], number_text(sigma, 3));
  }
  if (state.estimates == 0 || !(std::max(-state.least, state.most) > kRadiansOfTurn)) return {};
  return fmt::format(
      "{} is perhaps in degrees, estimate, truth and P, where radians are expected: its estimates go to "
      "{}, beyond a turn, and its σ is {} on average, which leaves an angle unknown.",
      layout_.states[i], number_text(-state.least > state.most ? state.least : state.most, 3),
      number_text(sigma, 3));
}

AngleUnits::InDegrees AngleUnits::in_degrees(std::size_t i) const {
  constexpr double kFactor = 4.0, kFactorOfOthers = 2.0, kTwoTurns = 2.0 * kRadiansOfTurn;
  const State& state = states_[i];
  if (state.count < static_cast<std::int64_t>(kFewestForReading)) return InDegrees::nothing;
  if (!layout_.angles[i] && is_said_to_be_none(layout_, i)) return InDegrees::nothing;
  const double fit = state.mean_square(), factor = layout_.angles[i] ? kFactor : kFactorOfOthers;
  // Not where a few errors make the mean: the square of a Gaussian error is beyond 50 once in 1e12.
  constexpr double kFar = 50.0;
  if (!layout_.angles[i] && state.largest > kFar * fit) return InDegrees::nothing;
  if (fit * kSquareOfDegrees > 1.0 / factor && fit * kSquareOfDegrees < factor) return InDegrees::P;
  // Of errors that were wrapped as if they were radians the largest are lost.
  const bool large =
      layout_.angles[i] && state.estimates > 0 && std::max(-state.least, state.most) > kTwoTurns;
  constexpr double kSomeLost = 30.0;
  const bool error = fit > kSquareOfDegrees / (large ? kSomeLost : factor) && fit < factor * kSquareOfDegrees;
  return error ? InDegrees::error : InDegrees::nothing;
}

// Degrees that are wrapped as radians, from some 2 of them on.
std::string AngleUnits::fills_circle_text(std::size_t i) const {
  constexpr std::int64_t kFewest = 100;
  constexpr double kNarrow = 0.5, kNear = 0.2;  // [rad]; of what is uniform over the circle
  constexpr double kUniform = std::numbers::pi * std::numbers::pi / 3.0;
  const State& state = states_[i];
  if (!layout_.angles[i] || state.count < kFewest) return {};
  const auto count = static_cast<double>(state.count);
  const bool uniform = std::abs(state.square / count - kUniform) < kNear * kUniform &&
                       std::abs(state.cosine) < kNear * count && std::abs(state.sine) < kNear * count;
  if (!uniform || !(state.sigma < kNarrow * count)) return {};
  return fmt::format(
      "Errors of {} fill the whole circle, although its σ is {} rad on average: perhaps they are in degrees, "
      "or the angle is lost.",
      layout_.states[i], number_text(state.sigma / count, 3));
}

std::string AngleUnits::likely_text() const {
  constexpr double kFactor = 4.0;
  std::vector<std::string> of_P, of_error;
  double normalised = 0.0, count = 0.0;
  bool others = false;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const State& state = states_[i];
    if (state.count == 0) continue;
    const InDegrees found = in_degrees(i);
    if (found == InDegrees::nothing) {
      if (layout_.angles[i]) continue;
      const double fit = state.mean_square();
      if (!(fit > 1.0 / kFactor && fit < kFactor)) return {};
      others = true;
      continue;
    }
    (found == InDegrees::P ? of_P : of_error).push_back(layout_.states[i]);
    normalised += state.normalised;
    count += static_cast<double>(state.count);
  }
  if (!others || of_P.empty() == of_error.empty()) return {};
  const std::string but_that =
      fmt::format("mean e²/P is {} there, and about 1 in the other states", number_text(normalised / count));
  if (!of_P.empty()) {
    return fmt::format("P is perhaps in degrees in {}, where the error is in radians: {}.",
                       fmt::join(of_P, ", "), but_that);
  }
  return fmt::format("{} {} perhaps in degrees, where P is in radians, which are expected: {}.",
                     fmt::join(of_error, ", "), of_error.size() == 1 ? "is" : "are", but_that);
}

void AngleUnits::finish() {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (std::string text = wrap_text(i); !text.empty()) return ForwardingSink::mistake(std::move(text));
  }
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (std::string text = all_in_degrees_text(i); !text.empty())
      return ForwardingSink::hint(std::move(text));
  }
  if (!of_all_states_.empty()) return ForwardingSink::misfit(std::move(of_all_states_));
  if (std::string text = likely_text(); !text.empty()) return ForwardingSink::misfit(std::move(text));
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (std::string text = fills_circle_text(i); !text.empty()) ForwardingSink::remark(std::move(text));
  }
  if (unexplained_) ForwardingSink::unexplained();
}

}  // namespace credence::internal
