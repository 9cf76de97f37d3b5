#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/calibration/calibration_sums.h"
#include "analysis/evidence/sums/evidence.h"
#include "analysis/evidence/sums/run_innovations.h"
#include "analysis/evidence/sums/step_normaliser.h"
#include "analysis/laws/correlation/lateness.h"
#include "core/linear_algebra/correlation_whitening.h"
#include "core/record/normalised_step.h"
#include "core/record/step.h"
#include "montecarlo/engine/engine.h"

namespace credence::internal {

/// Adds the steps of runs to the sums: NEES over the range of P, NIS, and their relatives.
///
/// A step whose P or S is not positive semidefinite or not symmetric, or whose error lies in a direction in
/// which P is singular, is counted as rejected with its reason and never repaired: neither its NEES nor its
/// NIS counts. A state that errs where its variance is 0 is left out of the step, and counted.
class EvidenceRecorder {
 public:
  EvidenceRecorder() = default;
  /// The next steps are of this layout, and none of a file. few: there may be few runs in all, with those of
  /// others (StretchSums::kMostRuns).
  explicit EvidenceRecorder(const RunLayout& layout, bool few = true) : few_(few) { begin_file({}, layout); }

  /// The next rows come from this file.
  void begin_file(const std::filesystem::path& file, const RunLayout& layout);
  /// The next steps belong to another run.
  void begin_run() { begin_runs(1); }
  /// They belong to these many other runs that are played side by side, and end in their order: the sums are
  /// those of one run after the other, to the bit.
  void begin_runs(std::int64_t count);
  /// The next step of the open run, or of the i-th of them. False where it is rejected.
  bool add(const Step& step, std::size_t i = 0);
  void add(const NormalisedStep& step, std::size_t i = 0);
  /// The next step of that run cannot be used; `line`: of its file.
  void reject(std::int64_t step, std::int64_t line, std::string_view problem, std::size_t i = 0);
  /// Of the step last added, until the next one.
  FactoredState factored() const { return {normaliser_.factor_of_state(), &normalised_}; }
  /// It ended so, at this step.
  void end_run(Outcome outcome, std::int64_t step, std::size_t i = 0);

  /// The chunks of kChunkRuns runs that are full; the caller merges them in their order.
  std::vector<Evidence> take_chunks() { return std::exchange(full_, {}); }
  /// The sums of the last chunk; the next ones begin at nothing.
  Evidence take();

 private:
  struct WayPoint {
    Vector estimate{};
    double sine = kNaN, cosine = kNaN;  ///< of the heading of a pose with a map; NaN: not yet known
  };

  /// Of a block, summed over steps.
  struct BlockSquares {
    double claimed = 0.0, error = 0.0;  ///< the trace of its P, and its |e|²
    std::int64_t steps = 0;
  };

  struct OpenRun {
    bool open = false, first = false;
    double log_determinant = kNaN, change = kNaN;  ///< of P at the last step, and over it
    Index dof = 0;                                 ///< of the state then
    std::vector<double> nees{};
    Moments values{};           ///< of NEES
    RunSum whole{}, vehicle{};  ///< of NEES
    std::vector<RunSum> blocks{};
    std::vector<CoarseSeries> block_nees{};     ///< NEES / dof of each block, of few runs
    std::vector<BlockSquares> squares{};        ///< of each block, over its steps
    std::vector<RunInnovations> innovations{};  ///< of each sensor of the layout
    BlockError last{}, last_state{};            ///< of the block that leads, and of the whole state
    RunLaw law{};
    RunLateness lateness{};
    std::vector<Index> way_states{};  ///< of the estimates of the way
    std::array<WayPoint, 4> way{};    ///< of the last steps, that of way_steps mod 4 the oldest
    std::size_t way_steps = 0;        ///< so far, of these states
    RunScore score{};
    std::int64_t rows = 0;                                    ///< that were not rejected
    std::map<Index, WholeTurns> turns{};                      ///< by the state, of the layout
    std::vector<std::vector<WholeTurns>> innovation_turns{};  ///< of each sensor of the layout
  };

  void list_blocks();  ///< in the order of the layout, seen or not
  BlockSums& sums_of_block(std::size_t b) { return sums_.blocks[block_at_[b]]; }
  /// The step that comes next, of any run: its entry.
  void count(std::int64_t step);
  void reject(OpenRun& run, std::int64_t line, std::string_view problem);
  /// One row more, the first at this line of the file.
  void count_row(std::int64_t line, CountedRows& rows) const;
  void add(OpenRun& run, const StepPlaces& places, const NormalisedStep& step);
  void add_state(OpenRun& run, const StepPlaces& places, const NormalisedStep& step);
  void add_law(OpenRun& run, const StepPlaces& places, const NormalisedStep& step);
  void add_averaged(RunLaw& run, const Vector& error, const Vector& variance, const Matrix& P);
  void add_turns_of_states(OpenRun& run, const NormalisedStep& step) const;
  void add_large(RunLaw& run, const NormalisedStep& step);
  void add_lateness(OpenRun& run, const NormalisedStep& step);
  void add_moving(RunLateness& run, const VectorRef& error, const VectorRef& motion, const MatrixRef& P,
                  CorrelationWhitening& whitening);
  void add_scores(OpenRun& run, const NormalisedStep& step) const;
  void sum_blocks(const StepPlaces& places, const NormalisedStep& step);
  void add_traces(const StepPlaces& places, const NormalisedStep& step, StepStatistics& sums) const;
  void add_innovations(OpenRun& run, const NormalisedStep& step);
  void add_innovation(OpenRun& run, std::size_t sensor, const NormalisedInnovation& value);
  void close_run(OpenRun& run, bool well);
  void close_last(const BlockError& state);
  void close_runs();

  bool few_ = true;
  std::string file_;
  RunLayout layout_;
  Evidence sums_;
  std::vector<Evidence> full_;
  std::vector<OpenRun> runs_;
  std::vector<StepPlaces> places_;     ///< of each open run
  std::int64_t entry_ = 0;             ///< of the step at hand in the series of steps, from 1; 0: none
  std::vector<std::size_t> block_at_;  ///< of each block of the layout, among those of the sums
  Index position_ = -1;                ///< the block of the position; −1: there is none
  bool planar_map_ = false;            ///< the layout has one
  Index averaged_dim_ = -1;            ///< of the errors whose second moments are taken; −1: of none
  std::string averaged_;               ///< the block of those errors; "": the state
  Index lead_ = -1;                    ///< lead_block
  StepNormaliser normaliser_;
  NormalisedStep normalised_;
  CorrelationWhitening whitening_, of_moving_;
  Vector variance_, whitened_, moved_, motion_;
  std::vector<BlockSquares> squares_;  ///< of each block at the step at hand
};

}  // namespace credence::internal
