#include "reports/document/run_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "reports/render/atomic_file.h"

namespace credence {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

/// The columns of these states of the layout and of this many measurements.
std::string log_header(const RunLayout& layout, const std::vector<Index>& states, Index measurements) {
  std::string text = "step";
  const auto out = std::back_inserter(text);
  for (const Index state : states) {
    const auto i = static_cast<std::size_t>(state);
    fmt::format_to(out, ",estimate.{}{}", layout.states[i], layout.angles[i] ? ":angle" : "");
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
  for (Index i = 1; i <= measurements; ++i) fmt::format_to(out, ",innovation.{}", i);
  triangle("S", measurements);
  return text + "\n";
}

void append(std::string& text, const Vector& v, Index n) {
  for (Index i = 0; i < n; ++i) {
    text += ',';
    if (i < v.size()) fmt::format_to(std::back_inserter(text), "{}", v[i]);
  }
}

/// The lower triangle of M, which is what is factorised, as the upper one of a symmetric matrix.
void append(std::string& text, const Matrix& M, Index n) {
  for (Index i = 0; i < n; ++i) {
    for (Index j = i; j < n; ++j) {
      text += ',';
      if (j < M.rows()) fmt::format_to(std::back_inserter(text), "{}", M(j, i));
    }
  }
}

}  // namespace

void write_run_log(const std::filesystem::path& target, const RunTrace& trace, std::size_t end,
                   const std::string& failure) {
  const std::vector<Index>& states = trace.steps.back().states;
  const Index n = std::ssize(states);
  end = std::min(end, trace.steps.size());
  Index m = 0;
  for (std::size_t k = 1; k < end; ++k) m = std::max(m, trace.steps[k].innovation().size());
  AtomicFile file(target);
  std::string text = log_header(trace.layout, states, m);
  for (std::size_t k = 1; k < end; ++k) {
    const TraceStep& step = trace.steps[k];
    fmt::format_to(std::back_inserter(text), "{}", k);
    append(text, step.estimate, n);
    append(text, step.truth, n);
    append(text, step.P, n);
    append(text, step.innovation(), m);
    append(text, step.S(), m);
    text += '\n';
    if (text.size() < kBlockBytes) continue;
    file.write(text);
    text.clear();
  }
  if (!failure.empty()) text += fmt::format("# failed: {}\n", failure);
  file.write(text);
  file.commit();
}

}  // namespace credence
