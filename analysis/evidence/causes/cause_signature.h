#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "analysis/evidence/causes/cause_findings.h"

/// @file
/// What several rules on causes ask of the findings.

namespace credence::internal {

/// Shares of an excess, that of a mean of NEES or NIS over the expected one. A test tells whether something
/// is there, and of many runs everything is; these tell whether it is of the size of what is to be explained.
/// More than half of it is its cause.
inline constexpr double kMost = 0.5;
/// With less than this share of what it was it is all but gone, with 1 less this share it is there still.
inline constexpr double kAllButGone = 0.25;
/// An excess of NIS of less than this share of that of NEES is nothing beside it: the Jacobians that make
/// errors ten times as wrong move the innovations as well.
inline constexpr double kSmallBesideErrors = 0.1;

/// Of many runs a mean is significant that is of no size: what makes no more than a twentieth of what is
/// wrong is not its cause.
bool counts(double mean_square, double excess);

/// A share of R in S beyond which S is wrong only if R is.
inline constexpr double kMostly = 0.8;

/// 1 − confidence.
double alpha_of(const Findings& findings);

/// The false-alarm rate of each signature that is a test, (1 − confidence)/17, as several are looked for.
double cause_level(const Findings& findings);

/// The quantile of N(0, 1) that z exceeds at cause_level/tests: |z| for two tests.
double cause_quantile(const Findings& findings, double tests);

/// mean/expected − 1 over the steps first … last − 1; 0 without data.
double excess_of_steps(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last);
double excess_of_second_half(const ConsistencyVerdict& verdict);
double excess_of(const StepTest& step);
/// Over all steps, as the verdict has it.
double excess_of(const ConsistencyVerdict& verdict);

/// The steps of the first fifth, one at least.
std::size_t first_fifth(const ConsistencyVerdict& verdict);

/// The first step with data; null: none.
const StepTest* first_step(const ConsistencyVerdict& verdict);

/// Whether the first step with data is wrong (χ²).
bool starts_wrong(const ConsistencyVerdict& verdict, double level);

/// Whether one of the first `steps` steps leaves the bounds that all keep together.
bool any_step_outside(const ConsistencyVerdict& verdict, std::size_t steps);

/// Whether the second half has the excess still, and of the same sign.
bool stays(double excess, const ConsistencyVerdict& verdict);

/// The dof of the steps first … last − 1 that have data.
double dof_of_steps(const ConsistencyVerdict& verdict, std::size_t first, std::size_t last);

/// NIS is white, so that its sum over some steps is χ²: its p-value, 1 without data.
double p_value_of_sum(const ConsistencyVerdict& nis, std::size_t first, std::size_t last);

/// Whether NIS is wrong over the second half (χ²), by more than what its first one leaves behind.
bool noise_lasts(const Findings& findings);

/// The sum of the first lags of an autocorrelation that is farthest from zero.
struct LagSum {
  int gain = 0;                  ///< its sign, where it is no chance; else 0
  std::int64_t count = 0;        ///< lags
  double sum = 0.0, band = 0.0;  ///< beyond which the sum is no chance
};

/// Size and colour of the innovations after the first fifth of the steps: all that a wrong noise can change
/// in them.
struct InnovationShape {
  double excess = 0.0;      ///< of NIS
  double lag_1 = 0.0;       ///< autocorrelation
  double lag_1_band = 0.0;  ///< beyond which lag_1 is no chance; infinite where it is not known
  int gain = 0;             ///< the sign of q − r, by which Q and R are wrong; 0: not told
  LagSum lags = {};         ///< that tells it
  std::string sensor = {};  ///< of several that of the autocorrelation; "" where it is that of none by itself
};

/// The sign of the gain by the innovations of one sensor: of those with the gain that the filter believes in
/// the correlation at every lag is (q − r) times one matrix, so that lags that fade slowly are added up; the
/// largest of |Σ_{h ≤ L} z_h|/√L, L = 1, 5, 20, at cause_level, Bonferroni over the three.
LagSum gain_error(const WhitenessTest& whiteness, const Findings& findings);

/// The same by the errors, of a linear filter whose P0 is right, and where no mean is found: mean NEES over n
/// is A q + B r + 1 − A − B, and over a step without an innovation B falls, and with it P0's share, so that
/// what Q has in excess grows and what R has fades. 1: Q is wrong, −1: R is, where NIS has an excess of this
/// sign (Student's t over the runs, two-sided at cause_level); 0: not told.
int noise_between_innovations(const Findings& findings, bool high);

/// Of the innovations as they are. Of several sensors the autocorrelation is that of the one whose NIS is
/// most wrong: its own noise turns its innovations back, and those of the others on. Where that tells no
/// gain, it is that of the most correlated, unless its NIS is less than a third as wrong (by the logarithm).
InnovationShape innovation_shape(const Findings& findings);

/// Where NIS is wrong and NEES is right, what else may be: the filter may have another S than was written.
std::string_view where_errors_fit(const Findings& findings);

/// Where innovations are not white and NEES is consistent, which filters are right all the same; else empty.
std::string_view where_covariance_fits(const Findings& findings);

/// The lag-1 autocorrelation if it lies outside its band, else 0.
double lag_1_outside(const Findings& findings);

/// P that the linearisation makes too small has too small a gain as well, whose innovations are correlated;
/// but by less beside its errors than those of a Q that is too small, which all innovations show. Whether the
/// gain is told as too small, and the lags add up to that much.
bool lags_tell_process_noise(const Findings& findings);

/// What to say beside a cause that is only what is left: that P was not looked at for cross-covariances that
/// it lacks, and why; else empty.
std::string untested_correlation(const Findings& findings);

/// What to say beside a cause that takes for granted that nothing is late and no mean is wrong, of errors
/// that are too large: that so few runs do not tell a mean, and why lateness was not tested; else empty.
std::string untested_causes(const Findings& findings);

/// "; the errors also point back along the path, by 1.4 steps, 0.2 s, (p = …)" of errors that do so not by
/// chance, which explains some of the excess of NEES; else empty.
std::string back_along_path(const Findings& findings);
/// A shorter time, in steps, is too short to be named as the cause.
inline constexpr double kShortestDelay = 0.3;
/// What to say beside such a cause of errors that point back by less; else empty.
std::string short_delay(const Findings& findings);
/// ", 0.2 s,": so many steps in seconds; empty where the times are not known.
std::string in_seconds(double steps, const ConsistencyVerdict& verdict);

/// Whether what a quantity of each run gains has a mean above zero (Student's t at cause_level).
bool grows(const Moments& gain, const Findings& findings);

}  // namespace credence::internal
