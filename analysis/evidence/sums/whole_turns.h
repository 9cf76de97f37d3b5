#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"

namespace credence::internal {

/// The errors of one number that P leaves no room for, beside a whole turn: of an angle that nobody marked
/// no difference is wrapped, and where estimate and truth lie on both sides of the wrap it is a turn off.
struct WholeTurns {
  static constexpr std::array<double, 2> kTurns = {2.0 * std::numbers::pi, 360.0};  ///< [rad], [degrees]
  static constexpr double kGross = 50.0;  ///< a Gaussian e²/P lies beyond once in 1e12

  struct Errors {
    std::int64_t beyond = 0;  ///< gross, and larger than half a turn
    std::int64_t off = 0;     ///< of these, about a turn
    bool operator==(const Errors&) const = default;
  };
  std::array<Errors, kTurns.size()> of{};

  /// Whether an error is gross, and larger than half of the smaller turn.
  static bool concerns(double error, double variance) {
    return error * error > kGross * variance && std::abs(error) > 0.5 * kTurns[0];
  }
  /// Of one that concerns. Where σ is more than a twentieth of a turn heavy tails are as large as one.
  void add(double error, double variance);
  void merge(const WholeTurns& later);
  /// Those of one more run, of so many rows: what is off in more than half of them stays there, as a bias
  /// does.
  void add_run(const WholeTurns& run, std::int64_t rows);
  bool operator==(const WholeTurns&) const = default;
};

/// Errors that are explained by a whole turn.
struct TurnsOff {
  std::int64_t count = 0;
  bool degrees = false;
};

/// Null unless there are at least two, and nine in ten of all that are as large: outliers are of any size.
std::optional<TurnsOff> turns_off(const WholeTurns& errors);
/// "3 values of heading are a whole turn of 2π off, …".
std::string turns_text(std::string_view name, const TurnsOff& turns);

/// Of innovations, whose components are those of pieces: variances are of S, and `angles` says which of each
/// piece are marked as angles (empty: none). `turns` grows as is needed.
void add_turns(const Vector& nu, const Vector& variance, Index piece, const std::vector<bool>& angles,
               std::vector<WholeTurns>& turns);
/// `turns` and those of one more run, of so many rows.
void add_run(const std::vector<WholeTurns>& run, std::int64_t rows, std::vector<WholeTurns>& turns);
/// What there is to say of those of a sensor; empty: nothing.
std::string turns_text(std::string_view sensor, const std::vector<WholeTurns>& turns);

}  // namespace credence::internal
