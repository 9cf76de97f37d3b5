#include "montecarlo/worlds/monobot/plain_monobot.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

namespace credence::internal {
namespace {

template <int kLandmarks>
void run_plain(std::int64_t runs, std::mt19937_64& generator, std::span<Moments> nees,
               std::span<Moments> nis) {
  constexpr int n = kLandmarks + 1, m = kLandmarks;
  using State = Eigen::Matrix<double, n, 1>;
  using Covariance = Eigen::Matrix<double, n, n>;
  using Measurement = Eigen::Matrix<double, m, 1>;
  const double q = 0.1, r = 0.1;
  Eigen::Matrix<double, m, n> H = Eigen::Matrix<double, m, n>::Zero();
  H.col(0).setConstant(-1.0);
  H.template rightCols<m>().setIdentity();
  const Eigen::Matrix<double, m, m> R = r * Eigen::Matrix<double, m, m>::Identity();
  std::normal_distribution<double> normal;
  for (std::int64_t run = 0; run < runs; ++run) {
    State x = State::Ones(), estimate = x;
    x[0] = -1.0;
    for (int i = 0; i < n; ++i) estimate[i] = x[i] - normal(generator);
    Covariance P = Covariance::Identity();
    for (std::size_t k = 0; k < nees.size(); ++k) {
      x[0] += std::sqrt(q) * normal(generator);
      Measurement z = H * x;
      for (int i = 0; i < m; ++i) z[i] += std::sqrt(r) * normal(generator);
      P(0, 0) += q;
      const Measurement nu = z - H * estimate;
      const Eigen::Matrix<double, m, m> S = H * P * H.transpose() + R;
      const Eigen::LLT<Eigen::Matrix<double, m, m>> llt(S);
      const Eigen::Matrix<double, n, m> K = llt.solve(H * P).transpose();
      estimate += K * nu;
      const Covariance A = Covariance::Identity() - K * H;
      P = A * P * A.transpose() + K * R * K.transpose();
      const State e = x - estimate;
      nees[k].add(e.dot(P.llt().solve(e)));
      nis[k].add(nu.dot(llt.solve(nu)));
    }
  }
}

}  // namespace

void run_plain_monobot(Index landmarks, std::int64_t runs, std::mt19937_64& generator,
                       std::span<Moments> nees, std::span<Moments> nis) {
  if (nees.size() != nis.size()) {
    throw std::invalid_argument(fmt::format("{} steps of NEES, but {} of NIS", nees.size(), nis.size()));
  }
  switch (landmarks) {
    case 1: return run_plain<1>(runs, generator, nees, nis);
    case 2: return run_plain<2>(runs, generator, nees, nis);
    case 5: return run_plain<5>(runs, generator, nees, nis);
    default: throw std::invalid_argument(fmt::format("landmarks = {}: 1, 2 or 5", landmarks));
  }
}

}  // namespace credence::internal
