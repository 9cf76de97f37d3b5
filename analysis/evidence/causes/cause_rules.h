#pragma once

#include <vector>

#include "analysis/evidence/causes/advice_cause.h"

/// @file
/// The rules by which causes are found, one signature each. Each says what evidence it needs and names
/// nothing without it, which test it makes, and what it names. A test is at cause_level where no other level
/// is said; "speaks" means that a test of the suite rejects with all others taken together (Holm).

namespace credence::internal {

/// What a rule finds: none, or the cause with what goes beside it.
using Causes = std::vector<CauseFound>;

/// Innovations that are logged and not used. Names gated_innovations where log det P falls less beyond a gate
/// than within it (gate_rejection.h), NEES or NIS is optimistic, and as many lie beyond, p by the law, as
/// such a gate makes by itself, p to p (1.5 + 50 p); not where they are outliers.
Causes find_rejected_innovations(const Findings& findings);
/// The same where more lie beyond, beside the cause of that.
Causes find_rejection_beside(const Findings& findings);

// Runs (cause_rules_law.cpp).

/// Runs of a joint P. Names lost_runs by the test of lost_runs.h, where the word is inconsistent.
Causes find_runs_that_are_lost(const Findings& findings);

/// Names shared_noise where at the same step the errors of all runs have a mean, another at every step, and
/// scatter about it by as much less than P claims (mean_at_steps.h): a bias has the spread that P claims. Not
/// where mean NIS is wrong beyond the chance of one run, as each of them is right.
Causes find_shared_noise(const Findings& findings);

// Angles and laws: what no covariance mends, and what is no fault of the covariance (cause_rules_law.cpp).

/// Innovations that are angles, and all that is not marked as one. Names unwrapped_angle where one lies
/// beyond half a turn, since none that is wrapped can, and where what is not marked lies a turn off
/// (turns_off): no test.
Causes find_unwrapped_angle(const Findings& findings);
/// Angles of the state. Names wide_angle where NEES is inconsistent and one in a hundred has a σ beyond
/// kWideAngle: no test, as P says so.
Causes find_wide_angle(const Findings& findings);
/// NIS whose law speaks. Names outliers where more than ten times as many lie beyond the 99.99 % quantile as
/// chance puts there (binomial), the body of the law fits better than that of a wrong factor would, lag 1 is
/// small beside what they add to NIS, and they are not those of one step, nor the start: gathered in the
/// first fifth (binomial) while NIS is right later.
Causes find_outliers(const Findings& findings);
/// Runs whose mean squares agree with P. Names heavy_tails by their test, if no outliers do.
Causes find_heavy_tails(const Findings& findings);
/// NIS of one dimension. Names gated_innovations by an empty end of the law, and a fit of the rest; or, of
/// NIS that is too small, by an end that even a law scaled to its mean has not.
Causes find_gate(const Findings& findings);
Causes find_perhaps_gate(const Findings& findings);
/// Names claimed_sigma where P is too small at some σ and too large at another (calibration.h), and the
/// interval of the factor on the whole P holds 1.
Causes find_wrong_by_claimed_sigma(const Findings& findings);
/// Rows whose NEES is known one by one. Names truth where NEES is too large while the innovations fit, and a
/// third of its variance is new in every row (white_errors.h): what no innovation shows, no filter forgets
/// from one row to the next.
Causes find_error_of_truth(const Findings& findings);
/// NEES of 100 values at least, whose innovations fit, and whose mean is more than twice its dof n. Names
/// bias where its variance is nearer 4 · mean − 2n, as of errors that P claims about a constant offset (χ²
/// that is not central), than that of a factor and that of χ² of as many dof, by twice on a logarithmic
/// scale.
Causes find_constant_offset(const Findings& findings);
/// Names wrong_dof where NEES alone is inconsistent, up to twice its dof, and its variance is nearer twice
/// its mean, as of χ², than twice its mean squared over n, as of a factor, by twice on a logarithmic scale.
/// At least 100 values.
Causes find_wrong_dof(const Findings& findings);
/// Names inflation where the filter is known to inflate P and NEES or NIS is too small: nothing to be tested.
Causes find_inflation(const Findings& findings);
/// NEES, or else NIS. Names covariance_at_steps where it is inconsistent by few steps, and its mean over all
/// is within chance and 15 % of what is expected, as no truth, linearisation or scale leaves it.
Causes find_wrong_single_steps(const Findings& findings);
/// Where NEES or NIS is inconsistent, and no other rule has named anything. Names covariance_scale.
Causes find_scale(const Findings& findings);

// Correlations between states and between sensors (cause_rules_correlation.cpp).

/// Two sensors of one step whose correlation speaks. Names sequential_sensors where no noise makes it that is
/// wrong in one direction (opposed_moments.h), and the lags do not tell a gain that is too small, as two
/// noises make it.
Causes find_sequential_sensors(const Findings& findings);
/// Ten runs of a joint P of at most twelve states, some of which it claims to be uncorrelated at every step.
/// Names cross_covariance where their errors are correlated (Student's t over the runs, Bonferroni over the
/// pairs), by 0.05 at least, and beside it a wrong pair, first where that is correlated nearly as much: R
/// lacks it, as P is a part of S alone. Wrong noise, a wrong start and linearisation leave the correlations
/// of the model.
Causes find_dropped_cross_covariance(const Findings& findings);
/// Names cross_covariance where the joint NEES is inconsistent and that of no block is, nor by its mean.
Causes find_joint_inconsistency(const Findings& findings);

// What goes on in time (cause_rules_time.cpp).

/// Estimates beside the errors of ten runs that move differently, or of fewer whose motion varies. Names
/// late_measurements where the errors point back along the way (lateness.h), by 0.3 steps at least and by
/// what explains most of the excess of NEES, while the innovations are nearly of the right size and white;
/// and truth_behind where those of ten runs point ahead, likewise.
Causes find_late_measurements(const Findings& findings);
/// Means of innovations and of errors that speak. Names bias where that is part of what is wrong, of a
/// nonlinear filter most of it; and where the errors at single steps have means (Hotelling over the runs)
/// that make most of the excess of NEES there, and not in the first fifth alone. Beside it the noise, by the
/// innovations less their mean.
Causes find_bias(const Findings& findings);
/// Whiteness that speaks. Names coloured_noise where lag 1 is at least 0.1 and more than a wrong gain makes
/// of the size of NIS: such a gain is wrong beside it. Of NIS that is too small, also where lag 1 is more
/// than an R that is too large leaves of a random walk and the errors are too large, as no such R makes them;
/// where they do not tell, or are not known, both are named.
Causes find_coloured_noise(const Findings& findings);

// One step (cause_rules_step.cpp).

/// NEES is right until a step that is too large, by more than any P0 leaves of itself: over the mean of each
/// step before F of as many dof as runs; or three times each, where NIS, which is white, there is over that
/// of all before F of their dof; Bonferroni over the steps so far. It has most of the largest excess, and
/// fades without rising by half as much again (of a nonlinear filter as much). Names one_step, and beside it
/// a noise that NIS of the other steps shows (χ²), or a bias where NEES stays too large. By NIS likewise,
/// after the first fifth, as P0 shows later in it, where NEES is not known or not wrong. Not of a linear
/// filter whose innovations fit and whose next errors do: an error of the truth.
Causes find_wrong_step(const Findings& findings);
/// Whether there is such a step, and half of the gross outliers lie there, or until it has faded.
bool outliers_are_of_one_step(const Findings& findings);

// The start (cause_rules_start.cpp). P = P_P0 + P_Q + P_R by what made it, and so are the true second
// moments, each part times the factor by which its noise is wrong. The share of P0, tr P⁻¹ P_P0 / n, never
// grows, in predictions or in corrections: what a wrong P0 does is there at the first step, and is most
// there.

/// Two steps or more before the first innovation, whose NEES has a step outside its simultaneous bounds. P0
/// and Q alone make the errors there. Names Q, which stays in NEES, or P0, which NIS forgets first; else
/// both. Of a nonlinear filter the start where NEES varies more than a Gaussian error's, and linearisation
/// beside a Q where NEES grows on the way.
Causes find_wrong_before_innovations(const Findings& findings);
/// The first innovation is wrong (χ²) where R alone may be, and NIS stays so: NEES fits before it; or R is
/// most of S and the size is one that no P makes, or one only that is wrong by ten; or, of an R that is not
/// known, NEES fits just after it. Names R, where the errors between innovations do not tell Q.
Causes find_wrong_first_innovation(const Findings& findings);
/// NIS of a first stretch of up to six tenths of the steps is wrong (χ², Bonferroni over its end, which is
/// where two levels fit best), of a nonlinear filter too small, and it and NEES hardly are later; the excess
/// of both is in the second half of it three quarters of that in the first or more, where P0 is forgotten.
/// Without errors only of a tenth of the steps or more, whose first quarter has half of the excess. Names
/// either noise.
Causes find_wrong_first_stretch(const Findings& findings);
/// The first NIS or NEES is wrong (χ²), NIS of the second half is not, and NEES is most wrong at the first
/// step, by its standard error. Names initial_covariance; here and below, where the first innovations are too
/// large and have a mean (Hotelling over the runs), initial_covariance_or_nonlinear_start.
Causes find_wrong_first_step(const Findings& findings);
/// The first fifth fails, at a step or in its sum of NIS, and its excess is all but gone in the second half.
/// Names initial_covariance; of a nonlinear filter whose NEES before the first innovation fits the
/// linearisation there, where the first innovation alone fits either of the two.
Causes find_start_that_dies_out(const Findings& findings);
/// Mixed: one direction rejects in the first fifth only and the other one later. Names the start, and beside
/// it the noise.
Causes find_start_beside_the_rest(const Findings& findings);

// Levels of noise (cause_rules_noise.cpp). Mean NIS has the sign of a q + b r, and the correlation of the
// innovations at every lag is (q − r) times one matrix: the two tell Q from R.

/// Innovations of several components whose test speaks, of which one is larger than S says and another
/// smaller, by 1.2 at least beyond their intervals, which no noise makes that is wrong in one direction.
/// Names measurement_noise_of_components where their lags tell R, or do not tell Q and S is mostly R; either
/// noise where neither is told.
Causes find_opposed_components(const Findings& findings);
/// Innovations of several components whose test speaks, and of which the most wrong one is wrong otherwise
/// than the others, beyond both intervals and by 1.5 at least (by less it is said beside a noise that is
/// named); not where the lags tell Q. Names innovation_unit where the factor is that of one; else R, of that
/// component, where the lags tell it, or S is mostly R and NIS is wrong by half as much as the components
/// are; else either noise.
Causes find_wrong_component(const Findings& findings);
/// Two components of an innovation are each as large as S says, and their sum and difference are not (the
/// test of pairs speaks, that of components does not), by factors 1.1 apart at least. Names
/// innovation_correlation.
Causes find_wrong_pair(const Findings& findings);
/// Of several sensors the NIS of one alone is wrong, and its lags tell no gain. Names R where S of it is
/// mostly R, else Q or R.
Causes find_wrong_sensor(const Findings& findings);
/// NIS of the second half is wrong (χ²). Names Q or R by its sign and that of the lags; else by what the
/// errors do between innovations (noise_between_innovations); else R, where S is
/// mostly R and the innovations are whiter than a wrong Q leaves them; else either of the two.
Causes find_wrong_noise(const Findings& findings);
/// The same with the sign of NEES, where NIS is of the right size, or not beyond it in the other direction,
/// and the gain is told by the lags.
Causes find_noise_by_errors(const Findings& findings);
/// NEES alone is wrong, of a nonlinear filter too small, and the more so the longer (Student's t over the
/// runs), up to the last tenth of the steps, which P0 never makes. Names Q where an R that is wrong by as
/// much would show in NIS (R known, five standard errors), or the errors between innovations tell it, else
/// either.
Causes find_noise_by_growth(const Findings& findings);
/// Whiteness that speaks, and no other rule has named anything. Names Q or R by the gain that the lags tell:
/// a mean NIS that is right says that S is, and not that Q and R are.
Causes find_wrong_gain(const Findings& findings);
/// The noise beside a bias: of the innovations less their mean, whose mean square is wrong by 5 % and by five
/// standard errors.
Causes find_noise_beside_bias(const Findings& findings);

// Linearisation (cause_rules_linearisation.cpp).

/// A nonlinear filter whose NEES is too large while its innovations fit. Jacobians at changing estimates make
/// directions seem observable that are not: P shrinks there, which no innovation can show (theory, section 5,
/// rank O at the estimates). Names the linearisation, of a single run or a bias; Q or the linearisation where
/// the innovations are too large as well, by less than a tenth of what NEES is, where NEES grows over the
/// steps without an innovation and not over the others (Student's t over the runs), or where the lags tell a
/// gain that is too small.
Causes find_linearisation(const Findings& findings);

}  // namespace credence::internal
