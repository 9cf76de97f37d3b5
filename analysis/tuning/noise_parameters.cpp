#include "analysis/tuning/noise_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "core/enum_words.h"
#include "core/linear_algebra/cholesky.h"

namespace credence::internal {
namespace {

/// The member of that name, of a model or of a derivative.
template <class Noise>
Matrix Noise::*member(NoiseMatrix which) {
  switch (which) {
    case NoiseMatrix::Q: return &Noise::Q;
    case NoiseMatrix::R: return &Noise::R;
    case NoiseMatrix::P0: break;
  }
  return &Noise::P0;
}

template <class Noise>
auto& matrix_of(Noise& noise, NoiseMatrix which) {
  return noise.*member<std::remove_const_t<Noise>>(which);
}

FreeNoise parse_one(std::string_view word) {
  FreeNoise noise;
  std::string_view matrix = word;
  for (const auto& [prefix, form] :
       {std::pair{"diag(", NoiseForm::diagonal}, std::pair{"full(", NoiseForm::full}}) {
    if (!word.starts_with(prefix) || !word.ends_with(')')) continue;
    noise.form = form;
    matrix = word.substr(5, word.size() - 6);
  }
  for (const NoiseMatrix which : {NoiseMatrix::Q, NoiseMatrix::R, NoiseMatrix::P0}) {
    if (matrix != to_string(which)) continue;
    noise.matrix = which;
    return noise;
  }
  throw std::invalid_argument(
      fmt::format("\"{}\" is nothing to tune: accepted are Q, R and P0 for a factor, diag(Q) for every "
                  "variance and full(Q) for every element",
                  word));
}

std::string element_name(NoiseMatrix matrix, Index row, Index column) {
  return fmt::format("{}[{},{}]", to_string(matrix), row + 1, column + 1);
}

}  // namespace

std::string_view to_string(NoiseMatrix matrix) { return word_of(matrix, {"Q", "R", "P0"}); }

std::vector<FreeNoise> parse_free_noise(std::string_view text) {
  std::vector<FreeNoise> free;
  while (true) {
    const std::size_t comma = text.find(',');
    std::string_view word = text.substr(0, comma);
    while (word.starts_with(' ')) word.remove_prefix(1);
    while (word.ends_with(' ')) word.remove_suffix(1);
    const FreeNoise noise = parse_one(word);
    if (std::ranges::find(free, noise.matrix, &FreeNoise::matrix) != free.end()) {
      throw std::invalid_argument(fmt::format("{} is named twice", to_string(noise.matrix)));
    }
    free.push_back(noise);
    if (comma == std::string_view::npos) return free;
    text.remove_prefix(comma + 1);
  }
}

NoiseParameters::NoiseParameters(LinearModel start, std::vector<FreeNoise> free)
    : model_(std::move(start)), free_(std::move(free)) {
  std::vector<double> phi;
  for (const FreeNoise& noise : free_) {
    const Matrix& A = matrix_of(model_, noise.matrix);
    const std::string_view name = to_string(noise.matrix);
    if (noise.form == NoiseForm::factor) {
      if (A.isZero(0.0)) throw std::invalid_argument(fmt::format("{} is 0: no factor changes it", name));
      coordinates_.push_back({noise});
      phi.push_back(0.0);
      continue;
    }
    const Index n = A.rows();
    const bool diagonal = noise.form == NoiseForm::diagonal;
    if (diagonal && !A.isDiagonal(0.0)) {
      throw std::invalid_argument(
          fmt::format("{} is not diagonal: full({}) has its covariances", name, name));
    }
    const Eigen::LLT<Matrix> llt(A);
    if (llt.info() != Eigen::Success || !(A.diagonal().array() > 0.0).all()) {
      throw std::invalid_argument(fmt::format(
          "{} is not positive definite: where a variance is 0 there is nothing to begin with", name));
    }
    const Matrix L = llt.matrixL();
    for (Index j = 0; j < n; ++j) {
      for (Index i = j; i < (diagonal ? j + 1 : n); ++i) {
        const double scale = std::sqrt(A(i, i));
        coordinates_.push_back({noise, i, j, scale});
        phi.push_back(diagonal ? 0.0 : i == j ? std::log(L(j, j)) : L(i, j) / scale);
      }
    }
  }
  start_ = Eigen::Map<const Vector>(phi.data(), std::ssize(phi));
}

std::vector<std::string> NoiseParameters::names() const {
  std::vector<std::string> names;
  for (const Coordinate& c : coordinates_) {
    if (c.row < 0) {
      names.emplace_back(to_string(c.of.matrix));
    } else {
      names.push_back((c.of.form == NoiseForm::full ? "L_" : "") +
                      element_name(c.of.matrix, c.row, c.column));
    }
  }
  return names;
}

Matrix NoiseParameters::root(NoiseMatrix matrix, const Vector& phi) const {
  const Index n = matrix_of(model_, matrix).rows();
  Matrix L = Matrix::Zero(n, n);
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const Coordinate& c = coordinates_[i];
    if (c.of.matrix != matrix) continue;
    const double value = phi[static_cast<Index>(i)];
    L(c.row, c.column) = c.row == c.column ? std::exp(value) : c.scale * value;
  }
  return L;
}

LinearModel NoiseParameters::at(const Vector& phi) const {
  LinearModel model = model_;
  for (const FreeNoise& noise : free_) {
    if (noise.form != NoiseForm::full) continue;
    const Matrix L = root(noise.matrix, phi);
    matrix_of(model, noise.matrix) = L * L.transpose();
  }
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const Coordinate& c = coordinates_[i];
    const double factor = std::exp(phi[static_cast<Index>(i)]);
    if (c.of.form == NoiseForm::factor) matrix_of(model, c.of.matrix) *= factor;
    if (c.of.form == NoiseForm::diagonal) matrix_of(model, c.of.matrix)(c.row, c.row) *= factor;
  }
  return model;
}

std::vector<NoiseDerivative> NoiseParameters::derivatives(const Vector& phi) const {
  const LinearModel model = at(phi);
  std::vector<NoiseDerivative> derivatives(coordinates_.size());
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const Coordinate& c = coordinates_[i];
    const Matrix& A = matrix_of(model, c.of.matrix);
    Matrix& D = matrix_of(derivatives[i], c.of.matrix);
    if (c.of.form == NoiseForm::factor) {
      D = A;
    } else if (c.of.form == NoiseForm::diagonal) {
      D = Matrix::Zero(A.rows(), A.cols());
      D(c.row, c.row) = A(c.row, c.row);
    } else {
      const Matrix L = root(c.of.matrix, phi);
      Matrix dL = Matrix::Zero(A.rows(), A.cols());
      dL(c.row, c.column) = c.row == c.column ? L(c.row, c.row) : c.scale;
      D = dL * L.transpose() + L * dL.transpose();
    }
  }
  return derivatives;
}

Index NoiseParameters::place_of(const Coordinate& coordinate) const {
  return std::ranges::find(free_, coordinate.of) - free_.begin();
}

Vector NoiseParameters::scaled(const Vector& phi, const Vector& t) const {
  Vector scaled = phi;
  for (Index i = 0; i < size(); ++i) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(i)];
    const double of_it = t[place_of(c)];
    if (c.of.form != NoiseForm::full) {
      scaled[i] += of_it;
    } else if (c.row == c.column) {
      scaled[i] += 0.5 * of_it;
    } else {
      scaled[i] *= std::exp(0.5 * of_it);
    }
  }
  return scaled;
}

Matrix NoiseParameters::scale_directions(const Vector& phi) const {
  Matrix directions = Matrix::Zero(size(), std::ssize(free_));
  for (Index i = 0; i < size(); ++i) {
    const Coordinate& c = coordinates_[static_cast<std::size_t>(i)];
    directions(i, place_of(c)) = c.of.form != NoiseForm::full ? 1.0 : c.row == c.column ? 0.5 : 0.5 * phi[i];
  }
  return directions;
}

std::vector<NoiseValue> NoiseParameters::values(const Vector& phi) const {
  const LinearModel model = at(phi);
  std::vector<NoiseDerivative> derivatives = this->derivatives(phi);
  std::vector<NoiseValue> values;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const Coordinate& c = coordinates_[i];
    NoiseValue& v = values.emplace_back();
    v.gradient = Vector::Zero(size());
    if (c.of.form == NoiseForm::factor) {
      v.name = to_string(c.of.matrix);
      v.value = std::exp(phi[static_cast<Index>(i)]);
      v.gradient[static_cast<Index>(i)] = v.value;
      continue;
    }
    v.name = element_name(c.of.matrix, c.row, c.column);
    v.value = matrix_of(model, c.of.matrix)(c.row, c.column);
    v.positive = c.row == c.column;
    for (std::size_t j = 0; j < coordinates_.size(); ++j) {
      if (coordinates_[j].of.matrix != c.of.matrix) continue;
      v.gradient[static_cast<Index>(j)] = matrix_of(derivatives[j], c.of.matrix)(c.row, c.column);
    }
  }
  return values;
}

}  // namespace credence::internal
