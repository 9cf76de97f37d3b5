#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/linear_algebra/small_cholesky.h"
#include "core/nan.h"
#include "core/record/normalised_step.h"
#include "core/record/run_layout.h"
#include "core/record/step.h"
#include "montecarlo/engine/study_statistics.h"

namespace credence::internal {

/// A row of a log on its way to the sums: normalised, which does not depend on other rows, or left as it was
/// read. Both give the same bits.
struct NormalisedRow {
  std::int64_t step = 0, line = 0;  ///< as of Step
  std::string_view problem = {};    ///< why it cannot be used, else empty
  NormalisedStep normalised{};      ///< without a problem
  SmallCholesky factor{};           ///< of P, of a state that is calibrated
  bool factored = false;            ///< there is one
  bool left = false;                ///< nothing of this is known but the step as it was read
  /// As it was read; of a state that is calibrated and has no factor without estimate and innovations.
  Step state{};
  double travelled_m = kNaN;  ///< by the truth in its run so far
};

/// Takes the rows of runs, one run after the other.
class RowSink {
 public:
  virtual ~RowSink() = default;

  /// The rows that follow belong to another run of this file; `name`: of the run.
  virtual void begin_run(const std::filesystem::path& file, const RunLayout& layout,
                         const std::string& name) = 0;
  /// The run that is open has this name after all.
  virtual void rename_run(const std::string& name) = 0;
  virtual void add(const NormalisedRow& row) = 0;
  /// Where the next row is written best: there it is not copied, and it keeps its memory.
  virtual NormalisedRow& room() { return room_; }
  /// Whether who takes the rows waits for them: then work is better left to them.
  virtual bool waits() const { return false; }
  /// The run that is open failed at this step.
  virtual void end_run(Outcome outcome, std::int64_t step) = 0;

 private:
  NormalisedRow room_;
};

}  // namespace credence::internal
