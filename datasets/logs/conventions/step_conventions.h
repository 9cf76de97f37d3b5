#pragma once

#include <string>
#include <vector>

#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// Hands everything on, and looks whether errors that do not fit their covariance would fit with a mistake of
/// units undone: standard deviations for variances, an information matrix, degrees among radians in one angle
/// or in all of them; else whether P is written in another order than the states, part by part, or truth and
/// estimate do not fit together (truth_readings.h). Nothing where one factor on P between 1/4 and 4 is
/// enough.
///
/// For logs of any states; poses are looked at by ConventionCheck. Keeps at most 4096 of the steps at which
/// all states are there, evenly spread; looks at nothing with more than 24 states.
class StepConventions final : public ForwardingSink {
 public:
  using ForwardingSink::ForwardingSink;

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;

  /// After the last step: hands on what is to be said.
  void finish();

 private:
  std::string other_order() const;

  RunLayout layout_;
  std::vector<Matrix> rows_;  ///< P, and as further columns error and estimate (NaN: not known)
  std::size_t stride_ = 1, seen_ = 0;
};

}  // namespace credence::internal
