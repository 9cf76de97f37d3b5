#pragma once

#include <vector>

/// @file
/// Errors that come and go from one row to the next, as no filter makes them that corrects by little.

namespace credence::internal {

/// The share of the variance of NEES that is white. Errors of a filter fade, and so does the covariance of
/// their NEES: C_h = c a^h over a few rows. Noise of the truth, or of its time, is new in every row, and adds
/// to C_0 alone: with A the mean of C_1 and C_2 and B that of C_3 and C_4, a² = B/A, the share is
/// 1 − A a^{−3/2}/C_0. Values beyond their 0.9 quantile count as that, as the errors of a tenth of the rows
/// are no noise of every row.
///
/// nees: of each run, NEES over its dof at every row; rows that are not finite are left out. 0 where C_h
/// fades by half or more over two rows, which errors of a large gain do, or is not two standard errors of
/// white values from 0, or fewer than 500 pairs of rows tell it.
double white_share_of(const std::vector<std::vector<double>>& nees);

}  // namespace credence::internal
