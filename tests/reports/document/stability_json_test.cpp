#include "reports/document/stability_json.h"

#include <gtest/gtest.h>

#include <complex>

#include "tests/reports/document/parts_of.h"

namespace credence::internal {
namespace {

TEST(StabilityJson, ARankHasItsGapOrTheReasonWhyNot) {
  EXPECT_EQ(rank_json(decide_rank(Vector{{4.0, 2.0, 1e-12}})).dump(),
            R"({"rank":2,"gap":2000000000000.0,"singular_values":[4.0,2.0,1e-12]})");
  const Json all = as_read(rank_json(decide_rank(Vector{{4.0, 2.0}})));
  EXPECT_TRUE(all["gap"].is_null());
  EXPECT_TRUE(all["gap_null_reason"].is_string());
}

TEST(StabilityJson, EigenvaluesArePairs) {
  Eigen::VectorXcd values(2);
  values << std::complex<double>(0.5, -0.25), std::complex<double>(1.0, 0.0);
  EXPECT_EQ(eigenvalues_json(values).dump(), "[[0.5,-0.25],[1.0,0.0]]");
  EXPECT_EQ(eigenvalues_json(Eigen::VectorXcd()).dump(), "[]");
}

}  // namespace
}  // namespace credence::internal
