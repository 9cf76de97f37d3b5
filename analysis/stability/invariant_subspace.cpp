#include "analysis/stability/invariant_subspace.h"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/stability/dense_svd.h"
#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::MatrixXcd;

constexpr double kOnCircle = 1e-8;  // of |λ| from 1
constexpr int kLargestChain = 6;
constexpr double kSameEigenvalue = 1e-4;  // rounding scatters those of a Jordan chain

UnitCircle place(double modulus) {
  if (std::abs(modulus - 1.0) <= kOnCircle) return UnitCircle::on;
  return modulus < 1.0 ? UnitCircle::inside : UnitCircle::outside;
}

/// How far rounding scatters the eigenvalue of a Jordan block of this size.
double jordan_scatter(int size) {
  return 10.0 * std::pow(std::numeric_limits<double>::epsilon(), 1.0 / static_cast<double>(size));
}

bool is_marginal_chain(const Eigen::VectorXcd& eigenvalues, Index i) {
  std::vector<Complex> nearest(eigenvalues.begin(), eigenvalues.end());
  const Complex centre = eigenvalues[i];
  std::ranges::sort(nearest,
                    [centre](Complex a, Complex b) { return std::abs(a - centre) < std::abs(b - centre); });
  Complex sum = nearest[0];
  for (int size = 2; size <= kLargestChain && size <= static_cast<int>(nearest.size()); ++size) {
    sum += nearest[static_cast<std::size_t>(size - 1)];
    const Complex mean = sum / static_cast<double>(size);
    double radius = 0.0;
    for (int j = 0; j < size; ++j)
      radius = std::max(radius, std::abs(nearest[static_cast<std::size_t>(j)] - mean));
    if (radius <= jordan_scatter(size) && std::abs(std::abs(mean) - 1.0) <= kOnCircle) return true;
  }
  return false;
}

/// Exchanges the neighbours k and k+1 on the diagonal of the triangular T, F = U T Uᴴ.
void exchange(ComplexMatrix& T, ComplexMatrix& U, Index k) {
  const Index n = T.rows();
  Eigen::JacobiRotation<Complex> rotation;
  rotation.makeGivens(T(k, k + 1), T(k + 1, k + 1) - T(k, k));
  T.rightCols(n - k).applyOnTheLeft(k, k + 1, rotation.adjoint());
  T.topRows(k + 2).applyOnTheRight(k, k + 1, rotation);
  U.applyOnTheRight(k, k + 1, rotation);
  T(k + 1, k) = 0.0;
}

/// Real orthonormal basis, of known dimension, of the span of complex columns that is closed under
/// conjugation.
Matrix real_basis(const ComplexMatrix& columns, Index dimension) {
  Matrix both(columns.rows(), 2 * columns.cols());
  both << columns.real(), columns.imag();
  return dense_svd(both, SvdVectors::left).U.leftCols(dimension);
}

/// Removes the eigenvalues within kSameEigenvalue of the last one, and returns their mean.
Complex take_cluster(std::vector<Complex>& values) {
  const Complex last = values.back();
  const auto cluster = std::partition(values.begin(), values.end(), [last](Complex value) {
    return std::abs(value - last) > kSameEigenvalue;
  });
  Complex sum = 0.0;
  for (auto it = cluster; it != values.end(); ++it) sum += *it;
  const Complex mean = sum / static_cast<double>(values.end() - cluster);
  values.erase(cluster, values.end());
  return mean;
}

/// Orthonormal real basis of the eigenvectors of μ and its conjugate: the kernel of their real polynomial.
Matrix eigenvectors_at(MatrixRef Lambda, Complex mu) {
  const Matrix I = Matrix::Identity(Lambda.rows(), Lambda.cols());
  const bool is_real = std::abs(mu.imag()) <= kSameEigenvalue;
  const Matrix polynomial = is_real ? Matrix(Lambda - mu.real() * I)
                                    : Matrix(Lambda * Lambda - 2.0 * mu.real() * Lambda + std::norm(mu) * I);
  const DenseSvd svd = dense_svd(polynomial, SvdVectors::full_right);
  const Index nullity = (svd.s.array() <= 1e-8 * std::max(1.0, Lambda.norm())).count();
  return svd.V.rightCols(nullity);
}

}  // namespace

std::vector<UnitCircle> classify_unit_circle(const Eigen::VectorXcd& eigenvalues) {
  std::vector<UnitCircle> where;
  where.reserve(static_cast<std::size_t>(eigenvalues.size()));
  for (Index i = 0; i < eigenvalues.size(); ++i) {
    const double modulus = std::abs(eigenvalues[i]);
    UnitCircle here = place(modulus);
    const bool near = std::abs(modulus - 1.0) <= jordan_scatter(kLargestChain);
    if (here != UnitCircle::on && near && is_marginal_chain(eigenvalues, i)) here = UnitCircle::on;
    where.push_back(here);
  }
  return where;
}

InvariantSubspaces::InvariantSubspaces(MatrixRef F) {
  if (F.rows() == 0) {
    ok_ = true;
    return;
  }
  const Eigen::ComplexSchur<ComplexMatrix> schur(ComplexMatrix(F.cast<Complex>()));
  ok_ = schur.info() == Eigen::Success;
  if (!ok_) return;
  T_ = schur.matrixT().triangularView<Eigen::Upper>();
  U_ = schur.matrixU();
  eigenvalues_ = T_.diagonal();
  where_ = classify_unit_circle(eigenvalues_);
}

Index InvariantSubspaces::count(UnitCircle where) const {
  return static_cast<Index>(std::ranges::count(where_, where));
}

Matrix InvariantSubspaces::basis(UnitCircle where) const { return basis(where, where); }

Matrix InvariantSubspaces::basis(UnitCircle where, UnitCircle or_where) const {
  std::vector<bool> selected;
  selected.reserve(where_.size());
  for (const UnitCircle here : where_) selected.push_back(here == where || here == or_where);
  return basis_of(selected);
}

Matrix InvariantSubspaces::basis_of(const std::vector<bool>& selected) const {
  const Index n = T_.rows();
  const Index count = static_cast<Index>(std::ranges::count(selected, true));
  if (count == n) return Matrix::Identity(n, n);
  if (count == 0) return Matrix(n, 0);
  ComplexMatrix T = T_, U = U_;
  Index front = 0;
  for (Index i = 0; i < n; ++i) {
    if (!selected[static_cast<std::size_t>(i)]) continue;
    for (Index k = i; k > front; --k) exchange(T, U, k - 1);
    ++front;
  }
  return real_basis(U.leftCols(count), count);
}

Matrix power_bounded_part(MatrixRef Lambda) {
  const Index q = Lambda.rows();
  if (q == 0) return Matrix(0, 0);
  const Eigen::EigenSolver<Matrix> eigen(Matrix(Lambda), false);
  if (eigen.info() != Eigen::Success) return Matrix(q, 0);
  std::vector<Complex> values;
  for (const Complex value : eigen.eigenvalues()) {
    if (value.imag() >= 0.0) values.push_back(value);
  }
  Matrix vectors(q, 0);
  while (!values.empty()) {
    const Matrix null = eigenvectors_at(Lambda, take_cluster(values));
    vectors.conservativeResize(Eigen::NoChange, vectors.cols() + null.cols());
    vectors.rightCols(null.cols()) = null;
  }
  // Eigenvectors of different eigenvalues are independent, so their number is the dimension.
  return dense_svd(vectors, SvdVectors::left).U.leftCols(std::min(q, vectors.cols()));
}

}  // namespace credence::internal
