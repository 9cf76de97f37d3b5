#include "reports/document/stability_json.h"

#include <cmath>
#include <complex>
#include <vector>

namespace credence::internal {

Json rank_json(const RankDecision& decision) {
  Json j;
  j["rank"] = decision.rank;
  j["gap"] = decision.gap;
  if (std::isinf(decision.gap)) {
    j["gap_null_reason"] = "infinite: no other singular value than zero was left out";
  }
  j["singular_values"] = json_vector(decision.singular_values);
  return j;
}

Json eigenvalues_json(const Eigen::VectorXcd& values) {
  Json j = Json::array();
  for (const std::complex<double>& z : values) j.push_back({z.real(), z.imag()});
  return j;
}

}  // namespace credence::internal
