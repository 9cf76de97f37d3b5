#include "datasets/logs/autopilot/ulog_innovations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <stdexcept>

#include "core/append_item.h"
#include "datasets/data_error.h"
#include "datasets/logs/autopilot/innovation_series.h"
#include "datasets/logs/autopilot/ulog.h"
#include "datasets/logs/autopilot/ulog_states.h"
#include "datasets/logs/partial_read.h"

namespace credence::internal {
namespace {

constexpr std::string_view kInnovations = "estimator_innovations";
constexpr std::string_view kVariances = "estimator_innovation_variances";
constexpr std::string_view kAidSource = "estimator_aid_src_";
constexpr std::string_view kRatios = "estimator_innovation_test_ratios";

bool is_angle(std::string_view name) {
  return name.find("heading") != std::string_view::npos || name.find("yaw") != std::string_view::npos;
}

bool holds_innovations(std::string_view topic) {
  return topic == kInnovations || topic == kVariances || topic == kRatios || topic.starts_with(kAidSource);
}

std::vector<double> numbers(const ByteCursor& message, const UlogField& field) {
  std::vector<double> values(field.count);
  for (std::uint64_t i = 0; i < field.count; ++i) values[i] = ulog_number(message, field, i);
  return values;
}

/// The rows of estimator_innovations and of their variances, which come one after the other.
class InnovationPairs {
 public:
  void add(const UlogTopic& topic, const ByteCursor& message) {
    const double time = ulog_time_s(topic, message);
    const bool is_innovation = topic.name == kInnovations;
    rows_ += is_innovation ? 1 : 0;
    if (is_innovation && rows_ == 1) first_s_ = time;
    last_s_ = std::max(last_s_, time);
    Fields fields;
    for (const UlogField& field : topic.fields) {
      if (field.type == "float") fields.emplace(field.name, numbers(message, field));
    }
    if (order_.empty()) {
      for (const UlogField& field : topic.fields) {
        if (field.type == "float") order_.push_back(field.name);
      }
    }
    std::map<double, Fields>& others = is_innovation ? variances_ : innovations_;
    const auto partner = others.find(time);
    if (partner == others.end()) {
      std::map<double, Fields>& own = is_innovation ? innovations_ : variances_;
      own.insert_or_assign(time, std::move(fields));
      if (own.size() > kWaiting) own.erase(own.begin());
      return;
    }
    join(time, is_innovation ? fields : partner->second, is_innovation ? partner->second : fields);
    others.erase(others.begin(), std::next(partner));
  }

  const InnovationSeries& series() const { return series_; }
  std::int64_t rows() const { return rows_; }
  double rate() const { return message_rate(rows_, first_s_, last_s_); }

 private:
  using Fields = std::map<std::string, std::vector<double>>;
  static constexpr std::size_t kWaiting = 1000;  ///< rows that may wait for the other half

  void join(double time, const Fields& nu, const Fields& variances) {
    for (const std::string& name : order_) {
      const auto n = nu.find(name), v = variances.find(name);
      if (n == nu.end() || v == variances.end() || n->second.size() != v->second.size()) continue;
      if (n->second.empty()) continue;
      series_.add(series_.sensor(name, std::ssize(n->second), is_angle(name)), time, n->second, v->second);
    }
  }

  std::vector<std::string> order_;                    ///< of the fields in a message
  std::map<double, Fields> innovations_, variances_;  ///< by time, waiting
  InnovationSeries series_;
  std::int64_t rows_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
};

/// The topics estimator_aid_src_*, one for each sensor.
class AidSources {
 public:
  void add(const UlogTopic& topic, const ByteCursor& message) {
    const UlogField* const nu = topic.field("innovation");
    const UlogField* const variance = topic.field("innovation_variance");
    if (nu == nullptr || variance == nullptr || nu->count != variance->count || nu->count == 0) return;
    const std::string name = topic.name.substr(kAidSource.size());
    const std::size_t sensor = series_.sensor(name, static_cast<Index>(nu->count), is_angle(name));
    const InnovationSeries::Row row =
        series_.add(sensor, ulog_time_s(topic, message), numbers(message, *nu), numbers(message, *variance));
    ++rows_;
    if (row != InnovationSeries::Row::taken) return;
    const UlogField* const rejected = topic.field("innovation_rejected");
    if (rejected != nullptr && ulog_number(message, *rejected) != 0.0) ++rejected_;
  }

  const InnovationSeries& series() const { return series_; }
  std::int64_t rows() const { return rows_; }
  std::int64_t rejected() const { return rejected_; }

 private:
  InnovationSeries series_;
  std::int64_t rows_ = 0, rejected_ = 0;
};

/// A field of estimator_innovation_test_ratios that is NIS / gate² of an innovation of one dimension. Of two
/// dimensions EKF2 writes the larger ratio of the two, which is no NIS.
struct RatioField {
  std::string_view field, gate;
  double default_gate;  ///< EKF2's own, in standard deviations
};

constexpr RatioField kRatioFields[] = {
    {"gps_vvel", "EKF2_GPS_V_GATE", 5.0}, {"gps_vpos", "EKF2_GPS_P_GATE", 5.0},
    {"ev_vvel", "EKF2_EVV_GATE", 3.0},    {"ev_vpos", "EKF2_EVP_GATE", 5.0},
    {"rng_vpos", "EKF2_RNG_GATE", 5.0},   {"baro_vpos", "EKF2_BARO_GATE", 5.0},
    {"heading", "EKF2_HDG_GATE", 2.6},    {"mag_field", "EKF2_MAG_GATE", 3.0},
    {"airspeed", "EKF2_TAS_GATE", 3.0},
};

using GateParameters = std::map<std::string, double, std::less<>>;

/// The rows of estimator_innovation_test_ratios, for logs without innovation variances.
class TestRatios {
 public:
  void add(const UlogTopic& topic, const ByteCursor& message, const GateParameters& gates) {
    ++rows_;
    const double time = ulog_time_s(topic, message);
    for (const RatioField& known : kRatioFields) {
      const UlogField* const field = topic.field(known.field);
      if (field == nullptr || field->type != "float") continue;
      const auto set = gates.find(known.gate);
      const double gate = std::max(1.0, set == gates.end() ? known.default_gate : set->second);
      for (std::uint64_t i = 0; i < field->count; ++i) {
        const std::string name =
            field->count == 1 ? std::string(known.field) : fmt::format("{}.{}", known.field, i + 1);
        series_.add_nis(series_.nis_sensor(name), time, gate * gate * ulog_number(message, *field, i));
      }
      if (set == gates.end()) assumed_.insert(fmt::format("{} {:g}", known.gate, known.default_gate));
    }
  }

  const InnovationSeries& series() const { return series_; }
  std::int64_t rows() const { return rows_; }
  /// "EKF2_GPS_P_GATE 5, …" of the gates that the log did not hold.
  const std::set<std::string>& assumed() const { return assumed_; }

 private:
  std::set<std::string> assumed_;
  InnovationSeries series_;
  std::int64_t rows_ = 0;
};

/// What one of the estimators wrote.
struct Estimator {
  InnovationPairs pairs;
  AidSources sources;
  TestRatios ratios;

  bool has_sources() const { return !sources.series().empty(); }
  bool has_ratios_alone() const { return !has_sources() && pairs.series().empty(); }
  const InnovationSeries& series() const {
    return has_sources() ? sources.series() : has_ratios_alone() ? ratios.series() : pairs.series();
  }
};

struct UlogInnovations {
  GateParameters gates;
  std::map<int, Estimator> estimators;  ///< by instance
  std::int64_t dropouts = 0;
  double dropped_s = 0.0;
};

UlogInnovations read_innovations(const std::filesystem::path& file, const LogReadOptions& options,
                                 LogSink& sink) {
  UlogInnovations result;
  std::map<std::size_t, UlogTopic> topics;
  const UlogVisitor visitor{
      .topic =
          [&](std::size_t i, const UlogTopic& topic) {
            if (holds_innovations(topic.name)) topics.emplace(i, topic);
          },
      .message =
          [&](std::size_t i, const ByteCursor& message) {
            const auto found = topics.find(i);
            if (found == topics.end()) return;
            const UlogTopic& topic = found->second;
            const UlogField* const field = topic.field("estimator_instance");
            const int instance =
                field != nullptr ? estimator_number(ulog_number(message, *field), message) : topic.instance;
            Estimator& estimator = result.estimators[instance];
            if (topic.name.starts_with(kAidSource)) {
              estimator.sources.add(topic, message);
            } else if (topic.name == kRatios) {
              estimator.ratios.add(topic, message, result.gates);
            } else {
              estimator.pairs.add(topic, message);
            }
          },
      .dropout =
          [&](double seconds) {
            ++result.dropouts;
            result.dropped_s += seconds;
          },
      .advance = [&](std::int64_t bytes) { sink.advance(bytes); },
      .parameter =
          [&](std::string_view name, double value) {
            if (name.ends_with("_GATE")) result.gates.insert_or_assign(std::string(name), value);
          }};
  read_part(
      options, sink, [&] { read_ulog(file, visitor); }, [&] { return !result.estimators.empty(); });
  return result;
}

std::string instances(const UlogInnovations& log) {
  std::string text;
  for (const auto& [instance, estimator] : log.estimators) {
    if (!estimator.series().empty()) append_item(text, std::to_string(instance));
  }
  return text;
}

/// "1279 rows of …; what they only repeat is no new innovation, which"
std::string source_text(const Estimator& estimator) {
  constexpr const char* kRepeats = "what is only repeated is no new innovation, which";
  if (estimator.has_sources())
    return fmt::format("{} of estimator_aid_src_*; {}", counted(estimator.sources.rows(), "row"), kRepeats);
  if (estimator.has_ratios_alone())
    return fmt::format("{} of {} and no innovation variances; {}", counted(estimator.ratios.rows(), "row"),
                       kRatios, kRepeats);
  const double rate = estimator.pairs.rate();
  return fmt::format("{} of {}{}; {}", counted(estimator.pairs.rows(), "row"), kInnovations,
                     std::isfinite(rate) ? fmt::format(" at {:.3g} Hz", rate) : "", kRepeats);
}

void tell_ratios(const TestRatios& ratios, LogSink& sink) {
  sink.remark(
      "Of the innovations test ratios alone are known: NIS = ratio × gate². That tells the mean NIS of a "
      "sensor, its law, its gate and whether NIS are correlated in time; a bias, the sign of a correlation "
      "and correlations between sensors it does not tell. Of sensors of two dimensions (horizontal velocity "
      "and position, flow) the log holds the larger ratio of the two, which is no NIS: they are not judged.");
  if (!ratios.assumed().empty()) {
    sink.remark(
        fmt::format("The log does not hold the gates {}: these values, EKF2's own, are taken, and NIS goes "
                    "with their square.",
                    fmt::join(ratios.assumed(), ", ")));
  }
}

void tell(int instance, const Estimator& estimator, const UlogInnovations& log, LogSink& sink) {
  const InnovationSeries& series = estimator.series();
  sink.remark(source_text(estimator) + fmt::format(" leaves {}.", series.counts()));
  if (estimator.has_ratios_alone()) tell_ratios(estimator.ratios, sink);
  if (estimator.sources.rejected() > 0) {
    sink.remark(fmt::format("{} of these innovations did not pass the filter's gate; {} judged too.",
                            estimator.sources.rejected(),
                            estimator.sources.rejected() == 1 ? "it is" : "they are"));
  }
  if (const std::string names = instances(log); names.find(',') != std::string::npos) {
    sink.remark(fmt::format("Estimators {} ran side by side; judged is {} (--instance N judges another).",
                            names, instance));
  }
  if (const std::string sensors = series.never_repeated(); !sensors.empty()) {
    sink.remark(
        fmt::format("No value of {} is repeated: the log may leave values out between its rows. NIS and its "
                    "law are not touched; lag k of a correlation is then not k measurements.",
                    sensors));
  }
  if (series.any_vector()) {
    sink.remark(
        "The log holds variances and no covariances: the components of a sensor are judged as if they were "
        "independent.");
  }
  if (log.dropouts > 0) {
    sink.remark(fmt::format("{} nothing could be written, for {:.3g} s in all.",
                            counted(log.dropouts, "time"), log.dropped_s));
  }
}

void read_flight(const std::filesystem::path& file, const LogReadOptions& options, LogSink& sink) {
  if (options.truth_topic == kUlogTruth) return judge_ulog_states(file, options, sink);
  if (!options.truth_topic.empty()) {
    throw std::invalid_argument(fmt::format("{}: --truth-topic {}: of a flight log accepted is {}",
                                            file.string(), options.truth_topic, kUlogTruth));
  }
  const UlogInnovations log = read_innovations(file, options, sink);
  const std::string names = instances(log);
  if (names.empty()) {
    throw DataError(file, "",
                    "holds no innovations: read are estimator_innovations with "
                    "estimator_innovation_variances, estimator_aid_src_*, or test ratios, "
                    "estimator_innovation_test_ratios (set SDLOG_PROFILE to log them)");
  }
  auto chosen = std::ranges::find_if(log.estimators, [&](const auto& e) {
    return !e.second.series().empty() && (!options.instance || e.first == *options.instance);
  });
  if (chosen == log.estimators.end()) {
    throw std::invalid_argument(
        fmt::format("{}: --instance {}: there are {}", file.string(), *options.instance, names));
  }
  tell(chosen->first, chosen->second, log, sink);
  chosen->second.series().emit(sink);
}

LogContents list_flight(const std::filesystem::path& file) {
  struct Seen {
    UlogTopic topic;
    std::int64_t count = 0;
    double first_s = 0.0, last_s = 0.0;
  };
  std::vector<Seen> seen;
  const UlogVisitor visitor{
      .topic = [&](std::size_t, const UlogTopic& topic) { seen.push_back({topic}); },
      .message =
          [&](std::size_t i, const ByteCursor& message) {
            Seen& s = seen[i];
            const UlogField* const stamp = s.topic.field("timestamp");
            if (stamp != nullptr) s.last_s = 1e-6 * ulog_number(message, *stamp);
            if (s.count++ == 0) s.first_s = s.last_s;
          },
  };
  read_ulog(file, visitor);
  LogContents contents;
  for (const Seen& s : seen) {
    contents.topics.push_back(
        {.name = s.topic.name,
         .type = fmt::format("instance {}", s.topic.instance),
         .count = s.count,
         .rate_hz = message_rate(s.count, s.first_s, s.last_s),
         .use = holds_innovations(s.topic.name)      ? "innovations"
                : s.topic.name == kUlogTruth         ? "truth"
                : s.topic.name == "estimator_states" ? "estimate"
                                                     : "",
         .covariance = s.topic.name == kVariances || s.topic.name.starts_with(kAidSource)});
  }
  return contents;
}

}  // namespace

LogFormat ulog_format() {
  return {.name = "ulog",
          .title = "PX4 ULog",
          .extensions = ".ulg",
          .holds_truth = true,
          .has_instances = true,
          .recognises = [](std::string_view beginning,
                           const std::filesystem::path&) { return begins_as_ulog(beginning); },
          .list = list_flight,
          .read = read_flight};
}

}  // namespace credence::internal
