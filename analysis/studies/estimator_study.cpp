#include "analysis/studies/estimator_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "analysis/laws/run_mean.h"
#include "analysis/laws/student_positive_mean.h"
#include "analysis/stability/observability_stack.h"
#include "core/filters/estimators/estimators.h"
#include "core/version.h"
#include "montecarlo/engine/byte_stream.h"
#include "montecarlo/engine/shared_tasks.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/planar_slam/estimator_run.h"

namespace credence {
namespace {

constexpr std::int64_t kRunsOfTask = 8;
constexpr std::int64_t kMostWindows = 100;
/// Numbers kept of all windows together.
constexpr std::int64_t kMostWindowValues = 40'000'000;

constexpr std::size_t at(EstimatorBlock block) { return static_cast<std::size_t>(block); }

/// What is kept of one estimator in every run.
struct Kept {
  std::vector<std::optional<EstimatorRunValues>> values;  ///< by run; none where it failed
  std::vector<RunFailure> failures;                       ///< by run, outcome ok where there is none
  std::vector<float> windows;                             ///< of run r from r · windows on
};

/// The sums of one estimator on its way through one run.
class RunSums {
 public:
  void start() { *this = RunSums(); }

  /// False where P is no covariance.
  bool add(const EstimatorRun& run, Index k) {
    using enum EstimatorBlock;
    const SlamEstimator& filter = run.filter();
    const MatrixRef P = filter.covariance();
    const Eigen::Matrix3d P_plane = filter.plane_pose_covariance();
    const VectorRef e = run.error();
    const Pose plane = run.plane_error();
    bool ok = take(chart_position, e.head(2), P.topLeftCorner(2, 2)) &&
              take(heading, e.segment(2, 1), P.block(2, 2, 1, 1)) &&
              take(pose, e.head(3), P.topLeftCorner(3, 3));
    if (filter.chart() == ErrorChart::plane) {
      copy(chart_position, position);
      copy(pose, plane_pose);
    } else {
      ok = ok && take(position, plane.head<2>(), P_plane.topLeftCorner<2, 2>()) &&
           take(plane_pose, plane, P_plane);
    }
    const Index n = filter.size();
    if (k % kMapStride == 0 && n > 3) {
      ok = ok && take(map, e.tail(n - 3), P.bottomRightCorner(n - 3, n - 3), map_solver_);
    }
    heading_squared_ += plane[2] * plane[2];
    position_squared_ += plane.head<2>().squaredNorm();
    heading_variance_ += P_plane(2, 2);
    position_variance_ += P_plane(0, 0) + P_plane(1, 1);
    ++steps_;
    return ok;
  }

  /// Pose NEES over dof since the last call.
  float window() {
    const double nees = nees_[at(EstimatorBlock::pose)] - window_nees_;
    const double dof = dof_[at(EstimatorBlock::pose)] - window_dof_;
    window_nees_ += nees;
    window_dof_ += dof;
    return static_cast<float>(dof > 0.0 ? nees / dof : 0.0);
  }

  EstimatorRunValues values() const {
    EstimatorRunValues values;
    for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
      values.nees[b] = dof_[b] > 0.0 ? nees_[b] / dof_[b] : 0.0;
    }
    values.heading_squared = heading_squared_ / steps_;
    values.position_squared = position_squared_ / steps_;
    values.heading_variance = heading_variance_ / steps_;
    values.position_variance = position_variance_ / steps_;
    return values;
  }

 private:
  bool take(EstimatorBlock block, const VectorRef& error, const MatrixRef& P) {
    return take(block, error, P, solver_[static_cast<std::size_t>(error.size())]);
  }
  bool take(EstimatorBlock block, const VectorRef& error, const MatrixRef& P, SingularNees& solver) {
    last_[at(block)] = solver.solve(error, P);
    return add_last(block);
  }
  void copy(EstimatorBlock from, EstimatorBlock to) {
    last_[at(to)] = last_[at(from)];
    add_last(to);
  }
  bool add_last(EstimatorBlock block) {
    const NeesValue& nees = last_[at(block)];
    if (nees.dof < 0) return false;
    nees_[at(block)] += nees.value;
    dof_[at(block)] += static_cast<double>(nees.dof);
    return true;
  }

  std::array<NeesValue, kEstimatorBlocks> last_{};
  std::array<double, kEstimatorBlocks> nees_{}, dof_{};
  double heading_squared_ = 0.0, position_squared_ = 0.0, steps_ = 0.0;
  double heading_variance_ = 0.0, position_variance_ = 0.0;
  double window_nees_ = 0.0, window_dof_ = 0.0;
  std::array<SingularNees, 4> solver_;  ///< by dimension, so that none changes its size
  SingularNees map_solver_;
};

/// What all runs have in common.
struct StudySetting {
  StudySetting(const Scenario& s, std::vector<std::string> estimators)
      : scenario(s), world(make_odometry_world(s)), source(noise_source(s)), names(std::move(estimators)) {
    const std::int64_t room = kMostWindowValues / (s.study.runs * std::ssize(names));
    windows = std::clamp<std::int64_t>(room, 1, std::min(kMostWindows, s.study.steps));
  }

  Index steps() const { return std::ssize(world.plane.controls); }
  Index window_end(std::int64_t w) const { return (w + 1) * steps() / windows; }
  EstimatorRun start(const std::string& name) const {
    return {world, scenario_estimator(scenario, world, name)};
  }

  const Scenario& scenario;
  OdometryWorld world;
  NoiseSource source;
  std::vector<std::string> names;
  std::int64_t windows = 1;
};

/// Runs `first` … `last` − 1 with all estimators.
void play(const StudySetting& setting, std::int64_t first, std::int64_t last, std::vector<Kept>& kept) {
  OdometryDrive drive(setting.world, setting.source);
  std::vector<EstimatorRun> runs;
  for (const std::string& name : setting.names) runs.push_back(setting.start(name));
  std::vector<RunSums> sums(runs.size());
  std::vector<bool> failed(runs.size());
  for (std::int64_t r = first; r < last; ++r) {
    const Pose estimate = drive.start(r);
    for (std::size_t e = 0; e < runs.size(); ++e) {
      runs[e].start(estimate);
      sums[e].start();
      failed[e] = false;
    }
    std::int64_t window = 0;
    for (Index k = 1; k <= setting.steps(); ++k) {
      const Control read = drive.read(static_cast<std::size_t>(k));
      const auto seen = drive.observe(static_cast<std::size_t>(k));
      const bool ends = k == setting.window_end(window);
      for (std::size_t e = 0; e < runs.size(); ++e) {
        if (failed[e]) continue;
        Outcome outcome = runs[e].step(static_cast<std::size_t>(k), read, seen);
        if (outcome == Outcome::ok && !sums[e].add(runs[e], k)) outcome = Outcome::not_positive_definite;
        if (outcome != Outcome::ok) {
          failed[e] = true;
          kept[e].failures[static_cast<std::size_t>(r)] = {r, k, outcome};
        } else if (ends) {
          kept[e].windows[static_cast<std::size_t>(r * setting.windows + window)] = sums[e].window();
        }
      }
      if (ends) ++window;
    }
    for (std::size_t e = 0; e < runs.size(); ++e) {
      if (!failed[e]) kept[e].values[static_cast<std::size_t>(r)] = sums[e].values();
    }
  }
}

/// What play has kept of runs `first` … `last` − 1, for another rank.
std::vector<std::byte> kept_bytes(const StudySetting& setting, std::int64_t first, std::int64_t last,
                                  const std::vector<Kept>& kept) {
  ByteWriter writer;
  for (const Kept& of : kept) {
    for (std::int64_t r = first; r < last; ++r) {
      writer.put(of.values[static_cast<std::size_t>(r)]);
      writer.put(of.failures[static_cast<std::size_t>(r)]);
    }
    for (std::int64_t w = first * setting.windows; w < last * setting.windows; ++w) {
      writer.put(of.windows[static_cast<std::size_t>(w)]);
    }
  }
  return writer.take();
}

void keep_bytes(const StudySetting& setting, std::int64_t first, std::int64_t last,
                std::span<const std::byte> bytes, std::vector<Kept>& kept) {
  ByteReader reader(bytes, "what another rank kept of runs");
  for (Kept& of : kept) {
    for (std::int64_t r = first; r < last; ++r) {
      reader.get(of.values[static_cast<std::size_t>(r)]);
      reader.get(of.failures[static_cast<std::size_t>(r)]);
    }
    for (std::int64_t w = first * setting.windows; w < last * setting.windows; ++w) {
      reader.get(of.windows[static_cast<std::size_t>(w)]);
    }
  }
  reader.require_end();
}

/// The order statistics at the levels of a band, linear between neighbours; `values` is sorted here.
template <class Value>
Band band_of(std::vector<Value>& values) {
  Band band{};
  if (values.empty()) return band;
  std::ranges::sort(values);
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double place = kBandLevels[i] * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double share = place - static_cast<double>(below);
    band[i] = (1.0 - share) * static_cast<double>(values[below]) + share * static_cast<double>(values[above]);
  }
  return band;
}

MeanInterval root_of(MeanInterval squared) {
  squared.standard_error /= 2.0 * std::sqrt(squared.mean);
  for (double* value : {&squared.mean, &squared.lower, &squared.upper}) *value = std::sqrt(*value);
  return squared;
}

/// The bound over a mean squared error.
MeanInterval efficiency(double bound, MeanInterval squared) {
  const double relative = squared.standard_error / squared.mean;
  std::swap(squared.lower, squared.upper);
  for (double* value : {&squared.mean, &squared.lower, &squared.upper}) *value = bound / *value;
  squared.standard_error = relative * squared.mean;
  return squared;
}

void summarise(const StudySetting& setting, const PosteriorBound& bound, const Kept& kept,
               EstimatorRow& row) {
  const double confidence = setting.scenario.study.confidence;
  std::array<SkewedMoments, kEstimatorBlocks> nees;
  std::array<std::vector<double>, kEstimatorBlocks> sorted;
  Moments heading, position, heading_variance, position_variance;
  for (const std::optional<EstimatorRunValues>& values : kept.values) {
    if (!values) continue;
    ++row.runs;
    heading.add(values->heading_squared);
    position.add(values->position_squared);
    heading_variance.add(values->heading_variance);
    position_variance.add(values->position_variance);
    for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
      nees[b].add(values->nees[b]);
      sorted[b].push_back(values->nees[b]);
    }
  }
  for (const RunFailure& failure : kept.failures) {
    if (failure.outcome != Outcome::ok) row.failures.push_back(failure);
  }
  for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
    row.nees[b] = run_mean_interval(nees[b], confidence);
    row.bands[b] = band_of(sorted[b]);
  }
  const MeanInterval heading_squared = positive_mean_interval(heading, confidence);
  const MeanInterval position_squared = positive_mean_interval(position, confidence);
  row.heading_rmse_rad = root_of(heading_squared);
  row.position_rmse_m = root_of(position_squared);
  row.heading_efficiency = efficiency(bound.heading_squared, heading_squared);
  row.position_efficiency = efficiency(bound.position_squared, position_squared);
  row.claimed_heading_rad = std::sqrt(heading_variance.mean);
  row.claimed_position_m = std::sqrt(position_variance.mean);
  for (std::int64_t w = 0; w < setting.windows; ++w) {
    std::vector<float> window;
    Moments mean;
    for (std::size_t r = 0; r < kept.values.size(); ++r) {
      if (!kept.values[r]) continue;
      window.push_back(
          kept.windows[r * static_cast<std::size_t>(setting.windows) + static_cast<std::size_t>(w)]);
      mean.add(static_cast<double>(window.back()));
    }
    row.pose_nees.push_back(mean.mean);
    row.pose_bands.push_back(band_of(window));
  }
}

PairedDifference compare(const StudySetting& setting, std::size_t a, std::size_t b,
                         const std::vector<Kept>& kept, bool of_position) {
  const auto value = [&](const EstimatorRunValues& v) {
    return of_position ? v.position_squared : v.nees[at(EstimatorBlock::pose)];
  };
  Moments difference, first, second;
  for (std::size_t r = 0; r < kept[a].values.size(); ++r) {
    const auto &of_a = kept[a].values[r], &of_b = kept[b].values[r];
    if (!of_a || !of_b) continue;
    first.add(value(*of_a));
    second.add(value(*of_b));
    difference.add(value(*of_a) - value(*of_b));
  }
  PairedDifference result;
  result.first = setting.names[a];
  result.second = setting.names[b];
  result.of_position = of_position;
  result.difference = student_interval(difference, setting.scenario.study.confidence);
  if (difference.variance() > 0.0) {
    result.p_value = student_two_sided_p_value(result.difference.mean / result.difference.standard_error,
                                               static_cast<double>(difference.count - 1));
    result.gain = (first.variance() + second.variance()) / difference.variance();
  } else if (difference.count < 2) {
    result.p_value = std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

/// The rank along run 0, and the time of a step: the best of a few runs, with what is heard at hand.
void measure_filter(const StudySetting& setting, EstimatorRow& row) {
  constexpr int kRepeats = 3;
  OdometryDrive drive(setting.world, setting.source);
  const Pose estimate = drive.start(0);
  std::vector<Control> read;
  std::vector<std::vector<Observation<PlanarModel>>> seen;
  for (Index k = 1; k <= setting.steps(); ++k) {
    read.push_back(drive.read(static_cast<std::size_t>(k)));
    const auto now = drive.observe(static_cast<std::size_t>(k));
    seen.emplace_back(now.begin(), now.end());
  }
  const auto filter = scenario_estimator(setting.scenario, setting.world, row.name);
  ObservabilityStack stack(3 + 2 * setting.world.plane.states());
  for (int repeat = 0; repeat <= kRepeats; ++repeat) {
    const bool timed = repeat > 0;
    filter->reset(estimate, setting.world.initial_covariance());
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t k = 1; k <= read.size(); ++k) {
      const PlanarTruth truth = setting.world.truth(k);
      filter->predict(read[k - 1], truth);
      const UpdateResult update = filter->update(seen[k - 1], truth);
      if (!update.ok || !filter->state().allFinite()) break;
      if (!timed) stack.add(*filter);
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    const double per_step = seconds.count() / static_cast<double>(read.size());
    if (timed) row.seconds_per_step = repeat == 1 ? per_step : std::min(row.seconds_per_step, per_step);
  }
  const RankDecision rank = stack.rank();
  row.unobservable = stack.states() - rank.rank;
  row.rank_gap = rank.gap;
  row.chart = filter->chart();
}

std::vector<std::string> wanted_names(const EstimatorStudyOptions& options) {
  std::vector<std::string> names = options.estimators;
  if (names.empty()) {
    for (const EstimatorKind& kind : estimator_kinds()) names.emplace_back(kind.name);
  }
  return names;
}

}  // namespace

EstimatorStudy study_estimators(const Scenario& scenario, const EstimatorStudyOptions& options) {
  if (scenario.world.model != "planar_slam") {
    throw std::invalid_argument(fmt::format(
        "world.model = \"{}\": estimators are compared in \"planar_slam\"", scenario.world.model));
  }
  const StudySetting setting(scenario, wanted_names(options));
  const std::int64_t runs = scenario.study.runs;
  EstimatorStudy study;
  study.scenario = scenario;
  study.runs = runs;
  std::vector<Kept> kept(setting.names.size());
  for (std::size_t e = 0; e < kept.size(); ++e) {
    const auto count = static_cast<std::size_t>(runs);
    kept[e].values.resize(count);
    kept[e].failures.resize(count);
    kept[e].windows.resize(count * static_cast<std::size_t>(setting.windows));
    study.rows.emplace_back().name = setting.names[e];
    if (!is_helper(options.ranks)) measure_filter(setting, study.rows.back());
  }
  std::mutex mutex;
  std::int64_t done = 0;
  const auto end_of = [&](std::int64_t task) { return std::min(runs, (task + 1) * kRunsOfTask); };
  const auto tell_progress = [&](std::int64_t task) {
    const std::lock_guard lock(mutex);
    done += end_of(task) - task * kRunsOfTask;
    if (options.progress) options.progress(done, runs);
  };
  SharedTasks tasks;
  tasks.count = (runs + kRunsOfTask - 1) / kRunsOfTask;
  tasks.identity =
      fmt::format("{}\n{}\n{}", version_text(), configuration_toml(scenario), fmt::join(setting.names, " "));
  tasks.here = [&](std::int64_t task) {
    play(setting, task * kRunsOfTask, end_of(task), kept);
    tell_progress(task);
  };
  tasks.there = [&](std::int64_t task) {
    play(setting, task * kRunsOfTask, end_of(task), kept);
    return kept_bytes(setting, task * kRunsOfTask, end_of(task), kept);
  };
  tasks.take = [&](std::int64_t task, std::span<const std::byte> bytes) {
    keep_bytes(setting, task * kRunsOfTask, end_of(task), bytes, kept);
    tell_progress(task);
  };
  for_each_shared_task(tasks, options.threads, options.stop, options.ranks);
  study.complete = done == runs;
  if (is_helper(options.ranks)) return study;
  for (std::int64_t w = 0; w < setting.windows; ++w) {
    study.window_ends.push_back(static_cast<double>(setting.window_end(w)));
  }
  study.bound = posterior_bound(setting.world);
  for (std::size_t e = 0; e < kept.size(); ++e) summarise(setting, study.bound, kept[e], study.rows[e]);
  for (std::size_t a = 0; a < kept.size(); ++a) {
    for (std::size_t b = a + 1; b < kept.size(); ++b) {
      for (const bool of_position : {false, true}) {
        study.paired.push_back(compare(setting, a, b, kept, of_position));
      }
    }
  }
  return study;
}

}  // namespace credence
