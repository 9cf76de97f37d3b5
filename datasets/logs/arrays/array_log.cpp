#include "datasets/logs/arrays/array_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/append_item.h"
#include "core/control_characters.h"
#include "core/manifold/angle.h"
#include "core/utf8.h"
#include "datasets/data_error.h"
#include "datasets/logs/arrays/array_roles.h"
#include "datasets/logs/arrays/array_rows.h"
#include "datasets/logs/assumed_noise.h"
#include "datasets/logs/conventions/log_conventions.h"
#include "datasets/logs/conventions/swapped_axes.h"
#include "datasets/logs/number_field.h"
#include "montecarlo/worlds/plugged/plugged_concepts.h"

namespace credence::internal {

using namespace array_names;

namespace {

/// Of how many components an observation is, of which the innovation of a sensor may hold several: the array
/// "observation" or "observation_NAME", if there is one.
Index observation_dim(ArrayFile& file, const ArrayPair& sensor) {
  const auto dim = static_cast<Index>(sensor.dim);
  const auto array = find_array(file, of_sensor(kObservation, sensor));
  if (!array) return dim;
  const std::optional<double> value = single_number(file, *array);
  for (Index piece = 1; piece <= dim; ++piece) {
    if (dim % piece == 0 && value == static_cast<double>(piece)) return piece;
  }
  throw DataError(file.path(), "",
                  fmt::format("{}: accepted is one number, the dimension of an observation, that divides the "
                              "{} components of the innovation",
                              shape_text(file.arrays()[*array]), dim));
}

void require_printable(const ArrayFile& file, const char* what, std::string_view name) {
  if (!has_control_character(name)) return;
  throw DataError(file.path(), "",
                  fmt::format("{} '{}': its name holds a control character", what, shown_field(name)));
}

/// The texts of the array of names; none where there is no such array.
std::vector<std::string> state_names(ArrayFile& file, std::uint64_t states) {
  std::vector<std::string> names;
  const auto array = find_array(file, kNamesOfStates);
  if (!array || file.arrays()[*array].dims.empty()) return names;
  const ArrayShape& shape = file.arrays()[*array];
  if (shape.dims.size() != 2 || shape.dims[0] != states) {
    const std::uint64_t given = shape.dims.size() == 2 ? shape.dims[0] : 0;
    throw DataError(
        file.path(), "",
        fmt::format("{}: {} names for {} states; accepted is one for each", shape.name, given, states));
  }
  std::vector<double> letters;
  file.read(*array, 0, shape.dims[0] * shape.dims[1], letters);
  for (auto at = letters.begin(); at != letters.end(); at += static_cast<std::ptrdiff_t>(shape.dims[1])) {
    std::string name;
    for (auto letter = at; letter != at + static_cast<std::ptrdiff_t>(shape.dims[1]) && *letter > 0.0;
         ++letter)
      append_utf8(name, static_cast<char32_t>(*letter));
    require_printable(file, "state", name);
    names.push_back(std::move(name));
  }
  return names;
}

/// Whether the array of this name says 1; false where there is none.
bool flag(ArrayFile& file, std::string_view name) {
  const auto array = find_array(file, name);
  if (!array) return false;
  const std::optional<double> value = single_number(file, *array);
  if (value == 0.0 || value == 1.0) return value == 1.0;
  throw DataError(file.path(), "",
                  fmt::format("{}: accepted is one number, 1 for a filter that is, 0 for one that is not",
                              shape_text(file.arrays()[*array])));
}

RunLayout layout_of(ArrayFile& file, const ArrayRoles& roles) {
  constexpr std::uint64_t kMostBlocks = 30;
  RunLayout layout;
  layout.has_truth = roles.state().has_value();
  layout.nonlinear = flag(file, kNonlinear);
  layout.inflated = flag(file, kInflated);
  const std::uint64_t n = roles.state() ? roles.state()->dim : 0;
  if (const std::vector<std::string> names = state_names(file, n); !names.empty()) {
    try {
      RunLayout named = model_layout(names, {});
      layout.states = std::move(named.states);
      layout.angles = std::move(named.angles);
      layout.units = std::move(named.units);
      layout.blocks = std::move(named.blocks);
      layout.landmark_dim = named.landmark_dim;
    } catch (const std::invalid_argument& error) {
      throw DataError(file.path(), "", fmt::format("{}: {}", kNamesOfStates, error.what()));
    }
  } else {
    for (std::uint64_t i = 0; i < n; ++i) layout.states.push_back(fmt::format("x{}", i + 1));
    layout.angles.assign(layout.states.size(), false);
    if (n <= kMostBlocks) add_named_blocks(layout);
  }
  for (const ArrayPair& sensor : roles.sensors()) {
    require_printable(file, "sensor", sensor.name);
    const auto dim = static_cast<Index>(sensor.dim);
    layout.sensors.push_back({.name = sensor.name, .dim = dim, .piece = observation_dim(file, sensor)});
  }
  for (const NisArray& sensor : roles.nis()) {
    require_printable(file, "sensor", sensor.name);
    const auto dim = static_cast<Index>(sensor.dim);
    layout.sensors.push_back({.name = sensor.name, .dim = dim, .piece = dim, .nis_alone = true});
  }
  return layout;
}

/// Names the arrays that nobody reads, of which one may be misspelt.
void tell_unread(const ArrayFile& file, const ArrayRoles& roles, const RunLayout& layout, LogSink& sink) {
  constexpr std::size_t kMost = 8;
  const auto lacks_its_sensor = [&layout](std::string_view name) {
    constexpr std::string_view kArrays[] = {kS, kR, kObservation};
    return std::ranges::any_of(kArrays, [&](std::string_view array) {
      const bool named = name.starts_with(array) && name.substr(array.size()).starts_with("_");
      if (!named && name != array) return false;
      const std::string_view sensor = named ? name.substr(array.size() + 1) : "";
      return std::ranges::find(layout.sensors, sensor, &Sensor::name) == layout.sensors.end();
    });
  };
  std::vector<std::string> unread;
  for (const ArrayShape& array : file.arrays()) {
    const bool used = array.name == kTruth ? roles.truth().has_value()
                      : array.name == kNamesOfStates
                          ? !array.dims.empty()
                          : is_log_array(array.name) && !lacks_its_sensor(array.name);
    if (used) continue;
    unread.push_back(shown_field(array.name));
  }
  if (!unread.empty()) sink.remark(fmt::format("Not read: {}.", first_items(unread, kMost)));
}

}  // namespace

std::uint64_t column_major_place(const std::vector<std::uint64_t>& dims, std::uint64_t k) {
  std::uint64_t place = 0, stride = 1;
  for (const std::uint64_t dim : dims) stride *= dim;
  for (std::size_t d = dims.size(); d-- > 0;) {
    stride /= dims[d];
    place += k % dims[d] * stride;
    k /= dims[d];
  }
  return place;
}

bool is_log_array(std::string_view name) {
  return name == kError || name == kEstimate || name == kTruth || name == kP || name == kInnovation ||
         name == kS || name.starts_with("innovation_") || name.starts_with("S_") || name == kObservation ||
         name.starts_with("observation_") || name == kR || name.starts_with("R_") || name == kNonlinear ||
         name == kInflated || name == kTime || nis_dimension(name).has_value();
}

namespace {

void add_estimate(const double* estimate, Step& step) {
  step.estimate.resize(step.error.size());
  for (Index i = 0; i < step.error.size(); ++i) {
    step.estimate[i] = estimate[static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)])];
  }
}

/// As those of every other format.
void wrap_errors(const RunLayout& layout, Step& step) {
  for (Index i = 0; i < step.error.size(); ++i) {
    const auto state = static_cast<std::size_t>(step.states[static_cast<std::size_t>(i)]);
    if (layout.angles[state]) step.error[i] = wrap_angle(step.error[i]);
  }
}

}  // namespace

void read_arrays(ArrayFile& file, LogSink& judged) {
  LogConventions conventions(judged);
  LogSink& sink = conventions.sink();
  const ArrayRoles roles(file);
  const RunLayout layout = layout_of(file, roles);
  std::vector<PairReader> sensors;
  std::vector<NoiseReader> noise;
  for (const ArrayPair& sensor : roles.sensors()) {
    const Index piece = layout.sensors[sensors.size()].piece;
    sensors.emplace_back(file, sensor);
    noise.emplace_back(file, sensor, piece);
  }
  std::optional<PairReader> state;
  if (roles.state()) state.emplace(file, *roles.state(), roles.truth());
  std::optional<RowReader> estimate;
  if (roles.estimate()) estimate.emplace(file, *roles.estimate(), roles.steps(), roles.state()->dim);
  const std::string scalars = roles.scalars_text();
  TimeReader times(file, roles.runs(), roles.steps(), scalars, sink);
  if (!scalars.empty()) sink.remark(scalars);
  if (std::string square = roles.square_text(); !square.empty()) sink.remark(std::move(square));
  tell_unread(file, roles, layout, sink);
  SwappedAxes axes;
  Step step;
  std::vector<Index> measured;
  std::vector<std::vector<double>> nis(roles.nis().size());
  for (std::uint64_t run = 0; run < roles.runs(); ++run) {
    if (roles.runs() > 1) sink.run_number(fmt::to_string(run));
    sink.begin_run(layout);
    axes.begin_run();
    const std::vector<double>& time_s = times.of(run);
    for (std::size_t i = 0; i < nis.size(); ++i)
      file.read(roles.nis()[i].values, run * roles.steps(), roles.steps(), nis[i]);
    for (std::uint64_t k = 0; k < roles.steps(); ++k) {
      step.step = static_cast<std::int64_t>(k) + 1;
      step.line = static_cast<std::int64_t>(run * roles.steps() + k) + 1;
      step.problem = {};
      if (state) {
        state->read(run, k, step.states, step.error, step.P, step.problem);
        wrap_errors(layout, step);
        axes.add(step);
      }
      if (estimate) add_estimate(estimate->row(run, k), step);
      step.innovations.resize(layout.sensors.size());
      for (std::size_t i = 0; i < sensors.size(); ++i) {
        Innovation& innovation = step.innovations[i];
        sensors[i].read(run, k, measured, innovation.nu, innovation.S, step.problem);
        innovation.complete = are_complete(measured, layout.sensors[i].piece);
        if (!measured.empty()) {
          take_assumed_noise(noise[i].at(run, k), layout.sensors[i].piece, measured, innovation.R);
        }
      }
      for (std::size_t i = 0; i < nis.size(); ++i) {
        const double value = nis[i][k];
        step.innovations[sensors.size() + i] = value >= 0.0 ? nis_alone(value) : Innovation{};
        if (value < 0.0) step.problem = "a NIS is negative";
      }
      if (!time_s.empty()) sink.at(time_s[k]);
      sink.add(step);
    }
  }
  if (std::string swapped = axes.says(); !swapped.empty()) sink.swapped_axes(std::move(swapped));
  conventions.finish();
}

LogContents list_arrays(const ArrayFile& file) {
  LogContents contents;
  for (const ArrayShape& array : file.arrays()) {
    std::int64_t count =
        array.dims.empty() ? 0 : 1;  // rows: all dimensions but the last, of P and S the last two
    const bool matrices = array.name == kP || array.name == kS || array.name.starts_with("S_") ||
                          array.name == kR || array.name.starts_with("R_");
    const bool vectors = array.name == kError || array.name == kEstimate || array.name == kTruth ||
                         array.name.starts_with(kInnovation);
    const std::size_t of_row = matrices ? 2U : nis_dimension(array.name) || array.name == kTime ? 0U : 1U;
    const std::size_t inner = std::min(array.dims.size(), of_row);
    for (std::size_t i = 0; i + inner < array.dims.size(); ++i)
      count *= static_cast<std::int64_t>(array.dims[i]);
    contents.topics.push_back({.name = array.name,
                               .type = array.dims.empty()
                                           ? array.type
                                           : fmt::format("{} ({})", array.type, fmt::join(array.dims, ", ")),
                               .count = count,
                               .use = array.name == kError        ? "error"
                                      : array.name == kEstimate   ? "estimate"
                                      : array.name == kTruth      ? "truth"
                                      : array.name == kTime       ? "time"
                                      : nis_dimension(array.name) ? "NIS alone"
                                      : vectors                   ? "innovations"
                                      : matrices                  ? "covariance"
                                                                  : "",
                               .covariance = matrices});
  }
  return contents;
}

}  // namespace credence::internal
