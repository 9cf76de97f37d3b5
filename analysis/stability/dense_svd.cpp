#include "analysis/stability/dense_svd.h"

#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

unsigned eigen_options(SvdVectors vectors) {
  switch (vectors) {
    case SvdVectors::left: return Eigen::ComputeThinU;
    case SvdVectors::right: return Eigen::ComputeThinV;
    case SvdVectors::full_left: return Eigen::ComputeFullU;
    case SvdVectors::full_right: return Eigen::ComputeFullV;
    case SvdVectors::none: break;
  }
  return 0;
}

}  // namespace

DenseSvd dense_svd(MatrixRef M, SvdVectors vectors) {
  DenseSvd result;
  if (M.size() == 0) {
    const bool full_left = vectors == SvdVectors::full_left, full_right = vectors == SvdVectors::full_right;
    result.U = Matrix::Identity(M.rows(), full_left ? M.rows() : 0);
    result.V = Matrix::Identity(M.cols(), full_right ? M.cols() : 0);
    return result;
  }
  const Eigen::BDCSVD<Matrix> svd(M, eigen_options(vectors));
  result.s = svd.singularValues();
  if (svd.computeU()) result.U = svd.matrixU();
  if (svd.computeV()) result.V = svd.matrixV();
  return result;
}

}  // namespace credence::internal
