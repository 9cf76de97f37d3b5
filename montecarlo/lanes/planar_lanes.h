#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/filters/ekf_slam.h"
#include "core/record/normalised_step.h"
#include "montecarlo/lanes/planar_lanes_kernel.h"
#include "montecarlo/lanes/planar_nees_lanes.h"
#include "montecarlo/worlds/planar/planar_step.h"
#include "montecarlo/worlds/planar/planar_world.h"

namespace credence::internal {

/// EKF-SLAM ([Vidal-Calleja 2004], eqs (3)-(10)) for eight runs of one planar world at a time, one run in a
/// lane: what EkfSlam<PlanarModel> computes, to rounding, several times faster where the
/// map is small.
///
/// Landmark i has its place in the state from the start, with zero rows in P until a run has seen it, so that
/// all lanes do the same arithmetic whatever they see; a measurement that a lane does not have is one of
/// innovation zero and Jacobian zero. A lane's bits depend on its own run alone, and not on the instruction
/// set. Nothing is allocated after the construction. `world` must live as long.
///
/// The covariance update is the Joseph form with S = L Lᵀ and W = P Hᵀ L⁻ᵀ: it equals
/// P − W Wᵀ + (W − K L)(W − K L)ᵀ, whose last term is the square of the rounding error in K and left out.
class PlanarLanes {
 public:
  static constexpr int kLanes = kPlanarLanes;
  using Observations = std::span<const Observation<PlanarModel>>;

  /// `Q` of the noise on the control and the variances of range and bearing are those that the filter
  /// assumes. `inflate_map`: before every update, by Inflation::map and InflationSolution::pairwise.
  PlanarLanes(const PlanarWorld& world, const Eigen::Matrix2d& Q, const RangeBearing& measurement_variance,
              bool inflate_map = false, InstructionSet set = best_instruction_set());

  /// Starts a run with a pose of covariance P and an empty map.
  void reset(int lane, const Pose& pose, const Eigen::Matrix3d& P);

  void predict(const Control& u);

  /// What each lane sees. A lane whose S is not positive definite keeps its state: UpdateResult::ok is false.
  void update(const std::array<Observations, kLanes>& seen);

  /// Whether P = L Lᵀ is factored: where a lane that counts has no NEES along its run (PlanarNeesLanes), or
  /// to check those NEES. Which steps are checked must depend on the run alone.
  enum class Factor { if_needed, check };

  /// Errors and statistics of all lanes after the update, given the true poses; on request also what
  /// `normalised` tells.
  void judge(const std::array<Pose, kLanes>& truth, bool normalise = false, Factor factor = Factor::check);
  /// The errors and the innovation of a lane whose outcome is ok, its blocks those of planar_layout. False,
  /// and nothing told, where P or S is singular or so near it that rounding has eaten a pivot.
  bool normalised(int lane, NormalisedStep& told) const;
  const PlanarStep& step(int lane) const { return steps_[static_cast<std::size_t>(lane)]; }
  /// Whether its NEES is that along its run, and not by a factor of P.
  bool follows(int lane) const { return nees_along_run_.has_value(lane); }

  /// One lane as a matrix filter would say it; landmarks by number, those that are known.
  std::vector<int> landmarks(int lane) const;
  Vector state(int lane) const;
  Matrix covariance(int lane) const;
  Vector innovation(int lane) const;
  Matrix innovation_covariance(int lane) const;
  Matrix gain(int lane) const;

 private:
  using Numbers = LaneNumbers;

  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  Lanes& covariance_at(Index i, Index j) {
    return i >= j ? P_[at(j * padded_ + i)] : P_[at(i * padded_ + j)];
  }
  const Lanes& covariance_at(Index i, Index j) const {
    return const_cast<PlanarLanes*>(this)->covariance_at(i, j);
  }
  const Lanes& update_at(Index i, Index j) const { return A_[at(j * (2 * measured_ + padded_ + 1) + i)]; }

  PlanarLanesData kernel_data();
  void take(const std::array<Observations, kLanes>& seen);
  void set_innovations();
  void drop_failed_lanes();
  void initialise(int lane, Index landmark, const RangeBearing& z);
  void normalise_blocks(int lane, NormalisedStep& told) const;
  void take_moving(int lane, NormalisedStep& told) const;
  void normalise_innovation(int lane, NormalisedInnovation& told) const;
  void compute_errors(const std::array<Pose, kLanes>& truth);
  void follow_nees(const std::array<Pose, kLanes>& truth, bool logarithms);
  void factor_covariance(bool normalise);
  void check_nees();
  std::vector<Index> states_of(int lane) const;
  std::vector<Index> columns_of(int lane) const;
  Matrix update_root(int lane) const;

  const PlanarWorld& world_;
  PlanarModel model_;
  Eigen::Matrix2d Q_;
  RangeBearing variance_;
  bool inflate_map_;
  const PlanarLanesKernel& kernel_;
  Index states_, padded_, measured_ = 0;

  Numbers x_, P_;
  std::vector<LaneSet> known_;         ///< by landmark
  std::array<Index, kLanes> count_{};  ///< landmarks that a lane knows, without the anchors
  std::vector<LaneSet> visible_;       ///< by landmark, of this step
  std::vector<LaneSet> used_;          ///< by measured landmark
  Numbers z_;                          ///< 2 a landmark
  Numbers anchors_;                    ///< 2 an anchor
  std::vector<Index> of_measured_;
  struct Initialised {
    int lane;
    Index state;
    Eigen::Matrix<double, 2, 3> J_r;
    Eigen::Matrix2d noise;  ///< J_z R J_zᵀ
  };
  std::vector<Initialised> initialised_;  ///< by the last update
  std::vector<std::int64_t> offset_;
  std::vector<const double*> place_;
  Numbers difference_, direction_, H_, R_, nu_, innovation_covariance_, A_, F_, GQG_;
  Lanes nis_, check_;
  Numbers error_, whitened_error_, diagonal_, L_;
  Numbers columns_, landmark_nees_;
  Lanes share_, doubt_of_S_, nees_, vehicle_nees_, map_nees_, doubt_;
  PlanarNeesLanes nees_along_run_;
  Numbers predicted_, prior_;  ///< 3: the predicted pose, and its error
  LaneSet lost_ = 0;           ///< lanes that have failed
  bool checked_ = false;       ///< P and NEES, by the last judge
  std::array<PlanarStep, kLanes> steps_;
};

}  // namespace credence::internal
