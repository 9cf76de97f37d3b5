#include "analysis/laws/correlation/fourier.h"

#include <unsupported/Eigen/FFT>

namespace credence::internal {

std::size_t quick_length(std::size_t n) {
  for (;; --n) {
    std::size_t rest = n;
    for (const std::size_t factor : {std::size_t{2}, std::size_t{3}, std::size_t{5}}) {
      while (rest > 1 && rest % factor == 0) rest /= factor;
    }
    if (rest <= 1) return n;
  }
}

std::vector<std::complex<double>> fourier(std::span<const double> u) {
  Eigen::FFT<double> transform;
  const std::vector<double> values(u.begin(), u.end());
  std::vector<std::complex<double>> waves;
  transform.fwd(waves, values);
  return waves;
}

std::vector<double> periodogram(std::span<const double> u) {
  const std::vector<std::complex<double>> waves = fourier(u);
  std::vector<double> powers;
  for (std::size_t j = 1; 2 * j < u.size(); ++j) powers.push_back(std::norm(waves[j]));
  return powers;
}

}  // namespace credence::internal
