#include "datasets/logs/conventions/step_conventions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/manifold/angle.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "datasets/logs/conventions/reading_fit.h"
#include "datasets/logs/conventions/thinned.h"
#include "datasets/logs/conventions/truth_readings.h"

namespace credence::internal {
namespace {

struct StepReading {
  std::string cause;
  std::function<void(Matrix& P)> change;
};

/// P ← P⁻¹; NaN, which no reading fits, where P has no Cholesky factor.
void invert_information(Matrix& P) {
  const Eigen::LLT<Matrix> factor(P);
  if (factor.info() == Eigen::Success)
    P = factor.solve(Matrix::Identity(P.rows(), P.cols()));
  else
    P.setConstant(kNaN);
}

/// P_ij ← d_i P_ij d_j with d = factor in one state, or in all of those.
auto scaled(std::vector<Index> states, double factor) {
  return [states = std::move(states), factor](Matrix& P) {
    for (const Index i : states) {
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  };
}

/// Of a state of `parts` parts of as many states each: P has the first state of each part, then the second of
/// each, and so on, as x, vx, y, vy of x, y, vx, vy.
StepReading interleaved(const RunLayout& layout, Index parts) {
  const Index n = std::ssize(layout.states), size = n / parts;
  std::vector<Index> place(static_cast<std::size_t>(n));  // in P, of each state
  std::vector<std::string> order(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const Index at = i % size * parts + i / size;
    place[static_cast<std::size_t>(i)] = at;
    order[static_cast<std::size_t>(at)] = layout.states[static_cast<std::size_t>(i)];
  }
  constexpr std::size_t kNamed = 6;
  const bool more = order.size() > kNamed;
  order.resize(std::min(order.size(), kNamed));
  return {fmt::format("P is written in the order {}{}", fmt::join(order, ", "), more ? ", …" : ""),
          [place = std::move(place)](Matrix& P) { P = Matrix(P(place, place)); }};
}

using Parts = std::vector<std::vector<Index>>;

/// Where each state stands in a P whose parts are in this order.
std::vector<Index> places(const std::vector<std::size_t>& order, const Parts& parts, Index states) {
  std::vector<Index> place(static_cast<std::size_t>(states));
  Index at = 0;
  for (const std::size_t part : order)
    for (const Index i : parts[part]) place[static_cast<std::size_t>(i)] = at++;
  return place;
}

/// States 0, 1, … in parts of `size`, the last of which is whole.
Parts parts_of(std::size_t states, std::size_t size) {
  Parts parts(states / size, std::vector<Index>(size));
  Index next = 0;
  for (std::vector<Index>& part : parts) {
    for (Index& state : part) state = next++;
  }
  return parts;
}

/// Parts of the state that a program may write in another order: its blocks, where they stand one behind the
/// other, three states each, its two halves, and of few states each alone.
std::vector<Parts> parts_in_order(const RunLayout& layout) {
  constexpr std::size_t kMostParts = 6, kOfVectors = 3;
  const std::size_t n = layout.states.size();
  std::vector<Parts> all;
  Parts blocks;
  for (const Block& block : layout.blocks) {
    const Index next = blocks.empty() ? 0 : blocks.back().back() + 1;
    if (block.states.empty() || block.states.front() != next ||
        block.states.back() != next + std::ssize(block.states) - 1)
      break;
    blocks.push_back(block.states);
  }
  if (!blocks.empty() && blocks.back().back() + 1 == std::ssize(layout.states)) all.push_back(blocks);
  if (n % kOfVectors == 0) all.push_back(parts_of(n, kOfVectors));
  if (n % 2 == 0 && n > 0) all.push_back(parts_of(n, n / 2));
  all.push_back(parts_of(n, 1));
  std::erase_if(all, [](const Parts& parts) { return parts.size() < 2 || parts.size() > kMostParts; });
  return all;
}

/// "velocity, position", or "x4 to x6, x1 to x3" where the parts have no names.
std::string order_text(const RunLayout& layout, const std::vector<std::size_t>& order, const Parts& parts) {
  std::vector<std::string> names;
  for (const std::size_t part : order) {
    const std::vector<Index>& states = parts[part];
    const auto block = std::ranges::find(layout.blocks, states, &Block::states);
    const std::string &first = layout.states[static_cast<std::size_t>(states.front())],
                      &last = layout.states[static_cast<std::size_t>(states.back())];
    names.push_back(block != layout.blocks.end() ? block->name
                    : states.size() == 1         ? first
                                                 : fmt::format("{} to {}", first, last));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Of few parts every other order of them.
void add_orders(const RunLayout& layout, const Parts& parts, std::vector<StepReading>& list) {
  constexpr std::size_t kMostParts = 3;
  if (parts.size() > kMostParts) return;
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  while (std::ranges::next_permutation(order).found) {
    list.push_back({fmt::format("P is written in the order {}", order_text(layout, order, parts)),
                    [place = places(order, parts, std::ssize(layout.states))](Matrix& P) {
                      P = Matrix(P(place, place));
                    }});
  }
}

std::vector<StepReading> step_readings(const RunLayout& layout) {
  std::vector<StepReading> list = {
      {"P holds standard deviations, not variances (square them)",
       [](Matrix& P) { P = P.cwiseProduct(P.cwiseAbs()).eval(); }},
      {"P is the information matrix (invert it)", invert_information},
  };
  std::vector<Index> angles;
  const auto add_degrees = [&](const std::string& what, const std::vector<Index>& states) {
    list.push_back({fmt::format("P is in degrees in {}, the error in radians", what),
                    scaled(states, kRadiansPerDegree)});
    list.push_back({fmt::format("the error is in degrees in {}, P in radians", what),
                    scaled(states, 1.0 / kRadiansPerDegree)});
  };
  for (std::size_t i = 0; i < layout.angles.size(); ++i) {
    if (!layout.angles[i]) continue;
    angles.push_back(static_cast<Index>(i));
    add_degrees(layout.states[i], {static_cast<Index>(i)});
  }
  if (angles.size() > 1) add_degrees("all angles", angles);
  // Position, velocity and acceleration, or the axes of a plane or of space.
  constexpr Index kMostOfOne = 3;
  const Index n = std::ssize(layout.states);
  for (Index parts = 2; 2 * parts <= n; ++parts) {
    if (n % parts == 0 && (parts <= kMostOfOne || n / parts <= kMostOfOne))
      list.push_back(interleaved(layout, parts));
  }
  for (const Parts& parts : parts_in_order(layout)) add_orders(layout, parts, list);
  // With P's cross-covariances. Of two parts either may be the turned one.
  constexpr std::size_t kMostTurned = 6;
  std::size_t turned = 0;
  for (const Block& block : layout.blocks) {
    if (block.states.size() >= layout.states.size() || ++turned > kMostTurned) continue;
    list.push_back({fmt::format("the error has the opposite sign in {} and not in the rest, or P's "
                                "cross-covariances between them have",
                                block.name),
                    scaled(block.states, -1.0)});
  }
  return list;
}

}  // namespace

/// Where the parts of P stand in the likeliest order, if errors far off are right
/// within a factor of 4 then, in every state and together. No test: what is so far off and comes so near
/// needs none.
std::string StepConventions::other_order() const {
  constexpr double kFarOff = 10.0, kNear = 4.0;
  const auto n = static_cast<Index>(layout_.states.size());
  const auto counts = [n](const Matrix& row) { return row.rows() == n && row.diagonal().minCoeff() > 0.0; };
  Vector as_written = Vector::Zero(n);  // mean e_i²/P_ii
  double rows = 0.0;
  for (const Matrix& row : rows_) {
    if (!counts(row)) continue;
    for (Index i = 0; i < n; ++i) as_written[i] += row(i, n) * row(i, n) / row(i, i);
    rows += 1.0;
  }
  if (rows < static_cast<double>(kFewestForReading)) return {};
  as_written /= rows;
  if (as_written.maxCoeff() < kFarOff && as_written.minCoeff() > 1.0 / kFarOff) return {};
  Matrix ratio = Matrix::Zero(n, n);  // mean e_i²/P_jj
  Vector logarithm = Vector::Zero(n);
  for (const Matrix& row : rows_) {
    if (!counts(row)) continue;
    const Vector variance = row.diagonal();
    ratio += row.col(n).cwiseAbs2() * variance.cwiseInverse().transpose();
    logarithm += variance.array().log().matrix();
  }
  ratio /= rows;
  logarithm /= rows;
  const auto near = [](double value) { return value > 1.0 / kNear && value < kNear; };
  struct Order {
    double cost;  ///< minus the log-likelihood by the variances alone
    std::vector<std::size_t> order;
    const Parts* parts;
  };
  std::vector<Order> orders;
  const std::vector<Parts> all_parts = parts_in_order(layout_);
  for (const Parts& parts : all_parts) {
    std::vector<std::size_t> order(parts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    do {
      double cost = 0.0;
      bool all_near = true;
      Index at = 0;  // in P
      for (const std::size_t part : order) {
        for (const Index i : parts[part]) {
          cost += ratio(i, at) + logarithm[at];
          all_near = all_near && near(ratio(i, at));
          ++at;
        }
      }
      if (all_near) orders.push_back({cost, order, &parts});
    } while (std::ranges::next_permutation(order).found);
  }
  // Of the likeliest, whose determinants are the same, the covariances decide.
  constexpr std::size_t kLikeliest = 24;
  std::ranges::sort(orders, {}, &Order::cost);
  orders.resize(std::min(orders.size(), kLikeliest));
  const Order* best = nullptr;
  double nees = std::numeric_limits<double>::infinity();
  for (const Order& candidate : orders) {
    const std::vector<Index> place = places(candidate.order, *candidate.parts, n);
    double mean = 0.0;
    for (const Matrix& row : rows_) {
      if (!counts(row)) continue;
      const Eigen::LLT<Matrix> factor(Matrix(row(place, place)));
      mean += factor.info() == Eigen::Success ? factor.matrixL().solve(row.col(n)).squaredNorm() / rows
                                              : std::numeric_limits<double>::infinity();
    }
    if (!(mean < nees)) continue;
    nees = mean;
    best = &candidate;
  }
  if (best == nullptr || !near(nees / static_cast<double>(n))) return {};
  return fmt::format(
      "P is perhaps written in another order than the states: with its rows in the order {} the mean NEES is "
      "{} of {}, and every state fits within a factor of {:g}.",
      order_text(layout_, best->order, *best->parts), number_text(nees), n, kNear);
}

void StepConventions::begin_run(const RunLayout& layout) {
  layout_ = layout;
  ForwardingSink::begin_run(layout);
}

void StepConventions::add(const Step& step) {
  constexpr std::size_t kMostStates = 24;
  ForwardingSink::add(step);
  const std::size_t n = layout_.states.size();
  if (!step.problem.empty() || n == 0 || n > kMostStates || step.states.size() != n) return;
  if (keep_thinned(rows_, stride_, seen_)) {
    const Index of_states = step.error.size();
    Matrix& row = rows_.emplace_back(of_states, of_states + 2);
    row.leftCols(of_states) = step.P;
    row.col(of_states) = step.error;
    row.col(of_states + 1).setConstant(kNaN);
    if (step.estimate.size() == of_states) row.col(of_states + 1) = step.estimate;
  }
}

void StepConventions::finish() {
  if (rows_.size() < kFewestForReading || !layout_.joint_covariance) return;
  const auto n = static_cast<Index>(layout_.states.size());
  const auto rows_changed_by = [&](const std::function<void(Matrix&)>& change) -> ReadingRow {
    return [&](std::size_t i, Vector& error, Matrix& P) {
      if (rows_[i].rows() != n) return false;
      error = rows_[i].col(n);
      P = rows_[i].leftCols(n);
      change(P);
      return true;
    };
  };
  const auto declared = misfitting_reading(rows_.size(), n, {}, rows_changed_by([](Matrix&) {}));
  if (!declared) return;
  // Of one state any P that is twice too large is by chance near a deviation, or an inverse, in some unit.
  constexpr double kGross = 4.0;
  const double scale = declared->nees / static_cast<double>(n);
  const auto scaled = [scale](Matrix& P) { P *= scale; };
  const bool scale_may_do = scale > 1.0 / kGross && scale < kGross;
  if (scale_may_do && fitting_reading(rows_.size(), n, {}, rows_changed_by(scaled))) return unexplained();
  // A P0 that is wrong is no mistake of units, which is in all rows; and such a factor is likelier than one.
  const std::size_t start = rows_.size() / 10, later = rows_.size() - start;
  const auto of_later = [&](const std::function<void(Matrix&)>& change) {
    const ReadingRow read = rows_changed_by(change);
    const auto shifted = [&](std::size_t i, Vector& error, Matrix& P) { return read(start + i, error, P); };
    return static_cast<double>(later) * fit_reading(later, n, {}, shifted).log_likelihood;
  };
  constexpr double kClearly = 3.0;
  double simpler = of_later([](Matrix&) {});
  if (scale_may_do) simpler = std::max(simpler, of_later(scaled));
  std::optional<ReadingFit> best;
  std::string cause;
  for (const StepReading& reading : step_readings(layout_)) {
    const auto found = fitting_reading(rows_.size(), n, {}, rows_changed_by(reading.change));
    if (!found || (best && best->log_likelihood >= found->log_likelihood)) continue;
    if (!(of_later(reading.change) > simpler + kClearly)) continue;
    best = found;
    cause = reading.cause;
  }
  if (!best) {
    if (std::string order = other_order(); !order.empty()) return misfit(std::move(order));
    if (std::string truth = other_truth(layout_, rows_); !truth.empty()) return misfit(std::move(truth));
    return unexplained();
  }
  misfit(
      fmt::format("The covariance does not fit as it is read ({}). It would fit if {} (mean NEES {}). "
                  "Whether it is so, the log cannot say: look at the program that wrote it.",
                  misfit_text(*declared, n), cause, number_text(best->nees)));
}

}  // namespace credence::internal
