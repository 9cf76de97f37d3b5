#include "core/simd/trigonometry_kernel.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/manifold/trigonometry.h"

namespace credence::internal {
namespace {

constexpr double kUntouched = -77.0;
constexpr double kInf = std::numeric_limits<double>::infinity();

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// The kernels that this machine runs, each called for every count up to three packs, with `special` at every
/// place in turn.
template <class Check>
void for_every_place(double special, Check check) {
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    SCOPED_TRACE(instruction_set_name(set));
    for (std::size_t count = 0; count <= 25; ++count) {
      for (std::size_t place = 0; place <= count; ++place) {
        std::vector<double> values(count);
        for (std::size_t i = 0; i < count; ++i) values[i] = 0.37 * static_cast<double>(i) - 3.0;
        if (place < count) values[place] = special;
        check(trigonometry_kernel(set), values);
      }
    }
  }
}

TEST(TrigonometryKernel, ArcTangentsAreThoseOfOneByOneWhereverTheLongWayIs) {
  for (const double special : {0.0, -0.0, kInf, std::nan(""), 1e-310}) {
    for_every_place(special, [](const TrigonometryKernel& kernel, const std::vector<double>& y) {
      std::vector<double> x(y.size()), out(y.size() + 1, kUntouched);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = i % 3 == 0 ? -0.5 : 0.25 * static_cast<double>(i % 5);
      arc_tangents_by(kernel, y.data(), x.data(), out.data(), y.size());
      for (std::size_t i = 0; i < y.size(); ++i) {
        ASSERT_EQ(bits(out[i]), bits(arc_tangent(y[i], x[i]))) << i << " of " << y.size();
      }
      ASSERT_EQ(out.back(), kUntouched);
    });
  }
}

TEST(TrigonometryKernel, AreDoneInPacksWhereNothingIsSpecial) {
  const std::vector<double> angles(64, 0.3);
  std::vector<double> out(64);
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    const TrigonometryKernel& kernel = trigonometry_kernel(set);
    for (const std::size_t count : {64U, 61U, 3U, 1U}) {
      EXPECT_EQ(kernel.arc_tangents(angles.data(), angles.data(), out.data(), count), count);
    }
  }
}

}  // namespace
}  // namespace credence::internal
