#include "datasets/logs/filter_log_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/append_item.h"
#include "core/control_characters.h"
#include "core/record/state_name.h"
#include "datasets/logs/number_field.h"

namespace credence::internal {
namespace {

constexpr Index kLargestDimension = 2000;
constexpr const char* kAccepted =
    "accepted are run, step, time, estimate.NAME, truth.NAME, error.NAME (NAME:angle of an angle, NAME [m/s] "
    "with a unit), P.i.j, innovation.i, S.i.j, R.i.j, nis.DIM (innovation.SENSOR.i, … of several sensors), "
    "nonlinear, inflated, with numbers to 2000 (docs/formats.md); a file with columns of other names: "
    "docs/recipes.md";

std::invalid_argument error_beside(std::string_view state) {
  return std::invalid_argument(fmt::format(
      "column error.{0} beside estimate.{0} or truth.{0}: of each state either the error, or estimate "
      "and truth",
      state));
}

/// Columns of the entries of a matrix by (row, column), as numbered.
using Entries = std::map<std::pair<Index, Index>, Index>;

/// What the columns of one sensor are.
struct SensorColumns {
  std::map<Index, Index> nu;      // by number
  std::set<Index> angles, nexts;  // numbers of those marked ":angle" and ":next"
  Entries S, R;
  Index nis = -1, nis_dim = 0;  // a column of NIS alone, and the dimension of its innovation

  /// What the numbers of the innovation are counted from.
  Index first() const { return nu.contains(0) ? 0 : 1; }
};

std::optional<Index> parse_index(std::string_view text) {
  Index value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < 0 || value > kLargestDimension) {
    return std::nullopt;
  }
  return value;
}

/// What the numbers of a matrix are counted from: 0 where one of them is.
Index first_number(const Entries& entries) {
  const auto has_zero = [](const auto& entry) {
    return std::min(entry.first.first, entry.first.second) == 0;
  };
  return std::ranges::any_of(entries, has_zero) ? 0 : 1;
}

/// Takes ".i" off the end of a name.
std::optional<Index> take_index(std::string_view& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::optional<Index> index = parse_index(name.substr(dot + 1));
  if (index) name = name.substr(0, dot);
  return index;
}

/// Takes ":mark" off the end of a name, if it is there.
bool take_mark(std::string_view& name, std::string_view mark) {
  if (!name.ends_with(mark)) return false;
  name.remove_suffix(mark.size());
  return true;
}

/// "gps" of ".gps", "" of nothing.
std::optional<std::string> sensor_name(std::string_view rest) {
  if (rest.empty()) return std::string();
  if (rest.front() != '.' || rest.size() == 1) return std::nullopt;
  return std::string(rest.substr(1));
}

FilterLogHeader::Symmetric symmetric(const Entries& entries, Index n, const std::string& name) {
  FilterLogHeader::Symmetric result;
  const Index first = first_number(entries), end = first + n;
  const auto column = [&](Index i, Index j) {
    const auto found = entries.find({i, j});
    return found == entries.end() ? Index{-1} : found->second;
  };
  for (const auto& [place, unused] : entries) {
    if (place.first >= end || place.second >= end) {
      throw std::invalid_argument(fmt::format("column {}.{}.{} lies outside its {}×{} matrix", name,
                                              place.first, place.second, n, n));
    }
  }
  for (Index i = first; i < end; ++i) {
    for (Index j = i; j < end; ++j) {
      Index upper = column(i, j), lower = i == j ? -1 : column(j, i);
      if (upper < 0) std::swap(upper, lower);
      if (upper < 0) {
        throw std::invalid_argument(fmt::format("column {}.{}.{} is missing{}", name, i, j,
                                                i == j ? "" : " (0 where the two are not correlated)"));
      }
      result.upper.push_back(upper);
      result.lower.push_back(lower);
    }
  }
  return result;
}

/// Sorts the columns by what they are.
class HeaderParser {
 public:
  void add(std::string_view name, Index column) {
    if (has_control_character(name)) {
      throw std::invalid_argument(
          fmt::format("column {}, '{}': its name holds a control character", column + 1, shown_field(name)));
    }
    names_.push_back(name);
    if (!place(name, column)) unknown_.push_back(shown_field(name));
  }

  FilterLogHeader finish(Index columns) {
    place_named_variances();
    require_known();
    FilterLogHeader& h = header_;
    h.columns = columns;
    // Of a state that is an error alone the estimate is not known (NaN); those beside it may be.
    const auto errors = std::ranges::count_if(h.error, [](Index c) { return c >= 0; });
    h.layout.componentwise = errors < std::ssize(h.error) || errors == 0;
    h.layout.has_truth = !truth_.empty() || errors > 0;
    for (std::size_t i = 0; i < h.layout.states.size(); ++i) {
      const std::string& state = h.layout.states[i];
      const auto found = truth_.find(state);
      const bool of_error = h.error[i] >= 0, has_truth = found != truth_.end();
      if (angles_of_truth_.contains(state)) h.layout.angles[i] = true;
      if (of_error && has_truth) throw error_beside(state);
      if (!of_error && !has_truth && h.layout.has_truth) {
        throw std::invalid_argument(
            fmt::format("column truth.{} is missing (blank where it is not known)", state));
      }
      if (!truth_.empty()) h.truth.push_back(has_truth ? found->second : -1);
    }
    for (const auto& [state, unused] : truth_) {
      if (!states_.contains(state)) {
        throw std::invalid_argument(fmt::format("column estimate.{} is missing", state));
      }
    }
    place_units();
    const Index n = std::ssize(h.layout.states);
    if (h.layout.has_truth || !P_.empty()) h.P = symmetric(P_, n, "P");
    for (Sensor& sensor : h.layout.sensors) add_sensor(sensor);
    if (!h.layout.has_truth && h.layout.sensors.empty()) {
      throw std::invalid_argument(
          "nothing to judge: there is neither a truth.NAME for the estimates, nor an error.NAME, nor an "
          "innovation.i");
    }
    add_named_blocks(h.layout);
    return std::move(h);
  }

 private:
  void require_known() const {
    constexpr std::size_t kShown = 12;
    if (unknown_.empty()) return;
    const auto is_number = [](const std::string& name) { return parse_finite(name).has_value(); };
    if (std::ranges::all_of(unknown_, is_number))
      throw std::invalid_argument(
          fmt::format("there is no header: its first line is numbers; {}", kAccepted));
    if (std::ranges::find(unknown_, "") != unknown_.end()) {
      throw std::invalid_argument(
          "a column has no name: is it the index of pandas, which to_csv(FILE, index=False) leaves out, or a "
          "comma at the end of the line?");
    }
    std::vector<std::string> quoted;
    for (const std::string& name : unknown_) quoted.push_back(fmt::format("'{}'", name));
    throw std::invalid_argument(fmt::format("unknown column{} {}: {}", quoted.size() == 1 ? "" : "s",
                                            first_items(quoted, kShown), kAccepted));
  }

  bool place(std::string_view name, Index column) {
    if (name == "run") return set(header_.run, column);
    if (name == "step") return set(header_.step, column);
    if (name == "time") return set(header_.time, column);
    if (name == "nonlinear") return set(header_.nonlinear, column);
    if (name == "inflated") return set(header_.inflated, column);
    if (name.starts_with("estimate.")) return add_state("estimate", name.substr(9), column, -1);
    if (name.starts_with("error.")) return add_state("error", name.substr(6), -1, column);
    if (name.starts_with("truth.")) {
      const StateName state = state_name(name.substr(6));
      if (state.angle) angles_of_truth_.insert(state.name);
      if (!state.unit.empty()) units_.emplace_back(state);
      return !state.name.empty() && insert(truth_, state.name, column);
    }
    if (name.starts_with("P.")) return add_variance(name.substr(1), column);
    if (name.starts_with("innovation.")) return add_innovation(name.substr(10), column);
    if (name.starts_with("S.")) return add_covariance(&SensorColumns::S, name.substr(1), column);
    if (name.starts_with("R.")) return add_covariance(&SensorColumns::R, name.substr(1), column);
    if (name.starts_with("nis.")) return add_nis(name.substr(3), column);
    return false;
  }

  /// What two columns, the first of which stands in the place of the other, are refused with.
  std::invalid_argument there_twice(Index first, Index second) const {
    const std::string_view name = names_[static_cast<std::size_t>(first)],
                           other = names_[static_cast<std::size_t>(second)];
    if (name == other)
      return std::invalid_argument(fmt::format("column {} is there twice", shown_field(name)));
    return std::invalid_argument(fmt::format("columns {} and {}: what they stand for is there twice",
                                             shown_field(name), shown_field(other)));
  }

  template <class Map, class Key>
  bool insert(Map& map, const Key& key, Index column) const {
    const auto [place, is_new] = map.emplace(key, column);
    if (!is_new) throw there_twice(place->second, column);
    return true;
  }
  bool set(Index& place, Index column) const {
    if (place >= 0) throw there_twice(place, column);
    place = column;
    return true;
  }

  /// A state by the column of its estimate or of its error.
  bool add_state(const char* kind, std::string_view text, Index estimate, Index error) {
    const StateName state = state_name(text);
    const std::string& name = state.name;
    if (name.empty()) return false;
    RunLayout& layout = header_.layout;
    if (!states_.emplace(name).second) {
      const auto place = std::ranges::find(layout.states, name) - layout.states.begin();
      if ((header_.error[static_cast<std::size_t>(place)] < 0) != (error < 0)) throw error_beside(name);
      throw std::invalid_argument(fmt::format("column {}.{} is there twice", kind, name));
    }
    layout.states.push_back(name);
    layout.angles.push_back(state.angle);
    if (!state.unit.empty()) units_.emplace_back(state);
    header_.estimate.push_back(estimate);
    header_.error.push_back(error);
    return true;
  }

  /// Adds ".NAME.i.j" and returns ".NAME"; nothing if it has another form.
  std::optional<std::string> add_entry(Entries& entries, std::string_view rest, Index column) {
    const std::optional<Index> j = take_index(rest);
    const std::optional<Index> i = j ? take_index(rest) : std::nullopt;
    if (!i) return std::nullopt;
    insert(entries, std::pair(*i, *j), column);
    return std::string(rest);
  }

  /// An entry of P by numbers, or by the names of two states, which are known at the end.
  bool add_variance(std::string_view rest, Index column) {
    if (const std::optional<std::string> matrix = add_entry(P_, rest, column)) return matrix->empty();
    named_P_.emplace_back(rest.substr(1), column);
    return true;
  }

  void place_named_variances() {
    const std::vector<std::string>& states = header_.layout.states;
    const Index first = first_number(P_);
    const auto number = [&](std::string_view name) {
      return std::ranges::find(states, name) - states.begin() + first;
    };
    for (const auto& [name, column] : named_P_) {
      bool found = false;
      for (std::size_t dot = name.find('.'); dot != std::string::npos && !found;
           dot = name.find('.', dot + 1)) {
        const std::string row = name.substr(0, dot), other = name.substr(dot + 1);
        found = states_.contains(row) && states_.contains(other);
        if (found) insert(P_, std::pair(number(row), number(other)), column);
      }
      if (!found) unknown_.push_back("P." + shown_field(name));
    }
  }

  void place_units() {
    RunLayout& layout = header_.layout;
    if (!units_.empty()) layout.units.resize(layout.states.size());
    for (const StateName& state : units_) {
      const auto place = std::ranges::find(layout.states, state.name) - layout.states.begin();
      std::string& unit = layout.units[static_cast<std::size_t>(place)];
      if (!unit.empty() && unit != state.unit) {
        throw std::invalid_argument(
            fmt::format("columns estimate.{0} and truth.{0} tell two units, [{1}] and [{2}]", state.name,
                        unit, state.unit));
      }
      unit = state.unit;
    }
    require_radians(layout);
  }

  SensorColumns* sensor(std::string_view rest) {
    const std::optional<std::string> name = sensor_name(rest);
    if (!name) return nullptr;
    const auto [place, is_new] = sensors_.try_emplace(*name);
    if (is_new) header_.layout.sensors.push_back({.name = *name});
    return &place->second;
  }

  bool add_innovation(std::string_view rest, Index column) {
    const bool angle = take_mark(rest, ":angle"), next = take_mark(rest, ":next");
    const std::optional<Index> i = take_index(rest);
    SensorColumns* const of = i ? sensor(rest) : nullptr;
    if (of == nullptr) return false;
    if (angle) of->angles.insert(*i);
    if (next) of->nexts.insert(*i);
    return insert(of->nu, *i, column);
  }

  bool add_covariance(Entries SensorColumns::*matrix, std::string_view rest, Index column) {
    std::string_view name = rest;
    if (!take_index(name) || !take_index(name)) return false;
    SensorColumns* const of = sensor(name);
    return of != nullptr && add_entry(of->*matrix, rest, column).has_value();
  }

  bool add_nis(std::string_view rest, Index column) {
    const std::optional<Index> dim = take_index(rest);
    SensorColumns* const of = dim.value_or(0) > 0 ? sensor(rest) : nullptr;
    if (of == nullptr) return false;
    of->nis_dim = *dim;
    return set(of->nis, column);
  }

  void add_sensor(Sensor& sensor) {
    const std::string& name = sensor.name;
    const SensorColumns& columns = sensors_[name];
    const std::string suffix = name.empty() ? "" : "." + name;
    const Index m = std::ssize(columns.nu);
    FilterLogHeader::Innovation innovation;
    sensor.nis_alone = columns.nis >= 0;
    if (sensor.nis_alone) {
      if (m > 0 || !columns.S.empty() || !columns.R.empty()) {
        throw std::invalid_argument(
            fmt::format("column nis{}.{} beside innovation{}, S{} or R{}: name one of them", suffix,
                        columns.nis_dim, suffix, suffix, suffix));
      }
      innovation.nu = {columns.nis};
      header_.innovations.push_back(std::move(innovation));
      sensor.dim = sensor.piece = columns.nis_dim;
      return;
    }
    const Index first = columns.first();
    for (Index i = first; i < first + m; ++i) {
      const auto found = columns.nu.find(i);
      if (found == columns.nu.end()) {
        throw std::invalid_argument(fmt::format("column innovation{}.{} is missing", suffix, i));
      }
      innovation.nu.push_back(found->second);
    }
    if (m == 0) throw std::invalid_argument(fmt::format("column innovation{}.1 is missing", suffix));
    innovation.S = symmetric(columns.S, m, "S" + suffix);
    sensor.dim = m;
    // A mark at the first component is refused below.
    sensor.piece = columns.nexts.empty() ? m : std::max<Index>(1, *columns.nexts.begin() - first);
    add_marks(sensor, columns, suffix);
    if (!columns.R.empty()) {
      const Index base = first_number(columns.R);
      for (const auto& [place, unused] : columns.R) {
        innovation.noise_dim =
            std::max({innovation.noise_dim, place.first + 1 - base, place.second + 1 - base});
      }
      if (innovation.noise_dim != sensor.piece) innovation.noise_dim = m;
      innovation.R = symmetric(columns.R, innovation.noise_dim, "R" + suffix);
    }
    header_.innovations.push_back(std::move(innovation));
  }

  /// What repeats in the innovation of a sensor: observations that begin at the marks, and their angles.
  static void add_marks(Sensor& sensor, const SensorColumns& columns, const std::string& suffix) {
    const Index first = columns.first();
    for (Index i = 0; i < sensor.dim; ++i) {
      const bool begins = i > 0 && i % sensor.piece == 0;
      if (columns.nexts.contains(first + i) != begins || sensor.dim % sensor.piece != 0) {
        throw std::invalid_argument(
            fmt::format("columns innovation{}.i:next: {} components are not observations of one dimension "
                        "that begin at the marks",
                        suffix, sensor.dim));
      }
      if (columns.angles.contains(first + i) != columns.angles.contains(first + i % sensor.piece)) {
        throw std::invalid_argument(
            fmt::format("column innovation{}.{}: an angle in one observation and "
                        "not in another of the same sensor",
                        suffix, first + i));
      }
    }
    if (columns.angles.empty()) return;
    for (Index i = 0; i < sensor.piece; ++i) sensor.angles.push_back(columns.angles.contains(first + i));
  }

  std::vector<std::string_view> names_;  // of all columns, in the line
  std::vector<std::string> unknown_;
  FilterLogHeader header_;
  std::set<std::string> states_;
  std::map<std::string, Index> truth_;
  std::set<std::string> angles_of_truth_;  // marked there
  std::vector<StateName> units_;           // those that name one, of estimates, errors and truths
  Entries P_;
  std::vector<std::pair<std::string, Index>> named_P_;
  std::map<std::string, SensorColumns> sensors_;
};

/// Throws for a line that is of another kind of file than names with commas between.
void require_commas(std::string_view line) {
  if (line.starts_with('{') || line.starts_with('[')) {
    throw std::invalid_argument(
        "JSON is not read: write a CSV whose first line names the columns, like "
        "'estimate.x,truth.x,P.1.1', or NumPy arrays (docs/formats.md)");
  }
  if (line.find(',') != std::string_view::npos) return;
  for (const auto& [separator, shown] :
       {std::pair(';', "';'"), std::pair('\t', "tabs"), std::pair(' ', "blanks")}) {
    if (line.find(separator) == std::string_view::npos) continue;
    throw std::invalid_argument(fmt::format(
        "the fields seem to be separated by {} where ',' is expected (and '.' in numbers)", shown));
  }
}

}  // namespace

FilterLogHeader parse_filter_log_header(std::string_view line) {
  require_commas(line);
  HeaderParser parser;
  Index column = 0;
  for (const std::string_view name : comma_fields(line)) parser.add(name, column++);
  return parser.finish(column);
}

}  // namespace credence::internal
