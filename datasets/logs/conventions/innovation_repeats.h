#pragma once

#include <cstdint>
#include <vector>

#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// Hands everything on, and looks whether half of the innovations of a sensor or more are, to the last bit,
/// those of the row before, or zero, as where nothing was measured, or those of another sensor in the same
/// row: they are no innovations of their own.
class InnovationRepeats final : public ForwardingSink {
 public:
  using ForwardingSink::ForwardingSink;

  void begin_run(const RunLayout& layout) override;
  void add(const Step& step) override;

  /// After the last step: hands on what is to be said.
  void finish();

 private:
  struct OfSensor {
    std::string name;
    Vector last;  ///< ν of the row before in this run; empty where there is none
    std::int64_t rows = 0, repeats = 0, zeros = 0, copies = 0;
    std::string copied = {};  ///< the sensor whose innovations it repeats
  };

  std::vector<OfSensor> sensors_;
};

}  // namespace credence::internal
