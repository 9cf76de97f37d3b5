#include "analysis/evidence/sums/evidence.h"

#include <algorithm>
#include <utility>

#include "analysis/evidence/sums/step_series.h"
#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {
namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t most) {
  const std::size_t room = most - std::min(most, to.size());
  to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(std::min(room, from.size())));
}

void merge_rows(std::map<std::string, CountedRows>& rows, const std::map<std::string, CountedRows>& later) {
  for (const auto& [of, these] : later) {
    CountedRows& all = rows[of];
    if (all.count == 0) all.first = these.first;
    all.count += these.count;
  }
}

}  // namespace

void BlockSums::merge(const BlockSums& later) {
  merge_series(nees, later.nees);
  runs.merge(later.runs);
  append(few, later.few, std::numeric_limits<std::size_t>::max());
  if (runs.moments.count > StretchSums::kMostRuns) few.clear();
  squared_error.merge(later.squared_error);
  claimed.merge(later.claimed);
}

void CoverageSums::add(std::int64_t step, double nees, Index dof) {
  const auto k = static_cast<std::size_t>(step) - 1;
  const auto [expected, unknown] = expected_of_dof_.try_emplace(dof);
  for (std::size_t i = 0; i < kSigmas.size(); ++i) {
    Region& region = regions[i];
    if (unknown) expected->second[i] = expected_coverage(kSigmas[i], static_cast<double>(dof));
    if (region.count.size() <= k) {
      region.count.resize(k + 1);
      region.expected.resize(k + 1);
    }
    region.count[k].add(nees <= kSigmas[i] * kSigmas[i]);
    region.expected[k] += expected->second[i];
  }
}

void CoverageSums::merge(const CoverageSums& later) {
  for (std::size_t i = 0; i < regions.size(); ++i) {
    Region& region = regions[i];
    const Region& other = later.regions[i];
    if (region.count.size() < other.count.size()) {
      region.count.resize(other.count.size());
      region.expected.resize(other.count.size());
    }
    for (std::size_t k = 0; k < other.count.size(); ++k) {
      region.count[k].merge(other.count[k]);
      region.expected[k] += other.expected[k];
    }
  }
}

void CoverageSums::drop_every_second_step() {
  for (Region& region : regions) {
    drop_every_second(region.count);
    drop_every_second(region.expected);
  }
}

SensorSums::SensorSums(Sensor of)
    : sensor(std::move(of)),
      varies(sensor.piece > kLargestWhitened),
      lags(varies ? 1 : sensor.piece),
      scalar_lags(1) {}

void SensorSums::merge(const SensorSums& later) {
  varies = varies || later.varies || sensor.piece != later.sensor.piece;
  sensor.dim = std::max(sensor.dim, later.sensor.dim);
  merge_series(nis, later.nis);
  for (const auto& [m, sums] : later.by_dimension) by_dimension[m].merge(sums);
  fit.merge(later.fit);
  far_tail.merge(later.far_tail);
  largest_nis = std::max(largest_nis, later.largest_nis);
  ties.merge(later.ties);
  if (!varies) {
    lags.merge(later.lags);
    run_means.merge(later.run_means);
    values.merge(later.values);
    first.merge(later.first);
    merge_series(components, later.components);
    merge_series(pairs, later.pairs);
  }
  scalar_lags.merge(later.scalar_lags);
  scalar_run_means.merge(later.scalar_run_means);
  scalar_values.merge(later.scalar_values);
  measurement_share.merge(later.measurement_share);
  changes.merge(later.changes);
  unwrapped += later.unwrapped;
  merge_series(turns, later.turns);
}

void RunSums::merge(const RunSums& later, double least_dof) {
  nees_values.merge(later.nees_values);
  for (std::size_t i = kKept - nees.size(); i < later.nees.size(); ++i)
    further.push_back(course_of(later.nees[i], least_dof));
  further.insert(further.end(), later.further.begin(), later.further.end());
  append(nees, later.nees, kKept);
  append(samples, later.samples, kKept);
  append(log_variances, later.log_variances, kKept);
  drop_samples_of_many();
  append(last_error, later.last_error, kKept);
  append(last_covariance, later.last_covariance, kKept);
  if (last_whitened.count == 0 || last_whitened.mean.size() == later.last_whitened.mean.size()) {
    last_whitened.merge(later.last_whitened);
  }
  failed.insert(failed.end(), later.failed.begin(), later.failed.end());
}

void RunSums::add(std::vector<double> nees_of_run, const RunSamples* samples_of_run) {
  nees.push_back(std::move(nees_of_run));
  if (samples_of_run != nullptr) {
    samples.emplace_back(samples_of_run->errors());
    log_variances.emplace_back(samples_of_run->log_variances());
  }
  drop_samples_of_many();
}

void RunSums::drop_samples_of_many() {
  if (std::ssize(nees) <= StretchSums::kMostRuns) return;
  samples.clear();
  log_variances.clear();
}

std::vector<RunCourse> RunSums::courses(double least_dof) const {
  std::vector<RunCourse> all;
  all.reserve(nees.size() + further.size());
  for (const std::vector<double>& run : nees) all.push_back(course_of(run, least_dof));
  all.insert(all.end(), further.begin(), further.end());
  return all;
}

void Evidence::merge(Evidence later) {
  if (later.rows == 0 && later.study.runs == 0) return;
  if (rows == 0 && study.runs == 0) {
    *this = std::move(later);
    return;
  }
  thin_steps(1, later.step_stride);
  later.thin_steps(1, step_stride);
  const std::size_t steps = std::max(study.steps.size(), later.study.steps.size());
  study.steps.resize(steps);
  later.study.steps.resize(steps);
  for (RunFailure& failure : later.study.failures) failure.run += study.runs;
  for (CourseOfRun& failed : later.whole_runs.failed) failed.run += study.runs;
  const auto least_dof = static_cast<double>(later.study.nees_of_runs.least_dof);
  whole_runs.merge(later.whole_runs, least_dof);
  study.merge(later.study);
  for (const BlockSums& sums : later.blocks) block({sums.name, sums.part, {}}).merge(sums);
  for (SensorSums& sums : later.sensors) {
    const auto found =
        std::ranges::find_if(sensors, [&](const SensorSums& s) { return s.sensor.name == sums.sensor.name; });
    if (found == sensors.end()) {
      sensors.push_back(std::move(sums));
    } else {
      found->merge(sums);
    }
  }
  coverage.merge(later.coverage);
  law.merge(later.law);
  lateness.merge(later.lateness);
  scores.merge(later.scores);
  for (const SensorPairSums& pair : later.sensor_pairs) {
    SensorPairSums& here = sensor_pair(pair.first, pair.second, pair.first_dim);
    if (here.fits(pair.first_dim, pair.both.mean.size())) here.both.merge(pair.both);
  }
  merge_series(clean_nees, later.clean_nees);
  merge_series(clean_nis, later.clean_nis);
  nees_outliers += later.nees_outliers;
  nis_outliers += later.nis_outliers;
  for (const auto& [state, of_state] : later.turns) turns[state].merge(of_state);
  narrow_angles.inside += later.narrow_angles.inside;
  narrow_angles.total += later.narrow_angles.total;
  rows += later.rows;
  merge_rows(rejected, later.rejected);
  merge_rows(wrongly_certain, later.wrongly_certain);
  first_run.clear();
  first_run.shrink_to_fit();
  state_dim = std::max(state_dim, later.state_dim);
  joint_covariance = joint_covariance && later.joint_covariance;
  has_truth = has_truth || later.has_truth;
}

void Evidence::thin_steps(std::int64_t step, std::int64_t stride) {
  while (step > kMostSteps * step_stride || stride > step_stride) {
    step_stride *= 2;
    drop_every_second(study.steps);
    for (BlockSums& block : blocks) drop_every_second(block.nees);
    for (SensorSums& sensor : sensors) drop_every_second(sensor.nis);
    coverage.drop_every_second_step();
    drop_every_second(law.nis_at);
    drop_every_second(clean_nees);
    drop_every_second(clean_nis);
  }
}

std::int64_t Evidence::wrongly_certain_rows() const {
  std::int64_t most = 0;
  for (const auto& [state, these] : wrongly_certain) most = std::max(most, these.count);
  return most;
}

std::int64_t Evidence::rejected_rows() const {
  std::int64_t count = 0;
  for (const auto& [reason, these] : rejected) count += these.count;
  return count;
}

BlockSums& Evidence::block(const Block& of) {
  const auto found = std::ranges::find(blocks, of.name, &BlockSums::name);
  if (found != blocks.end()) return *found;
  return blocks.emplace_back(BlockSums{.name = of.name,
                                       .part = of.part,
                                       .nees = {},
                                       .runs = {},
                                       .few = {},
                                       .squared_error = {},
                                       .claimed = {}});
}

SensorSums& Evidence::sensor(const Sensor& of) {
  for (SensorSums& sums : sensors) {
    if (sums.sensor.name == of.name) return sums;
  }
  return sensors.emplace_back(of);
}

SensorPairSums& Evidence::sensor_pair(const std::string& first, const std::string& second, Index first_dim) {
  for (SensorPairSums& pair : sensor_pairs) {
    if (pair.first == first && pair.second == second) return pair;
  }
  return sensor_pairs.emplace_back(SensorPairSums{first, second, first_dim});
}

double outlier_limit(Index dof) {
  constexpr std::size_t kCached = 64;
  static const std::vector<double> limits = [] {
    std::vector<double> all(kCached, 0.0);
    for (std::size_t i = 1; i < kCached; ++i) {
      all[i] = chi_square_upper_quantile(kGrossOutlier, static_cast<double>(i));
    }
    return all;
  }();
  const auto i = static_cast<std::size_t>(dof);
  return i < kCached ? limits[i] : chi_square_upper_quantile(kGrossOutlier, static_cast<double>(dof));
}

}  // namespace credence::internal
