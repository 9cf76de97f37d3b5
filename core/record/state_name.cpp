#include "core/record/state_name.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/trim_blanks.h"

namespace credence::internal {
namespace {

constexpr std::string_view kAngleMark = ":angle";

std::string unit_at(const RunLayout& layout, std::size_t i) {
  return i < layout.units.size() ? layout.units[i] : "";
}

}  // namespace

StateName state_name(std::string_view text) {
  StateName state;
  const std::size_t open = text.rfind('[');
  if (open != std::string_view::npos && text.ends_with(']')) {
    const std::string_view before = trim_blanks(text.substr(0, open));
    const std::string_view unit = trim_blanks(text.substr(open + 1, text.size() - open - 2));
    if (!before.empty() && !unit.empty()) {
      state.unit = unit;
      text = before;
    }
  }
  state.angle = text.ends_with(kAngleMark);
  if (state.angle) text.remove_suffix(kAngleMark.size());
  state.name = text;
  return state;
}

std::vector<std::string> marked_states(const RunLayout& layout) {
  RunLayout read{.states = layout.states, .angles = layout.angles};
  add_named_blocks(read);
  std::vector<std::string> marked;
  bool units_are_read = true;
  for (std::size_t i = 0; i < layout.states.size(); ++i) {
    const bool angle = i < layout.angles.size() && layout.angles[i];
    units_are_read = units_are_read && (angle || unit_at(read, i) == unit_at(layout, i));
    marked.push_back(fmt::format("{}{}", layout.states[i], angle ? kAngleMark : ""));
  }
  for (std::size_t i = 0; i < marked.size() && !units_are_read; ++i) {
    if (const std::string unit = unit_at(layout, i); !unit.empty()) marked[i] += fmt::format(" [{}]", unit);
  }
  return marked;
}

void require_radians(const RunLayout& layout, std::string_view source) {
  for (std::size_t i = 0; i < layout.units.size(); ++i) {
    if (!layout.angles[i] || layout.units[i].empty() || layout.units[i] == "rad") continue;
    throw std::invalid_argument(fmt::format("{}state '{}' is an angle, in '{}'; an angle is in rad", source,
                                            layout.states[i], layout.units[i]));
  }
}

}  // namespace credence::internal
