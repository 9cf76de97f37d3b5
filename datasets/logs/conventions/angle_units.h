#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// Hands everything on, and looks at each state by itself, whether it is an angle in degrees or one that is
/// not said to be an angle. Comes behind StepConventions, whose finding about the whole state goes before
/// what is only likely here.
///
/// Certain is a wrap: of successive estimates of a run, one near an end of a turn and the next near the
/// other. Likely is an angle with a σ that leaves it unknown, whose estimates, where there are some, go
/// beyond a turn. What else is likely is told where all other states have errors as P says: errors that are
/// larger than P says as degrees are larger than radians, or smaller; of an angle with a small σ whose errors
/// fill the whole circle it is said that they do. States that are not said to be angles, such as the
/// components of a rotation vector, must be so more closely; those whose unit or name says that they are
/// none, as "position.x", are left alone.
class AngleUnits final : public ForwardingSink {
 public:
  using ForwardingSink::ForwardingSink;

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;
  void misfit(std::string sentence) override { of_all_states_ = std::move(sentence); }
  void unexplained() override { unexplained_ = true; }

  /// After the last step: hands on what is to be said.
  void finish();

 private:
  enum class InDegrees { nothing, P, error };

  struct State {
    double last = 0.0;               ///< estimate of the step before; NaN at the first of a run
    double least = 0.0, most = 0.0;  ///< of all estimates
    double least_error = 0.0, most_error = 0.0;
    double normalised = 0.0, largest = 0.0;         ///< sum of e²/P, largest of them
    double sigma = 0.0;                             ///< sum of √P
    double square = 0.0, cosine = 0.0, sine = 0.0;  ///< sums of e², cos e and sin e, of an angle
    std::int64_t count = 0, estimates = 0;
    std::int64_t wraps_of_degrees = 0, wraps_of_radians = 0;

    void add_estimate(double value);
    double mean_square() const { return normalised / static_cast<double>(count); }
  };

  std::string wrap_text(std::size_t state) const;
  std::string all_in_degrees_text(std::size_t state) const;
  InDegrees in_degrees(std::size_t state) const;
  std::string fills_circle_text(std::size_t state) const;
  std::string likely_text() const;

  RunLayout layout_;
  std::vector<State> states_;
  std::string of_all_states_;
  bool unexplained_ = false;
};

}  // namespace credence::internal
