#include "datasets/logs/conventions/truth_readings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "core/number_text.h"
#include "datasets/logs/conventions/reading_fit.h"

namespace credence::internal {
namespace {

constexpr double kFarOff = 50.0, kRight = 4.0;
constexpr double kMetresOfFoot = 0.3048;

/// The truth of a state is `factor` times what stands at that of state `from`.
struct TruthReading {
  Index from = 0;
  double factor = 1.0;
  double fit = std::numeric_limits<double>::infinity();  ///< mean e²/P
};

class TruthReader {
 public:
  TruthReader(const RunLayout& layout, std::span<const Matrix> rows)
      : states_(std::ssize(layout.states)), angles_(layout.angles) {
    rows_.reserve(rows.size());
    for (const Matrix& row : rows) {
      if (row.rows() == states_ && row.diagonal().minCoeff() > 0.0 && row.col(states_ + 1).allFinite())
        rows_.push_back(&row);
    }
  }

  std::size_t rows() const { return rows_.size(); }
  Index states() const { return states_; }
  bool is_angle(Index state) const { return angles_[static_cast<std::size_t>(state)]; }

  /// Mean e²/P as it is written.
  double as_written(Index state) const {
    return mean(state, std::numeric_limits<double>::infinity(),
                [&](const Matrix& row) { return row(state, states_); });
  }

  /// The reading that fits best; null: none is right.
  std::optional<TruthReading> right_reading(Index state) const {
    constexpr std::array kFactors = {-1.0, 1000.0, 0.001, 100.0, 0.01, kMetresOfFoot, 1.0 / kMetresOfFoot};
    TruthReading best;
    for (const double factor : kFactors) try_reading(state, {.from = state, .factor = factor}, best);
    for (Index from = 0; from < states_; ++from) {
      if (from == state || is_angle(from)) continue;
      for (const double sign : {1.0, -1.0}) try_reading(state, {.from = from, .factor = sign}, best);
    }
    return best.fit < kRight ? std::optional(best) : std::nullopt;
  }

  /// Whether estimates of a state are so many σ apart, or from zero, that no other number is by chance as
  /// near.
  bool is_told_apart(Index state) const {
    constexpr double kSpread = 1e2, kSize = 1e6;
    double centre = 0.0;
    for (const Matrix* row : rows_) centre += (*row)(state, states_ + 1) / static_cast<double>(rows_.size());
    const auto about = [&](double origin) {
      return mean(state, std::numeric_limits<double>::infinity(),
                  [&](const Matrix& row) { return row(state, states_ + 1) - origin; });
    };
    return about(centre) > kSpread || about(0.0) > kSize;
  }

 private:
  /// Mean of value²/P, or infinity once it is beyond `most`.
  template <class Value>
  double mean(Index state, double most, const Value& value) const {
    const auto count = static_cast<double>(rows_.size());
    double sum = 0.0;
    for (const Matrix* row : rows_) {
      const double of_row = value(*row);
      sum += of_row * of_row / (*row)(state, state);
      if (!(sum <= most * count)) return std::numeric_limits<double>::infinity();
    }
    return sum / count;
  }

  void try_reading(Index state, TruthReading reading, TruthReading& best) const {
    reading.fit = mean(state, kRight, [&](const Matrix& row) {
      const double truth = row(reading.from, states_ + 1) - row(reading.from, states_);
      return row(state, states_ + 1) - reading.factor * truth;
    });
    if (reading.fit < best.fit) best = reading;
  }

  Index states_;
  const std::vector<bool>& angles_;
  std::vector<const Matrix*> rows_{};
};

/// "the truth of px and py times 0.001".
std::string reading_text(const RunLayout& layout, const std::vector<std::optional<TruthReading>>& readings) {
  std::vector<std::string> texts;
  std::vector<bool> told(readings.size(), false);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (told[i] || !readings[i]) continue;
    const auto [from, factor, fit] = *readings[i];
    const bool own = from == static_cast<Index>(i);
    if (!own) {
      const auto other = static_cast<std::size_t>(from);
      const bool mutual = readings[other]->from == static_cast<Index>(i) && readings[other]->factor == factor;
      if (mutual) told[other] = true;
      const std::string &here = layout.states[i], &there = layout.states[other];
      texts.push_back((mutual ? fmt::format("the truths of {} and {} are exchanged", here, there)
                              : fmt::format("the truth of {} stands under {}", here, there)) +
                      (factor < 0.0 ? ", with the opposite sign" : ""));
      continue;
    }
    std::vector<std::string> names;
    for (std::size_t j = i; j < readings.size(); ++j) {
      if (!readings[j] || readings[j]->from != static_cast<Index>(j) || readings[j]->factor != factor)
        continue;
      told[j] = true;
      names.push_back(layout.states[j]);
    }
    const std::string all = fmt::format("{}", fmt::join(names, ", "));
    texts.push_back(factor < 0.0 ? fmt::format("the truth of {} has the opposite sign", all)
                                 : fmt::format("the truth of {} is in another unit (times {})", all,
                                               number_text(factor, 4)));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

std::string other_truth(const RunLayout& layout, std::span<const Matrix> rows) {
  const TruthReader reader(layout, rows);
  if (reader.rows() < kFewestForReading) return {};
  std::vector<std::optional<TruthReading>> readings(layout.states.size());
  bool no_chance = false;
  double before = 0.0, after = 0.0;
  for (Index state = 0; state < reader.states(); ++state) {
    if (reader.is_angle(state)) continue;
    const double as_written = reader.as_written(state);
    if (!(as_written > kFarOff)) continue;
    auto& reading = readings[static_cast<std::size_t>(state)] = reader.right_reading(state);
    if (!reading) return {};
    no_chance = no_chance || reader.is_told_apart(state);
    before = std::max(before, as_written);
    after = std::max(after, reading->fit);
  }
  if (!no_chance) return {};
  for (const std::optional<TruthReading>& reading : readings) {
    if (reading && !readings[static_cast<std::size_t>(reading->from)]) return {};  // no exchange
  }
  return fmt::format(
      "Truth and estimate do not fit together (mean e²/P of up to {}). They would if {}: then it is at most "
      "{}. "
      "Whether it is so, the log cannot say: look at the program that wrote it.",
      number_text(before, 3), reading_text(layout, readings), number_text(after, 3));
}

}  // namespace credence::internal
