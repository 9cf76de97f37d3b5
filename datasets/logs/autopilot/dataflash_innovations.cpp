#include "datasets/logs/autopilot/dataflash_innovations.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/append_item.h"
#include "datasets/data_error.h"
#include "datasets/logs/autopilot/dataflash.h"
#include "datasets/logs/autopilot/innovation_series.h"
#include "datasets/logs/partial_read.h"

namespace credence::internal {
namespace {

/// Innovations that pass a gate together.
struct GatedGroup {
  std::string_view name;
  std::array<std::string_view, 3> fields;  ///< of XKF3; "" for none
  std::string_view ratio;                  ///< of XKF4
  std::string_view gate;                   ///< of the parameters, without EK3_
  double default_gate;                     ///< in hundredths
};

// The ratio of the magnetometer is the largest of its components': no NIS.
constexpr GatedGroup kGroups[] = {
    {"velocity", {"IVN", "IVE", "IVD"}, "SV", "VEL_I_GATE", 500.0},
    {"position", {"IPN", "IPE", ""}, "SP", "POS_I_GATE", 500.0},
    {"height", {"IPD", "", ""}, "SH", "HGT_I_GATE", 500.0},
    {"airspeed", {"IVT", "", ""}, "SVT", "EAS_I_GATE", 400.0},
};

Index dim_of(const GatedGroup& group) {
  return std::ssize(group.fields) - std::ranges::count(group.fields, std::string_view());
}

/// One core of one estimator: which innovations came last, and all that could be joined.
struct EstimatorCore {
  EstimatorCore() {
    for (const GatedGroup& group : kGroups) series.sensor(std::string(group.name), dim_of(group), false);
  }

  std::map<std::string, double> innovations;  ///< of XKF3, by field
  double time_us = -1.0;                      ///< theirs
  InnovationSeries series;
  std::int64_t rows = 0, clamped = 0;
};

/// Gathers what the messages of one estimator say.
class DataflashCollector {
 public:
  /// prefix: "X" of EKF3, "N" of EKF2.
  explicit DataflashCollector(char prefix)
      : innovations_(fmt::format("{}KF3", prefix)),
        ratios_(fmt::format("{}KF4", prefix)),
        parameters_(prefix == 'X' ? "EK3_" : "EK2_") {}

  void add(const DataflashTopic& topic, const ByteCursor& body) {
    if (topic.name == "PARM") return parameter(topic, body);
    const bool first = topic.name == innovations_;
    if (!first && topic.name != ratios_) return;
    const DataflashTopic::Field* const time = topic.field("TimeUS");
    const DataflashTopic::Field* const number = topic.field("C");
    if (time == nullptr) return;
    EstimatorCore& core =
        cores_[number == nullptr ? 0 : estimator_number(dataflash_number(body, *number), body)];
    const double time_us = dataflash_number(body, *time);
    if (first) {
      core.time_us = time_us;
      core.innovations.clear();
      for (const DataflashTopic::Field& field : topic.fields) {
        if (field.name.starts_with('I')) core.innovations[field.name] = dataflash_number(body, field);
      }
    } else if (core.time_us == time_us) {
      ++core.rows;
      for (std::size_t g = 0; g < std::size(kGroups); ++g) join(core, g, topic, body);
    }
  }

  const std::map<int, EstimatorCore>& cores() const { return cores_; }

  bool empty() const {
    return std::ranges::all_of(cores_, [](const auto& core) { return core.second.series.empty(); });
  }

  /// "EK3_VEL_I_GATE, …" of those that the log does not hold; "" for none.
  std::string gates_assumed() const {
    std::string text;
    for (const GatedGroup& group : kGroups) {
      if (gates_.contains(std::string(group.gate))) continue;
      append_item(text, fmt::format("{}{} {:g}", parameters_, group.gate, group.default_gate));
    }
    return text;
  }

 private:
  void parameter(const DataflashTopic& topic, const ByteCursor& body) {
    const DataflashTopic::Field* const name = topic.field("Name");
    const DataflashTopic::Field* const value = topic.field("Value");
    if (name == nullptr || value == nullptr) return;
    const std::string text = dataflash_text(body, *name);
    if (text.starts_with(parameters_) && text.ends_with("_I_GATE")) {
      gates_[text.substr(parameters_.size())] = dataflash_number(body, *value);
    }
  }

  void join(EstimatorCore& core, std::size_t g, const DataflashTopic& topic, const ByteCursor& body) const {
    constexpr double kLargest = 327.665;  // nearly 32767 hundredths
    const GatedGroup& group = kGroups[g];
    const DataflashTopic::Field* const field = topic.field(group.ratio);
    if (field == nullptr) return;
    const double written = dataflash_number(body, *field);
    // Anything below 0.005 is written as 0, which no NIS is. Of silent sensors nothing else is written.
    const double least = 0.005 / std::sqrt(3.0), root = std::max(written, least);  // the root mean square
    std::vector<double> nu, written_row{written};
    double square = 0.0;
    for (const std::string_view name : group.fields) {
      if (name.empty()) continue;
      const auto found = core.innovations.find(std::string(name));
      if (found == core.innovations.end()) return;
      nu.push_back(found->second);
      written_row.push_back(found->second);
      square += found->second * found->second;
    }
    if (root >= kLargest) ++core.clamped;
    const auto set = gates_.find(std::string(group.gate));
    const double gate = std::max(1.0, 0.01 * (set == gates_.end() ? group.default_gate : set->second));
    const auto m = static_cast<double>(nu.size());
    const double nis = m * std::pow(root * gate, 2);
    for (double& component : nu) {
      component = square > 0.0 ? component * std::sqrt(nis / square) : std::sqrt(nis / m);
    }
    core.series.add(g, 1e-6 * core.time_us, nu, std::vector<double>(nu.size(), 1.0), written_row);
  }

  std::string innovations_, ratios_, parameters_;
  std::map<std::string, double> gates_;
  std::map<int, EstimatorCore> cores_;
};

void read_cores(const std::filesystem::path& file, const LogReadOptions& options, LogSink& sink) {
  DataflashCollector ekf3('X'), ekf2('N');
  std::map<std::uint8_t, DataflashTopic> topics;
  const DataflashVisitor visitor{
      .topic = [&](std::uint8_t type, const DataflashTopic& topic) { topics[type] = topic; },
      .message =
          [&](std::uint8_t type, const ByteCursor& body) {
            const auto topic = topics.find(type);
            if (topic == topics.end()) return;
            ekf3.add(topic->second, body);
            ekf2.add(topic->second, body);
          },
      .advance = [&](std::int64_t bytes) { sink.advance(bytes); }};
  read_part(
      options, sink, [&] { read_dataflash(file, visitor); }, [&] { return !ekf3.empty() || !ekf2.empty(); });
  if (ekf3.empty() && ekf2.empty()) {
    throw DataError(file, "",
                    "holds no innovations with test ratios: read are XKF3 with XKF4 of EKF3, and NKF3 with "
                    "NKF4 of EKF2 (LOG_BITMASK logs them)");
  }
  const DataflashCollector& judged = ekf3.empty() ? ekf2 : ekf3;
  std::string names;
  const EstimatorCore* chosen = nullptr;
  int number = 0;
  for (const auto& [i, core] : judged.cores()) {
    if (core.series.empty()) continue;
    append_item(names, std::to_string(i));
    if (chosen != nullptr || (options.instance && *options.instance != i)) continue;
    chosen = &core;
    number = i;
  }
  if (chosen == nullptr) {
    throw std::invalid_argument(
        fmt::format("{}: --instance {}: there are {}", file.string(), *options.instance, names));
  }
  sink.remark(fmt::format("{} of {}; what is only repeated is no new innovation, which leaves {}.",
                          counted(chosen->rows, "row"), ekf3.empty() ? "NKF3 with NKF4" : "XKF3 with XKF4",
                          chosen->series.counts()));
  sink.remark(
      "The log holds no innovation variances, but test ratios Σν²/(gate² ΣS) of groups: a mean NIS and its "
      "factor follow from them for each group as a whole, and of groups of several components the law only "
      "if their variances are equal.");
  sink.remark(
      "Innovations and roots of test ratios are written in steps of 0.01: where many NIS are equal for it, "
      "their fit to the law is not tested; and an innovation that is equal to the one before may be lost as "
      "a repeat.");
  if (const std::string gates = judged.gates_assumed(); !gates.empty()) {
    sink.remark(
        fmt::format("The log does not hold the gates {}: these values, ArduPilot's own, are taken, and NIS "
                    "goes with their square.",
                    gates));
  }
  if (chosen->clamped > 0) {
    sink.remark(
        fmt::format("{} {} clamped at the largest number of the field: NIS is at least what is shown.",
                    counted(chosen->clamped, "test ratio"), chosen->clamped == 1 ? "is" : "are"));
  }
  if (names.find(',') != std::string::npos) {
    sink.remark(
        fmt::format("Cores {} ran side by side; judged is {} (--instance N judges another).", names, number));
  }
  chosen->series.emit(sink);
}

LogContents list_messages(const std::filesystem::path& file) {
  struct Seen {
    DataflashTopic topic;
    std::int64_t count = 0;
    double first_s = 0.0, last_s = 0.0;
  };
  std::map<std::uint8_t, Seen> seen;
  const DataflashVisitor visitor{
      .topic = [&](std::uint8_t type, const DataflashTopic& topic) { seen[type].topic = topic; },
      .message =
          [&](std::uint8_t type, const ByteCursor& body) {
            const auto found = seen.find(type);
            if (found == seen.end()) return;
            Seen& s = found->second;
            const DataflashTopic::Field* const stamp = s.topic.field("TimeUS");
            if (stamp != nullptr) s.last_s = 1e-6 * dataflash_number(body, *stamp);
            if (s.count++ == 0) s.first_s = s.last_s;
          }};
  read_dataflash(file, visitor);
  LogContents contents;
  for (const auto& [type, s] : seen) {
    if (s.count == 0) continue;
    const bool used =
        s.topic.name == "XKF3" || s.topic.name == "XKF4" || s.topic.name == "NKF3" || s.topic.name == "NKF4";
    contents.topics.push_back({.name = s.topic.name,
                               .type = fmt::format("{} fields", s.topic.fields.size()),
                               .count = s.count,
                               .rate_hz = message_rate(s.count, s.first_s, s.last_s),
                               .use = used ? "innovations" : "",
                               .covariance = s.topic.name.ends_with("KF4")});
  }
  return contents;
}

}  // namespace

LogFormat dataflash_format() {
  return {.name = "dataflash",
          .title = "ArduPilot DataFlash",
          .extensions = ".bin",
          .has_instances = true,
          .recognises = [](std::string_view beginning,
                           const std::filesystem::path&) { return begins_as_dataflash(beginning); },
          .list = list_messages,
          .read = read_cores};
}

}  // namespace credence::internal
