#include "analysis/evidence/sums/whole_turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/append_item.h"

namespace credence::internal {

void WholeTurns::add(double error, double variance) {
  constexpr double kSigmas = 4.0, kNear = 0.05;  // about a turn: of its σ, or of the turn
  constexpr double kWidest = 0.05;               // a σ of the turn: of a wider one heavy tails are as large
  const double size = std::abs(error), sigma = std::sqrt(variance);
  for (std::size_t i = 0; i < kTurns.size(); ++i) {
    if (!(size > 0.5 * kTurns[i]) || sigma > kWidest * kTurns[i]) continue;
    ++of[i].beyond;
    const double near = std::max(kSigmas * sigma, kNear * kTurns[i]);
    if (std::abs(size - kTurns[i]) <= near) ++of[i].off;
  }
}

void WholeTurns::merge(const WholeTurns& later) {
  for (std::size_t i = 0; i < kTurns.size(); ++i) {
    of[i].beyond += later.of[i].beyond;
    of[i].off += later.of[i].off;
  }
}

void WholeTurns::add_run(const WholeTurns& run, std::int64_t rows) {
  constexpr std::int64_t kHalf = 2;
  for (std::size_t i = 0; i < kTurns.size(); ++i) {
    of[i].beyond += run.of[i].beyond;
    if (kHalf * run.of[i].off <= rows) of[i].off += run.of[i].off;
  }
}

std::optional<TurnsOff> turns_off(const WholeTurns& errors) {
  constexpr std::int64_t kFewest = 2, kTenth = 10;
  for (std::size_t i = 0; i < WholeTurns::kTurns.size(); ++i) {
    const auto [beyond, off] = errors.of[i];
    if (off >= kFewest && kTenth * off >= (kTenth - 1) * beyond)
      return TurnsOff{.count = off, .degrees = i == 1};
  }
  return std::nullopt;
}

std::string turns_text(std::string_view name, const TurnsOff& turns) {
  return fmt::format(
      "{} values of {} are a whole turn of {} off, and hardly anything else is as large: it is an angle, but "
      "not marked as one{}",
      turns.count, name, turns.degrees ? "360" : "2π",
      turns.degrees ? ", and in degrees, where radians are expected" : "");
}

void add_turns(const Vector& nu, const Vector& variance, Index piece, const std::vector<bool>& angles,
               std::vector<WholeTurns>& turns) {
  for (Index i = 0; i < nu.size(); ++i) {
    const auto component = static_cast<std::size_t>(i % piece);
    if (!angles.empty() && angles[component]) continue;
    if (!WholeTurns::concerns(nu[i], variance[i])) continue;
    turns.resize(std::max(turns.size(), static_cast<std::size_t>(piece)));
    turns[component].add(nu[i], variance[i]);
  }
}

void add_run(const std::vector<WholeTurns>& run, std::int64_t rows, std::vector<WholeTurns>& turns) {
  turns.resize(std::max(turns.size(), run.size()));
  for (std::size_t i = 0; i < run.size(); ++i) turns[i].add_run(run[i], rows);
}

std::string turns_text(std::string_view sensor, const std::vector<WholeTurns>& turns) {
  std::string text;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const std::optional<TurnsOff> off = turns_off(turns[i]);
    if (!off) continue;
    const std::string component = turns.size() > 1 ? fmt::format("component {} of ", i + 1) : "";
    const std::string name =
        fmt::format("{}the innovation{}{}", component, sensor.empty() ? "" : " of ", sensor);
    append_item(text, turns_text(name, *off), "; ");
  }
  return text;
}

}  // namespace credence::internal
