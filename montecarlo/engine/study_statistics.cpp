#include "montecarlo/engine/study_statistics.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace credence {
namespace {

static_assert(std::endian::native == std::endian::little, "stored chunks are little-endian");
constexpr std::uint32_t kFormat = 2;
constexpr std::size_t kStepSize = sizeof(Moments) * static_cast<std::size_t>(Quantity::count_) + 16;
constexpr std::size_t kFailureSize = 20;

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void put(const Moments& m) {
    put(m.count);
    put(m.mean);
    put(m.m2);
  }
  void put(const RunAverages& r) {
    put(r.moments.count);
    put(r.moments.mean);
    put(r.moments.m2);
    put(r.moments.m3);
    put(r.least_dof);
    put(static_cast<std::uint64_t>(r.first.size()));
    for (const double value : r.first) put(value);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    if (bytes_.size() < sizeof(T)) throw std::runtime_error("a stored chunk ends too early");
    T value;
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
    return value;
  }
  Moments get_moments() {
    Moments m;
    m.count = get<std::int64_t>();
    m.mean = get<double>();
    m.m2 = get<double>();
    return m;
  }
  /// A count of items of which each takes at least `item_size` bytes: a wrong one must not allocate.
  std::size_t get_count(std::size_t item_size) {
    const auto n = get<std::uint64_t>();
    if (n > bytes_.size() / item_size) throw std::runtime_error("a stored chunk is shorter than it says");
    return static_cast<std::size_t>(n);
  }
  RunAverages get_run_averages() {
    RunAverages r;
    r.moments.count = get<std::int64_t>();
    r.moments.mean = get<double>();
    r.moments.m2 = get<double>();
    r.moments.m3 = get<double>();
    r.least_dof = get<std::int64_t>();
    r.first.resize(get_count(sizeof(double)));
    for (double& value : r.first) value = get<double>();
    return r;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace

std::string_view to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::ok:
      return "ok";
    case Outcome::diverged:
      return "diverged";
    case Outcome::not_positive_definite:
      return "not_positive_definite";
    case Outcome::threw:
      return "threw";
  }
  return "unknown";
}

void StepStatistics::merge(const StepStatistics& other) {
  for (std::size_t i = 0; i < quantities.size(); ++i) quantities[i].merge(other.quantities[i]);
  nees_dof += other.nees_dof;
  nis_dof += other.nis_dof;
}

void StudyStatistics::merge(const StudyStatistics& other) {
  if (steps.size() != other.steps.size()) {
    throw std::invalid_argument("statistics of studies with different numbers of steps do not add up");
  }
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k].merge(other.steps[k]);
  nees_of_runs.merge(other.nees_of_runs);
  vehicle_nees_of_runs.merge(other.vehicle_nees_of_runs);
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
  runs += other.runs;
}

std::int64_t StudyStatistics::count(Outcome outcome) const {
  if (outcome == Outcome::ok) return runs - static_cast<std::int64_t>(failures.size());
  return std::count_if(failures.begin(), failures.end(),
                       [&](const RunFailure& f) { return f.outcome == outcome; });
}

std::vector<Moments> StudyStatistics::series(Quantity quantity) const {
  std::vector<Moments> result;
  result.reserve(steps.size());
  for (const StepStatistics& step : steps) result.push_back(step[quantity]);
  return result;
}

std::vector<double> StudyStatistics::dofs(Quantity quantity) const {
  if (quantity != Quantity::nees && quantity != Quantity::nis) {
    throw std::invalid_argument("only the dof of NEES and NIS are counted");
  }
  std::vector<double> result;
  result.reserve(steps.size());
  for (const StepStatistics& step : steps) {
    result.push_back(static_cast<double>(quantity == Quantity::nees ? step.nees_dof : step.nis_dof));
  }
  return result;
}

double most_stored_bytes(std::int64_t steps, std::int64_t runs) {
  constexpr double kHead = sizeof(kFormat) + sizeof(std::int64_t) + 2 * sizeof(std::uint64_t);
  constexpr double kAverages = 2 * (5 * sizeof(double) + sizeof(std::uint64_t));
  constexpr double kOfARun = std::max(kFailureSize, 2 * sizeof(double));  // it fails, or has averages
  return kHead + kAverages + static_cast<double>(steps) * kStepSize + static_cast<double>(runs) * kOfARun;
}

std::vector<std::byte> to_bytes(const StudyStatistics& statistics) {
  Writer w;
  w.put(kFormat);
  w.put(statistics.runs);
  w.put(static_cast<std::uint64_t>(statistics.steps.size()));
  for (const StepStatistics& step : statistics.steps) {
    for (const Moments& m : step.quantities) w.put(m);
    w.put(step.nees_dof);
    w.put(step.nis_dof);
  }
  w.put(statistics.nees_of_runs);
  w.put(statistics.vehicle_nees_of_runs);
  w.put(static_cast<std::uint64_t>(statistics.failures.size()));
  for (const RunFailure& f : statistics.failures) {
    w.put(f.run);
    w.put(f.step);
    w.put(f.outcome);
  }
  return w.take();
}

StudyStatistics statistics_from_bytes(std::span<const std::byte> bytes) {
  Reader r(bytes);
  if (r.get<std::uint32_t>() != kFormat) throw std::runtime_error("a stored chunk has another format");
  StudyStatistics s;
  s.runs = r.get<std::int64_t>();
  s.steps.resize(r.get_count(kStepSize));
  for (StepStatistics& step : s.steps) {
    for (Moments& m : step.quantities) m = r.get_moments();
    step.nees_dof = r.get<std::int64_t>();
    step.nis_dof = r.get<std::int64_t>();
  }
  s.nees_of_runs = r.get_run_averages();
  s.vehicle_nees_of_runs = r.get_run_averages();
  s.failures.resize(r.get_count(kFailureSize));
  for (RunFailure& f : s.failures) {
    f.run = r.get<std::int64_t>();
    f.step = r.get<std::int64_t>();
    f.outcome = r.get<Outcome>();
  }
  if (!r.at_end()) throw std::runtime_error("a stored chunk is longer than it says");
  return s;
}

}  // namespace credence
