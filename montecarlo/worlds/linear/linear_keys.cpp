#include "montecarlo/worlds/linear/linear_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "core/append_item.h"
#include "core/control_characters.h"
#include "core/linear_algebra/decompositions.h"
#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/estimator_key.h"
#include "montecarlo/worlds/estimator_offers.h"
#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {
namespace {

std::string path_of(std::string_view section, std::string_view name) {
  return fmt::format("{}.{}", section, name);
}

constexpr std::string_view kPeriod = "world.period";

Index period_of(const Scenario& scenario) { return integer_value(scenario, kPeriod); }

/// Matrices of `rows` rows are written one above the other, one for each step of a period.
Matrix matrix_of(std::span<const std::vector<double>> rows) {
  Matrix matrix(std::ssize(rows), rows.empty() ? 0 : std::ssize(rows.front()));
  for (Index i = 0; i < matrix.rows(); ++i) {
    for (Index j = 0; j < matrix.cols(); ++j) {
      matrix(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  return matrix;
}

/// One matrix of a scenario, or those of a period, with what is said where it is refused.
class WrittenMatrix {
 public:
  WrittenMatrix(const Scenario& scenario, const Refusal& refuse, std::string_view section,
                std::string_view name)
      : refuse_(refuse),
        section_(section),
        name_(name),
        rows_(rows_value(scenario, path_of(section, name))),
        period_(period_of(scenario)) {}

  bool given() const { return !rows_.empty(); }
  Index rows() const { return std::ssize(rows_); }
  Index columns() const { return std::ssize(rows_.front()); }
  [[noreturn]] void wrong(const std::string& rule) const {
    refuse_.wrong(section_, name_, rule);
    throw ScenarioError(rule);  // not reached
  }

  /// `shape` in words ("m×2, as world.F is 2×2"); rows < 0: any number of them.
  void require_shape(Index rows, Index columns, const std::string& shape) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (std::ssize(rows_[i]) == columns && columns > 0) continue;
      wrong(fmt::format("must be {}; row {} has {}", shape, i + 1, counted(rows_[i].size(), "number")));
    }
    if (rows < 0 || std::ssize(rows_) == rows || std::ssize(rows_) == period_ * rows) return;
    const std::string repeated =
        period_ == 1 ? "" : fmt::format(", or {} of them one above the other, as {} is", period_, kPeriod);
    wrong(fmt::format("must be {}{}; it has {}", shape, repeated, counted(rows_.size(), "row")));
  }

  /// A covariance of this dimension.
  void require_covariance(Index dim, const std::string& why) const {
    require_shape(dim, dim, fmt::format("{}×{}, as {}", dim, dim, why));
    for (Index first = 0; first < rows(); first += dim) require_covariance(first, dim);
  }

 private:
  static constexpr double kRounding = 1e-14;  // of decimal numbers, such as 1/3 in four rows

  /// Of the one whose first row this is.
  void require_covariance(Index first, Index dim) const {
    const Matrix A =
        matrix_of(std::span(rows_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(dim)));
    for (Index i = 0; i < dim; ++i) {
      for (Index j = 0; j < i; ++j) {
        if (A(i, j) == A(j, i)) continue;
        wrong(fmt::format("must be symmetric; row {}, column {} is {}, and row {}, column {} is {}",
                          first + i + 1, j + 1, A(i, j), first + j + 1, i + 1, A(j, i)));
      }
    }
    const Vector eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>(A).eigenvalues();
    const double least = eigenvalues.minCoeff();
    if (least < -kRounding * static_cast<double>(dim) * eigenvalues.cwiseAbs().maxCoeff()) {
      wrong(fmt::format("must be positive semidefinite; its least eigenvalue is {:.6g}", least));
    }
  }

  const Refusal& refuse_;
  std::string_view section_, name_;
  NumberRows rows_;
  Index period_;
};

std::string shape_of(std::string_view path, Index rows, Index columns) {
  return fmt::format("{} is {}×{}", path, rows, columns);
}

/// One of the matrices, of step `phase` of a period; `otherwise` where it is not given.
Matrix written_matrix(const Scenario& scenario, std::string_view section, std::string_view name, Index rows,
                      Index phase, const Matrix& otherwise) {
  const NumberRows written = rows_value(scenario, path_of(section, name));
  if (written.empty()) return otherwise;
  const auto first = static_cast<std::size_t>(std::ssize(written) == rows ? 0 : phase * rows);
  return matrix_of(std::span(written).subspan(first, static_cast<std::size_t>(rows)));
}

Index columns_of(const Scenario& scenario, std::string_view path, Index otherwise) {
  const NumberRows rows = rows_value(scenario, path);
  return rows.empty() ? otherwise : std::ssize(rows.front());
}

/// What there is of a model in one section; `world` where it is left out.
std::vector<LinearModel> models_of(const Scenario& scenario, std::string_view section,
                                   const std::vector<LinearModel>& world) {
  const Index n = columns_of(scenario, "world.F", 0), m = columns_of(scenario, "world.R", 0);
  const Index q = columns_of(scenario, path_of(section, "Q"), columns_of(scenario, "world.Q", n));
  std::vector<LinearModel> models(static_cast<std::size_t>(period_of(scenario)));
  for (std::size_t k = 0; k < models.size(); ++k) {
    LinearModel& model = models[k];
    if (!world.empty()) model = world[k];
    if (model.G.size() == 0) model.G = Matrix::Identity(n, n);
    const auto part = [&](std::string_view name, Index rows, const Matrix& otherwise) {
      return written_matrix(scenario, section, name, rows, static_cast<Index>(k), otherwise);
    };
    model.F = part("F", n, model.F);
    model.G = part("G", n, model.G);
    model.H = part("H", m, model.H);
    model.Q = part("Q", q, model.Q);
    model.R = part("R", m, model.R);
    model.P0 = part("P0", n, model.P0);
    model.layout = {.vehicle = n, .landmark = 0, .landmarks = 0};
  }
  return models;
}

/// Process noises, and why there are so many.
struct ProcessNoises {
  Index count;
  std::string why;
};

ProcessNoises check_noise_input(const WrittenMatrix& G, std::string_view section, Index n,
                                const ProcessNoises& otherwise) {
  if (!G.given()) return otherwise;
  const std::string path = path_of(section, "G");
  G.require_shape(n, G.columns(), fmt::format("{}×q, as {}", n, shape_of("world.F", n, n)));
  return {G.columns(), shape_of(path, n, G.columns())};
}

void check_world(const Scenario& scenario, const Refusal& refuse) {
  const auto written = [&](std::string_view name) { return WrittenMatrix(scenario, refuse, "world", name); };
  const WrittenMatrix F = written("F"), H = written("H"), R = written("R");
  const Index period = period_of(scenario);
  const Index n = period == 1 ? F.rows() : F.columns();
  F.require_shape(n, n, fmt::format("square; it has {}", counted(n, "row")));
  const std::string F_shape = shape_of("world.F", n, n);
  H.require_shape(-1, n, fmt::format("m×{}, as {}", n, F_shape));
  const Index m = period == 1 ? H.rows() : R.columns();
  if (period > 1) H.require_shape(m, n, fmt::format("{}×{}, as world.R has {} columns", m, n, m));
  const ProcessNoises noises =
      check_noise_input(written("G"), "world", n, {n, F_shape + " and world.G is not given"});
  written("Q").require_covariance(noises.count, noises.why);
  R.require_covariance(m, shape_of("world.H", m, n));
  written("P0").require_covariance(n, F_shape);
  if (written("P0").rows() != n) {
    refuse.wrong("world", "P0", fmt::format("must be {}×{}: it is that of the start alone", n, n));
  }
  const auto names = names_value(scenario, "world.states");
  if (!names.empty() && std::ssize(names) != n) {
    refuse.wrong("world", "states", fmt::format("must be {} names, as {}", n, F_shape));
  }
  if (std::ranges::any_of(names, has_control_character)) {
    refuse.wrong("world", "states", "a name holds a control character");
  }
}

void check_filter(const Scenario& scenario, const Refusal& refuse) {
  const LinearModel world = linear_truth(scenario).front();
  const Index n = world.state_dim(), m = world.measurement_dim();
  const auto written = [&](std::string_view name) { return WrittenMatrix(scenario, refuse, "filter", name); };
  const auto check = [&](std::string_view name, Index rows, Index columns, const std::string& why) {
    const WrittenMatrix matrix = written(name);
    if (matrix.given()) matrix.require_shape(rows, columns, fmt::format("{}×{}, as {}", rows, columns, why));
  };
  check("F", n, n, shape_of("world.F", n, n));
  check("H", m, n, shape_of("world.H", m, n));
  const Index q = world.G.cols();
  const ProcessNoises noises = check_noise_input(written("G"), "filter", n, {q, shape_of("world.Q", q, q)});
  const WrittenMatrix Q = written("Q"), R = written("R"), P0 = written("P0");
  if (Q.given()) Q.require_covariance(noises.count, noises.why);
  if (!Q.given() && noises.count != q) {
    refuse.wrong(
        "filter", "G",
        fmt::format("needs a filter.Q of {}×{}, since world.Q is {}×{}", noises.count, noises.count, q, q));
  }
  if (R.given()) R.require_covariance(m, shape_of("world.R", m, m));
  if (P0.given()) P0.require_covariance(n, shape_of("world.F", n, n));
  if (P0.given() && P0.rows() != n) {
    refuse.wrong("filter", "P0", fmt::format("must be {}×{}: it is that of the start alone", n, n));
  }
  const WrittenMatrix gain = written("gain");
  if (gain.given() && gain.rows() != n) {
    refuse.wrong("filter", "gain", fmt::format("must be {}×{}: it is the same at all steps", n, m));
  }
  check("gain", n, m, shape_of("world.H", m, n));
  const std::vector<std::string> states = linear_state_names(scenario);
  for (const std::string& name : names_value(scenario, "filter.considered")) {
    if (std::ranges::find(states, name) != states.end()) continue;
    refuse.wrong("filter", "considered", fmt::format("names no state \"{}\"", name));
  }
}

}  // namespace

std::vector<KeyRow> linear_keys() {
  const auto row = [](std::string_view section, std::string_view name, std::string_view meaning,
                      std::string_view default_words) {
    return KeyRow{.section = section,
                  .name = name,
                  .unit = "",
                  .meaning = meaning,
                  .field = RowsField{path_of(section, name)},
                  .default_words = default_words};
  };
  return {
      row("world", "F", "state transition of one step, n×n: x⁺ = F x + G v", "required"),
      row("world", "G", "input of the process noise, n×q", "identity"),
      row("world", "H", "measurement, m×n: z = H x + w", "required"),
      row("world", "Q", "covariance of the process noise v of one step, q×q; may be singular", "required"),
      row("world", "R", "covariance of the measurement noise w, m×m", "required"),
      row("world", "P0", "covariance of the state at the start, n×n, whose mean is 0; may be singular",
          "required"),
      {.section = "world",
       .name = "period",
       .unit = "",
       .meaning =
           "steps after which the matrices repeat themselves; each of F, G, H, Q, R, also in [filter], "
           "is one matrix, or as many one above the other as the period has steps",
       .field = own_integer(std::string(kPeriod), 1, 1, 10'000),
       .in_effect = [](const Scenario& s) { return period_of(s) > 1; }},
      {.section = "world",
       .name = "states",
       .unit = "",
       .meaning = "names of the states; those of one block have its name and a dot in front, \"position.x\"",
       .field = NamesField{"world.states"},
       .default_words = "x1, x2, …"},
      process_scale_key(),
      measurement_scale_key(),
      row("filter", "F", "state transition that the filter assumes", "world.F"),
      row("filter", "G", "input of the process noise that the filter assumes", "world.G"),
      row("filter", "H", "measurement that the filter assumes", "world.H"),
      row("filter", "Q", "covariance of the process noise that the filter assumes, before process_scale",
          "world.Q"),
      row("filter", "R",
          "covariance of the measurement noise that the filter assumes, before measurement_scale", "world.R"),
      row("filter", "P0", "covariance of the state at the start that the filter assumes", "world.P0"),
      estimator_key([](const Scenario& s) { return word_value(s, "filter.estimator") != "kalman"; }),
      row("filter", "gain", "gain K of \"own-gain\", n×m: x̂ = x̂⁻ + K ν", "none"),
      {.section = "filter",
       .name = "considered",
       .unit = "",
       .meaning = "names of the states that \"schmidt\" considers and does not estimate",
       .field = NamesField{"filter.considered"},
       .default_words = "none"},
  };
}

void check_linear(const Scenario& scenario, const Refusal& refuse) {
  check_estimator(scenario, refuse, kLinearOffer);
  check_world(scenario, refuse);
  check_filter(scenario, refuse);
  if (scenario.noise.detection_probability == 1.0) return;
  for (const auto& models : {linear_truth(scenario), linear_belief(scenario)}) {
    if (!std::ranges::all_of(models, [](const LinearModel& model) { return model.R.isDiagonal(0.0); })) {
      refuse.impossible("noise", "detection_probability",
                        "must be 1 where world.R or filter.R is not diagonal");
    }
  }
}

std::vector<LinearModel> linear_truth(const Scenario& scenario) { return models_of(scenario, "world", {}); }

std::vector<LinearModel> linear_belief(const Scenario& scenario) {
  return models_of(scenario, "filter", linear_truth(scenario));
}

Matrix linear_gain(const Scenario& scenario) { return matrix_of(rows_value(scenario, "filter.gain")); }

std::vector<Index> considered_states(const Scenario& scenario) {
  const std::vector<std::string> states = linear_state_names(scenario);
  std::vector<Index> considered;
  for (const std::string& name : names_value(scenario, "filter.considered")) {
    considered.push_back(std::ranges::find(states, name) - states.begin());
  }
  std::ranges::sort(considered);
  return considered;
}

std::vector<std::string> linear_state_names(const Scenario& scenario) {
  std::vector<std::string> names = names_value(scenario, "world.states");
  if (!names.empty()) return names;
  const Index n = columns_of(scenario, "world.F", 0);
  for (Index i = 1; i <= n; ++i) names.push_back(fmt::format("x{}", i));
  return names;
}

}  // namespace credence::internal
