#include "analysis/evidence/sums/run_course.h"

#include <cstddef>
#include <iterator>

#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {

RunCourse course_of(std::span<const double> nees, double least_dof) {
  constexpr double kBeyondLevel = 1e-9;
  const double limit = chi_square_upper_quantile(kBeyondLevel, least_dof) / least_dof;
  RunCourse course{.rows = std::ssize(nees)};
  double sum = 0.0;
  for (std::size_t k = 0; k < nees.size(); ++k) {
    sum += nees[k];
    if (!(nees[k] > limit)) continue;
    if (course.beyond++ == 0) course.first = static_cast<std::int64_t>(k) + 1;
  }
  course.mean = sum / static_cast<double>(course.rows);
  return course;
}

}  // namespace credence::internal
