#include "core/models/model_mismatch.h"

#include <algorithm>

namespace credence::internal {

bool knows_dynamics(const LinearModel& truth, const LinearModel& assumed) {
  return truth.F == assumed.F && truth.H == assumed.H;
}

bool knows_dynamics(std::span<const LinearModel> truth, std::span<const LinearModel> assumed) {
  return std::ranges::equal(truth, assumed,
                            [](const LinearModel& a, const LinearModel& b) { return knows_dynamics(a, b); });
}

namespace {

LinearModel error_and_state_model(const LinearModel& truth, const LinearModel& assumed) {
  const Index n = truth.state_dim(), m = truth.measurement_dim(), q = truth.G.cols();
  LinearModel model = truth;
  model.F = Matrix::Zero(2 * n, 2 * n);
  model.F << assumed.F, truth.F - assumed.F, Matrix::Zero(n, n), truth.F;
  model.G = Matrix(2 * n, q);
  model.G << truth.G, truth.G;
  model.H = Matrix(m, 2 * n);
  model.H << assumed.H, truth.H - assumed.H;
  model.P0 = truth.P0.replicate(2, 2);
  return model;
}

}  // namespace

std::vector<LinearModel> error_models(std::span<const LinearModel> truth,
                                      std::span<const LinearModel> assumed) {
  std::vector<LinearModel> models(truth.begin(), truth.end());
  if (knows_dynamics(truth, assumed)) return models;
  std::ranges::transform(truth, assumed, models.begin(), error_and_state_model);
  return models;
}

Matrix padded(const Matrix& matrix, Index rows, Index columns) {
  Matrix result = Matrix::Zero(rows, columns);
  result.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
  return result;
}

}  // namespace credence::internal
