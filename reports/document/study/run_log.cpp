#include "reports/document/study/run_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/record/state_name.h"
#include "datasets/logs/assumed_noise.h"
#include "reports/document/study/state_places.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

/// The columns of these states of the layout, of this many measurements and of what is known of their R.
std::string log_header(const RunLayout& layout, const std::vector<Index>& states, Index measurements,
                       const Matrix& R, bool timed) {
  std::string text = timed ? "step,time" : "step";
  const auto out = std::back_inserter(text);
  const std::vector<std::string> marked = marked_states(layout);
  for (const Index state : states) {
    fmt::format_to(out, ",estimate.{}", marked[static_cast<std::size_t>(state)]);
  }
  for (const Index state : states) {
    fmt::format_to(out, ",truth.{}", layout.states[static_cast<std::size_t>(state)]);
  }
  const auto triangle = [&](const char* name, Index n) {
    for (Index i = 1; i <= n; ++i) {
      for (Index j = i; j <= n; ++j) fmt::format_to(out, ",{}.{}.{}", name, i, j);
    }
  };
  triangle("P", std::ssize(states));
  for (Index i = 0; i < measurements; ++i) {
    const Sensor& sensor = layout.sensors.front();
    const Index place = i % sensor.piece;
    const bool angle = !sensor.angles.empty() && sensor.angles[static_cast<std::size_t>(place)];
    fmt::format_to(out, ",innovation.{}{}{}", i + 1, i > 0 && place == 0 ? ":next" : "",
                   angle ? ":angle" : "");
  }
  triangle("S", measurements);
  triangle("R", R.rows());
  if (layout.nonlinear) text += ",nonlinear";
  if (layout.inflated) text += ",inflated";
  return text + "\n";
}

/// What the first row says of the filter; the others leave it blank.
void append_filter(std::string& text, const RunLayout& layout, const Matrix& R, bool first) {
  for (Index i = 0; i < R.rows(); ++i) {
    for (Index j = i; j < R.rows(); ++j) {
      text += ',';
      if (first) fmt::format_to(std::back_inserter(text), "{}", R(i, j));
    }
  }
  for (const bool is : {layout.nonlinear, layout.inflated}) {
    if (is) text += first ? ",1" : ",";
  }
}

/// places: for each column the component that stands there, −1 for none.
void append(std::string& text, const Vector& v, const std::vector<Index>& places) {
  for (const Index i : places) {
    text += ',';
    if (i >= 0) fmt::format_to(std::back_inserter(text), "{}", v[i]);
  }
}

/// The lower triangle of M, which is what is factorised, as the upper one of a symmetric matrix.
void append(std::string& text, const Matrix& M, const std::vector<Index>& places) {
  for (auto i = places.begin(); i != places.end(); ++i) {
    for (auto j = i; j != places.end(); ++j) {
      text += ',';
      if (*i >= 0 && *j >= 0)
        fmt::format_to(std::back_inserter(text), "{}", M(std::max(*i, *j), std::min(*i, *j)));
    }
  }
}

}  // namespace

void write_run_log(const std::filesystem::path& target, const RunTrace& trace, std::size_t end,
                   const std::string& failure, double step_s) {
  const std::vector<Index>& states = trace.steps.back().states;
  end = std::min(end, trace.steps.size());
  Index m = 0;
  for (std::size_t k = 1; k < end; ++k) m = std::max(m, trace.steps[k].innovation().size());
  AtomicFile file(target);
  // Of a run that measured nothing there is no sensor for it to belong to.
  const Matrix R = m > 0 ? assumed_noise(trace.layout.sensors.front(), m) : Matrix();
  std::string text = log_header(trace.layout, states, m, R, step_s > 0.0);
  std::vector<Index> places, measured(static_cast<std::size_t>(m));
  for (std::size_t k = 1; k < end; ++k) {
    const TraceStep& step = trace.steps[k];
    find_places(states, step.states, places);
    for (Index i = 0; i < m; ++i) {
      measured[static_cast<std::size_t>(i)] = i < step.innovation().size() ? i : -1;
    }
    fmt::format_to(std::back_inserter(text), "{}", k);
    if (step_s > 0.0) fmt::format_to(std::back_inserter(text), ",{}", step_s * static_cast<double>(k));
    append(text, step.estimate, places);
    append(text, step.truth, places);
    append(text, step.P, places);
    append(text, step.innovation(), measured);
    append(text, step.S(), measured);
    append_filter(text, trace.layout, R, k == 1);
    text += '\n';
    if (text.size() < kBlockBytes) continue;
    file.write(text);
    text.clear();
  }
  if (!failure.empty()) text += fmt::format("# failed: {}\n", failure);
  file.write(text);
  file.commit();
}

}  // namespace credence::internal
