// A world and a filter of your own types: a target on a line at constant velocity, and a filter with a gain
// that somebody chose. It reports the covariance of the optimal gain. Can that be trusted?
#include <iostream>

#include "credence/credence.h"

using credence::Index, credence::Matrix, credence::Vector;

struct Target {
  struct Prior {
    Vector mean;
    Matrix covariance;
  };
  Prior prior() const { return {Vector::Zero(2), Matrix::Identity(2, 2)}; }
  Vector initial(auto& noise) const { return noise.normals(2); }
  Vector step(const Vector& x, Index, auto& noise) const {
    return Vector{{x[0] + x[1], x[1] + 0.1 * noise.normal()}};
  }
  Vector measure(const Vector& x, Index, auto& noise) const { return Vector{{x[0] + noise.normal()}}; }
  Vector minus(const Vector& a, const Vector& b) const { return a - b; }
};

class AlphaBetaFilter {
 public:
  void reset(const Vector& mean, const Matrix& P) {
    x_ = mean;
    P_ = P;
  }
  void predict() {
    const Matrix F{{1.0, 1.0}, {0.0, 1.0}};
    x_ = F * x_;
    P_ = F * P_ * F.transpose() + Matrix{{0.0, 0.0}, {0.0, 0.01}};
  }
  bool update(const Vector& z) {
    x_ += Vector{{0.6, 0.2}} * (z[0] - x_[0]);
    const Vector PHt = P_.col(0);
    P_ -= PHt * PHt.transpose() / (PHt[0] + 1.0);  // right for the gain P Hᵀ S⁻¹, which this filter has not
    return true;
  }
  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }

 private:
  Vector x_;
  Matrix P_;
};

int main() {
  const auto judged =
      credence::judge_filter(Target{}, [] { return AlphaBetaFilter{}; }, {.runs = 500, .steps = 100});
  std::cout << judged.text();
  judged.write_report("out");
  return judged.verdict() == credence::Verdict::consistent ? 0 : 1;
}
