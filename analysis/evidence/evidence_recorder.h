#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/evidence/evidence.h"
#include "analysis/laws/lateness.h"
#include "core/nan.h"
#include "core/record/step.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/planar/covariance_statistics.h"

namespace credence {

/// Adds the steps of runs to the sums: NEES over the range of P, NIS, and their relatives.
///
/// A step whose P or S is not positive semidefinite, not symmetric, or whose error lies where P claims
/// certainty, is counted as rejected with its reason and never repaired: neither its NEES nor its NIS counts.
class EvidenceRecorder {
 public:
  EvidenceRecorder() = default;
  /// The next steps are of this layout, and none of a file.
  explicit EvidenceRecorder(const RunLayout& layout) { begin_file({}, layout); }

  /// The next rows come from this file.
  void begin_file(const std::filesystem::path& file, const RunLayout& layout);
  /// The next steps belong to another run.
  void begin_run();
  void add(const Step& step);
  /// The run that is open ended so, at this step.
  void end_run(Outcome outcome, std::int64_t step);

  /// The chunks of kChunkRuns runs that are full; the caller merges them in their order.
  std::vector<Evidence> take_chunks() { return std::exchange(full_, {}); }
  /// The sums of the last chunk; the next ones begin at nothing.
  Evidence take();

 private:
  struct Normalised {
    double value = 0.0;
    Vector whitened{};
    Index dof = -1;                 ///< −1: nothing to normalise
    bool factorised = false;        ///< `solver` holds the factor of the covariance
    double log_determinant = kNaN;  ///< of a covariance of full rank
    double noise_share = kNaN;      ///< tr(S⁻¹ R)/m of an innovation, where R is known
    std::string_view problem = {};
    NeesSolver solver{};  ///< one of each kind of value, so that none changes its size
    Vector error{};       ///< of the first block, of the position, and of blocks of some but not all states
    Matrix P{};           ///< likewise

    void clear();
    void take(const Step& step, const std::vector<Index>& places);
    void normalise(const VectorRef& e, const MatrixRef& covariance);
    /// Of one state, with the same bits and without a matrix.
    void normalise(double e, double variance);
  };

  /// What the steps of the open run leave behind for its end: the normalised innovations of one sensor.
  struct RunInnovations {
    std::vector<double> values;         ///< one after the other
    std::vector<std::size_t> begins{};  ///< of each step in `values`; an empty one had no measurement
  };

  /// The open run.
  struct OpenRun {
    bool open = false;
    std::vector<double> nees{};
    Moments values{};           ///< of NEES
    RunSum whole{}, vehicle{};  ///< of NEES
    std::vector<RunSum> blocks{};
    std::vector<Moments> squared_error{};       ///< of each block
    std::vector<RunInnovations> innovations{};  ///< of each sensor of the layout
    Vector last_error{};
    Matrix last_covariance{};
    Vector last_whitened{};  ///< of the whole state
    RunLaw law{};
    RunLateness lateness{};
    std::vector<Index> way_states{};  ///< of the estimates of the way
    std::deque<Vector> way{};         ///< of the last steps, the newest at the end
    RunScore score{};
  };

  void list_blocks();  ///< in the order of the layout, seen or not
  BlockSums& sums_of_block(std::size_t b) { return sums_.blocks[block_at_[b]]; }
  void find_places(const Step& step);
  std::string_view judge_state(const Step& step);
  std::string_view judge_innovations(const Step& step);
  void reject(const Step& step, std::string_view problem);
  void add_state(const Step& step);
  void add_angles(const Step& step);
  void add_law(const Step& step);
  void add_lateness(const Step& step);
  void add_lateness_of(const Step& step);
  std::vector<Index> pose_and_landmark(std::int64_t step) const;
  void add_scores();
  void add_sensor_pairs();
  void add_traces(const Step& step, StepStatistics& sums) const;
  void add_innovations(const Step& step);
  void add_innovation(std::size_t sensor, const Step& step);
  void add_missing(std::size_t sensor);
  void close_run(bool well);
  void close_innovations(std::size_t sensor);

  std::string file_;
  RunLayout layout_;
  Evidence sums_;
  std::vector<Evidence> full_;
  OpenRun run_;
  std::int64_t entry_ = 0;                  ///< of the step at hand in the series of steps, from 1; 0: none
  std::vector<std::size_t> block_at_;       ///< of each block of the layout, among those of the sums
  std::vector<std::size_t> landmarks_;      ///< blocks of landmarks in the plane, beside the pose_
  Index pose_ = -1;                         ///< the block of a pose in the plane; −1: there is none
  Index position_ = -1;                     ///< the block of the position; −1: there is none
  Index averaged_dim_ = -1;                 ///< of the errors whose second moments are taken; −1: of none
  std::vector<Index> states_;               ///< of the step that places_ is of
  std::vector<std::vector<Index>> places_;  ///< of the states of each block in the step at hand
  std::vector<Index> angles_;               ///< the places of angles in the step at hand
  Normalised state_;                        ///< of the step at hand
  std::vector<Normalised> blocks_, innovations_;  ///< of the step at hand
};

}  // namespace credence
