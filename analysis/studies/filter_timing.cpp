#include "analysis/studies/filter_timing.h"

#include <algorithm>
#include <concepts>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "analysis/studies/textbook_ekf.h"
#include "core/enum_words.h"
#include "core/filters/block_map_ekf_slam.h"
#include "core/filters/ekf_slam.h"
#include "core/parallel_tasks.h"
#include "montecarlo/engine/engine.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/worlds/monobot/plain_monobot.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

const Eigen::Matrix2d kControlNoise = Eigen::Vector2d(0.01, 0.0025).asDiagonal();
const Eigen::Matrix2d kMeasurementNoise = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
const Eigen::Matrix3d kPoseCovariance = 0.01 * Eigen::Matrix3d::Identity();

/// Bytes of the heap in use.
std::optional<double> heap_in_use() {
#if defined(__GLIBC__)
  const auto info = mallinfo2();
  if (info.uordblks > 0) return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
#endif
  return std::nullopt;  // also where a sanitizer keeps the heap
}

/// A ring of landmarks around the vehicle, which stands still; each step sees the next few, at no innovation.
template <class Filter>
class Ring {
 public:
  Ring(Filter filter, Index landmarks, Index observed)
      : filter_(std::move(filter)), landmarks_(landmarks), seen_(static_cast<std::size_t>(observed)) {}

  void steps(std::int64_t count) {
    for (std::int64_t k = 0; k < count; ++k) {
      filter_.predict(Control::Zero());
      for (Observation<PlanarModel>& z : seen_) {
        z.landmark = static_cast<int>(next_);
        next_ = next_ + 1 == landmarks_ ? 0 : next_ + 1;
        z.z = measure_range_bearing(filter_.pose(), position(filter_.offset_of(z.landmark)));
      }
      if (!filter_.update(seen_).ok) throw std::runtime_error("a timed filter lost its covariance");
    }
  }

 private:
  /// The O(N) filter brings its whole state up to date when that is asked for.
  Point position(Index offset) const {
    if constexpr (std::same_as<Filter, BlockMapEkfSlam<PlanarModel>>) {
      return filter_.position(offset);
    } else {
      return filter_.state().template segment<2>(offset);
    }
  }

  Filter filter_;
  Index landmarks_, next_ = 0;
  std::vector<Observation<PlanarModel>> seen_;
};

/// What the first observation of the ring from a pose of covariance kPoseCovariance tells.
struct FirstObservation {
  explicit FirstObservation(Index landmarks) : x(Vector::Zero(3 + 2 * landmarks)) {
    for (Index i = 0; i < landmarks; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(landmarks);
      placed.push_back(PlanarModel::place(Pose::Zero(), {10.0, wrap_angle(angle)}));
      x.segment<2>(3 + 2 * i) = placed.back().position;
      ids.push_back(static_cast<int>(i));
    }
  }

  Eigen::Matrix2d own(Index i) const {
    const Eigen::Matrix2d& J_z = placed[static_cast<std::size_t>(i)].J_z;
    return J_z * kMeasurementNoise * J_z.transpose();
  }

  Vector x;
  std::vector<int> ids;
  std::vector<PlacedLandmark> placed;
};

template <class Filter>
Ring<Filter> dense_ring(Index landmarks, Index observed) {
  const FirstObservation observation(landmarks);
  Matrix J = Matrix::Zero(3 + 2 * landmarks, 3);
  J.topRows<3>().setIdentity();
  for (Index i = 0; i < landmarks; ++i) {
    J.middleRows<2>(3 + 2 * i) = observation.placed[static_cast<std::size_t>(i)].J_r;
  }
  Matrix P = J * kPoseCovariance * J.transpose();
  for (Index i = 0; i < landmarks; ++i) P.block<2, 2>(3 + 2 * i, 3 + 2 * i) += observation.own(i);
  Filter filter({.vehicle = {}, .dt_s = 0.1}, kControlNoise, kMeasurementNoise);
  filter.reset(observation.x, P, observation.ids);
  return Ring<Filter>(std::move(filter), landmarks, observed);
}

/// With N times what the landmarks share of the pose's variance, which is no less than all their
/// correlations.
Ring<BlockMapEkfSlam<PlanarModel>> block_ring(Index landmarks, Index observed, MapBound bound) {
  const FirstObservation observation(landmarks);
  ArrowCovariance P(3, 2);
  P.set_vehicle(kPoseCovariance);
  P.reserve(landmarks);
  for (Index i = 0; i < landmarks; ++i) {
    const auto& J_r = observation.placed[static_cast<std::size_t>(i)].J_r;
    const Eigen::Matrix2d shared = J_r * kPoseCovariance * J_r.transpose();
    P.append(kPoseCovariance * J_r.transpose(), observation.own(i) + static_cast<double>(landmarks) * shared);
  }
  BlockMapEkfSlam<PlanarModel> filter({.vehicle = {}, .dt_s = 0.1}, kControlNoise, kMeasurementNoise, bound);
  filter.reset(observation.x, std::move(P), observation.ids);
  return {std::move(filter), landmarks, observed};
}

/// Work, and what it holds.
struct RingWork {
  TimedWork steps;
  std::optional<double> bytes;
};

template <class MakeRing>
RingWork ring_work(std::int64_t period, MakeRing make) {
  const std::optional<double> before = heap_in_use();
  const auto ring = std::make_shared<decltype(make())>(make());
  ring->steps(1);
  const std::optional<double> after = heap_in_use();
  RingWork work{.steps = {.work = [ring](std::int64_t count) { ring->steps(count); }, .period = period},
                .bytes = {}};
  if (before && after) work.bytes = *after - *before;
  return work;
}

/// The dense filter passes over its map once for several steps, at most so many.
constexpr std::int64_t kDensePeriod = DelayedCovariance::kMostWaiting / 2;

/// The O(N) filter brings its map together now and then, at √(N/14) landmarks measured: over so many steps
/// that evens out.
constexpr std::int64_t kBlockPeriod = 512;

RingWork make_ring_work(TimedFilter filter, Index landmarks, Index observed) {
  switch (filter) {
    case TimedFilter::full:
      return ring_work(kDensePeriod, [&] { return dense_ring<EkfSlam<PlanarModel>>(landmarks, observed); });
    case TimedFilter::naive:
      return ring_work(1, [&] { return dense_ring<TextbookEkf>(landmarks, observed); });
    case TimedFilter::map:
      return ring_work(kBlockPeriod, [&] { return block_ring(landmarks, observed, MapBound::least_trace); });
    case TimedFilter::batch:
      return ring_work(kBlockPeriod, [&] { return block_ring(landmarks, observed, MapBound::batch); });
  }
  return {};
}

void require_valid(const FilterTimingPlan& plan) {
  for (const auto* numbers : {&plan.landmarks, &plan.observed}) {
    if (numbers->empty() || *std::ranges::min_element(*numbers) < 1) {
      throw std::invalid_argument("timing needs numbers of landmarks, and of landmarks observed, from 1 on");
    }
  }
  if (*std::ranges::max_element(plan.landmarks) < *std::ranges::min_element(plan.observed)) {
    throw std::invalid_argument("no map (landmarks) is as large as what is to be observed of it (observed)");
  }
}

/// `runs` runs of a scenario by the engine, the same each time.
TimedWork engine_work(Scenario scenario, std::int64_t runs, int threads, double items) {
  scenario.study.runs = runs;
  const std::shared_ptr<const Experiment> experiment = make_experiment(scenario);
  return {.work =
              [experiment, runs, threads](std::int64_t times) {
                const StudyTask task{"", experiment.get(), runs};
                for (std::int64_t i = 0; i < times; ++i) run_studies({&task, 1}, {.threads = threads});
              },
          .items = items,
          .clock = TimedClock::wall};
}

/// One step of one run, one normal, and one step of the plain loop, in the order of MonteCarloTimes.
std::vector<TimedWork> monte_carlo_works() {
  constexpr std::int64_t kRuns = 6400, kPlainRuns = 16, kNormalSteps = 32;
  constexpr std::size_t kStudySteps = 100;
  Scenario monobot = default_scenario("monobot");
  monobot.world.landmarks = 1;
  monobot.study.steps = kStudySteps;
  const auto normals = std::make_shared<std::vector<double>>(2 * kNormalSteps * NoiseSource::kLanes);
  TimedWork draw{
      .work =
          [normals, source = NoiseSource(1, 0), step = std::int64_t{1}](std::int64_t times) mutable {
            for (std::int64_t i = 0; i < times; ++i) {
              source.normals_of_runs(0, step, kNormalSteps, NoisePurpose::process, 2, *normals);
              step = (step + kNormalSteps) % (1 << 20);
            }
          },
      .items = static_cast<double>(normals->size())};
  TimedWork plain{.work =
                      [generator = std::mt19937_64(1)](std::int64_t times) mutable {
                        std::vector<Moments> nees(kStudySteps), nis(kStudySteps);
                        run_plain_monobot(1, times * kPlainRuns, generator, nees, nis);
                      },
                  .items = static_cast<double>(kPlainRuns * kStudySteps)};
  TimedWork engine = engine_work(monobot, kRuns, 1, static_cast<double>(kRuns * kStudySteps));
  engine.clock = TimedClock::thread;
  return {engine, draw, plain};
}

Scenario planar_ten() {
  Scenario scenario = default_scenario("planar");
  scenario.world.landmarks = 10;
  return scenario;
}

/// One and all processors, and the powers of two between.
std::vector<int> thread_numbers() {
  std::vector<int> threads;
  for (int t = 1; t < thread_count(0); t *= 2) threads.push_back(t);
  threads.push_back(thread_count(0));
  return threads;
}

using Progress = std::function<void(std::int64_t done, std::int64_t total)>;

/// The filters of a plan, not yet timed.
std::vector<FilterTime> planned_filters(const FilterTimingPlan& plan) {
  std::vector<FilterTime> filters;
  for (const Index observed : plan.observed) {
    for (const TimedFilter filter : kTimedFilters) {
      for (const Index landmarks : plan.landmarks) {
        if (landmarks >= observed && landmarks <= largest_map(filter)) {
          filters.push_back({filter, landmarks, observed, {}, {}});
        }
      }
    }
  }
  return filters;
}

/// The work of each filter, whose memory is noted. Empty when stopped.
std::vector<TimedWork> filter_works(std::vector<FilterTime>& filters, const std::atomic<bool>* stop,
                                    const std::function<void()>& made) {
  std::vector<TimedWork> works;
  for (FilterTime& filter : filters) {
    if (stop != nullptr && stop->load()) return {};
    RingWork ring = make_ring_work(filter.filter, filter.landmarks, filter.observed);
    works.push_back(std::move(ring.steps));
    filter.bytes = ring.bytes;
    made();
  }
  return works;
}

/// That of Monte Carlo, then the engine with each number of threads.
std::vector<TimedWork> other_works(std::span<const int> threads) {
  std::vector<TimedWork> works = monte_carlo_works();
  for (const int t : threads) {
    const std::int64_t runs = 8 * kChunkRuns * t;
    works.push_back(engine_work(planar_ten(), runs, t, static_cast<double>(runs)));
  }
  return works;
}

}  // namespace

std::string_view to_string(TimedFilter filter) { return word_of(filter, {"full", "naive", "map", "batch"}); }

Index largest_map(TimedFilter filter) {
  switch (filter) {
    case TimedFilter::full: return 3000;
    case TimedFilter::naive: return 1000;
    case TimedFilter::map:
    case TimedFilter::batch: return 1'000'000;
  }
  return 0;
}

std::vector<FilterTime> time_filter_steps(const FilterTimingPlan& plan, const std::atomic<bool>* stop) {
  require_valid(plan);
  std::vector<FilterTime> filters = planned_filters(plan);
  const std::vector<TimedWork> works = filter_works(filters, stop, [] {});
  if (works.empty()) return {};
  const std::vector<MeasuredTime> times = time_interleaved(works, plan.timing, stop);
  if (times.empty()) return {};
  for (std::size_t i = 0; i < filters.size(); ++i) filters[i].step = times[i];
  return filters;
}

TimingResult time_filters(const FilterTimingPlan& plan, const std::atomic<bool>* stop,
                          const Progress& progress) {
  require_valid(plan);
  TimingResult result;
  result.machine = describe_machine();
  result.plan = plan.timing;
  std::vector<FilterTime> filters = planned_filters(plan);
  const std::vector<int> threads = thread_numbers();
  const std::vector<TimedWork> others = other_works(threads);
  // Making a filter counts as one timing.
  const std::int64_t makings = std::ssize(filters);
  const std::int64_t timings = (plan.timing.repetitions + 1) * (makings + std::ssize(others));
  const auto tell = [&](std::int64_t done) {
    if (progress) progress(done, makings + timings);
  };
  std::vector<TimedWork> works =
      filter_works(filters, stop, [&, made = std::int64_t{0}]() mutable { tell(++made); });
  if (works.empty()) return result;
  works.insert(works.end(), others.begin(), others.end());
  const std::vector<MeasuredTime> times = time_interleaved(
      works, plan.timing, stop, [&](std::int64_t done, std::int64_t) { tell(makings + done); });
  if (times.empty()) return result;
  result.filters = std::move(filters);
  std::size_t next = 0;
  for (FilterTime& filter : result.filters) filter.step = times[next++];
  for (MeasuredTime* time :
       {&result.monte_carlo.step, &result.monte_carlo.normal, &result.monte_carlo.reference_step}) {
    *time = times[next++];
  }
  for (const int t : threads) result.scaling.push_back({t, times[next++]});
  result.growth = fit_growth(result.filters);
  result.crossovers = find_crossovers(result.filters);
  result.complete = static_cast<int>(times.front().repetitions.size()) == plan.timing.repetitions;
  return result;
}

}  // namespace credence::internal
