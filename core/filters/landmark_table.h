#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/types.h"

namespace credence::internal {

[[noreturn]] inline void throw_twice(int landmark) {
  throw std::invalid_argument("landmark " + std::to_string(landmark) + " is there twice");
}

/// A landmark at a known place, which is no state.
template <class Model>
struct Anchor {
  int landmark = 0;
  Eigen::Matrix<double, Model::kLandmark, 1> position;
};

/// Which landmarks an estimator knows: those in its state, by the order of first observation, and its
/// anchors.
template <class Model>
class LandmarkTable {
 public:
  using Position = Eigen::Matrix<double, Model::kLandmark, 1>;

  explicit LandmarkTable(std::span<const Anchor<Model>> anchors) {
    for (const Anchor<Model>& anchor : anchors) {
      Slot& slot = slot_of(anchor.landmark);
      slot.anchored = true;
      slot.position = anchor.position;
    }
  }

  /// Forgets all landmarks but the anchors; those with these numbers are in the state, in this order. Throws
  /// std::invalid_argument for one that is there twice.
  void reset(std::span<const int> ids) {
    for (Slot& slot : slots_) slot.column = -1;
    ids_.clear();
    for (const int id : ids) {
      if (column_of(id) >= 0) throw_twice(id);
      append(id);
    }
  }

  /// Takes landmark `id`, until then unknown, into the state.
  void append(int id) {
    slot_of(id).column = Model::kLandmark * static_cast<Index>(ids_.size());
    ids_.push_back(id);
  }

  /// Where landmark `id` starts in the map part of the state, −1 if it is not there. Throws
  /// std::invalid_argument for a negative number.
  Index column_of(int id) const {
    require(id);
    const auto i = static_cast<std::size_t>(id);
    return i < slots_.size() ? slots_[i].column : -1;
  }

  /// The place of an anchor, null for what is none.
  const Position* anchor(int id) const {
    require(id);
    const auto i = static_cast<std::size_t>(id);
    return i < slots_.size() && slots_[i].anchored ? &slots_[i].position : nullptr;
  }

  /// True for an anchor and for a landmark of the state.
  bool is_known(int id) const { return anchor(id) != nullptr || column_of(id) >= 0; }

  /// Where landmark `id` starts in a state that begins with the pose, −1 if it is not there.
  Index offset_of(int id) const {
    const Index column = id < 0 ? -1 : column_of(id);
    return column < 0 ? -1 : Model::kPose + column;
  }

  /// Numbers of the landmarks in the state, in its order.
  const std::vector<int>& ids() const { return ids_; }

  /// Memory that grows with the map.
  std::size_t bytes() const { return sizeof(int) * ids_.capacity() + sizeof(Slot) * slots_.capacity(); }

 private:
  struct Slot {
    Index column = -1;
    bool anchored = false;
    Position position = Position::Zero();
  };

  static void require(int id) {
    if (id < 0) throw std::invalid_argument("a landmark's number must not be negative");
  }

  Slot& slot_of(int id) {
    require(id);
    const auto i = static_cast<std::size_t>(id);
    if (i >= slots_.size()) slots_.resize(i + 1);
    return slots_[i];
  }

  std::vector<Slot> slots_;  ///< by number
  std::vector<int> ids_;
};

}  // namespace credence::internal
