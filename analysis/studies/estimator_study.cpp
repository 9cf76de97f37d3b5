#include "analysis/studies/estimator_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>

#include "analysis/evidence/verdicts/accuracy.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/scores/rmse_interval.h"
#include "analysis/stability/observability_stack.h"
#include "core/nan.h"
#include "core/stop_point.h"
#include "core/version.h"
#include "montecarlo/engine/byte_stream.h"
#include "montecarlo/engine/shared_tasks.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/posterior_bound.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kRunsOfTask = 8;
constexpr std::int64_t kMostWindows = 100;
/// Numbers kept of all windows together.
constexpr std::int64_t kMostWindowValues = 40'000'000;

constexpr std::array kJudgedBlocks = {EstimatorBlock::pose, EstimatorBlock::map};
constexpr std::size_t at(EstimatorBlock block) { return static_cast<std::size_t>(block); }

/// What is kept of one estimator in every run.
struct Kept {
  std::vector<std::optional<EstimatorRunValues>> values;  ///< by run; none where it failed
  std::vector<RunFailure> failures;                       ///< by run, outcome ok where there is none
  std::vector<std::int64_t> not_converged;                ///< steps, by run
  std::vector<float> windows;                             ///< of run r from r · windows on
};

/// The sums of one estimator on its way through one run.
class EstimatorRunSums {
 public:
  /// False where P is no covariance.
  bool add(const EstimatorStep& step) {
    for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
      if (step.nees[b].dof < 0) return false;
      nees_[b] += step.nees[b].value;
      dof_[b] += static_cast<double>(step.nees[b].dof);
    }
    heading_squared_ += step.heading_squared;
    position_squared_ += step.position_squared;
    heading_variance_ += step.heading_variance;
    position_variance_ += step.position_variance;
    ++steps_;
    return true;
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
      values.nees[b] = dof_[b] > 0.0 ? nees_[b] / dof_[b] : kNaN;
    }
    values.heading_squared = heading_squared_ / steps_;
    values.position_squared = position_squared_ / steps_;
    values.heading_variance = heading_variance_ / steps_;
    values.position_variance = position_variance_ / steps_;
    return values;
  }

 private:
  std::array<double, kEstimatorBlocks> nees_{}, dof_{};
  double heading_squared_ = 0.0, position_squared_ = 0.0, steps_ = 0.0;
  double heading_variance_ = 0.0, position_variance_ = 0.0;
  double window_nees_ = 0.0, window_dof_ = 0.0;
};

/// What all runs have in common.
struct StudySetting {
  StudySetting(const Scenario& s, std::unique_ptr<EstimatorContest> of, std::vector<std::string> estimators)
      : scenario(s), contest(std::move(of)), names(std::move(estimators)) {
    const std::int64_t room = kMostWindowValues / (s.study.runs * std::ssize(names));
    windows = std::clamp<std::int64_t>(room, 1, std::min(kMostWindows, s.study.steps));
  }

  Index window_end(std::int64_t w) const { return (w + 1) * contest->steps() / windows; }

  const Scenario& scenario;
  std::unique_ptr<EstimatorContest> contest;
  std::vector<std::string> names;
  std::int64_t windows = 1;
};

/// Keeps what it hears of runs of all estimators.
class Keeper final : public EstimatorListener {
 public:
  Keeper(const StudySetting& setting, std::vector<Kept>& kept) : setting_(setting), kept_(kept) {}

  void start(std::int64_t run) {
    run_ = run;
    hearings_.assign(kept_.size(), {});
  }
  bool take(std::size_t e, Index k, const EstimatorStep& step) override {
    Hearing& hearing = hearings_[e];
    if (!hearing.sums.add(step)) {
      failed(e, k, Outcome::not_positive_definite);
      return false;
    }
    if (!step.converged) ++kept_[e].not_converged[static_cast<std::size_t>(run_)];
    if (k == setting_.window_end(hearing.window)) {
      kept_[e].windows[static_cast<std::size_t>(run_ * setting_.windows + hearing.window)] =
          hearing.sums.window();
      ++hearing.window;
    }
    return true;
  }
  void failed(std::size_t e, Index k, Outcome outcome) override {
    hearings_[e].failed = true;
    kept_[e].failures[static_cast<std::size_t>(run_)] = {run_, k, outcome};
  }
  void end() {
    for (std::size_t e = 0; e < kept_.size(); ++e) {
      if (!hearings_[e].failed) kept_[e].values[static_cast<std::size_t>(run_)] = hearings_[e].sums.values();
    }
  }

 private:
  struct Hearing {
    EstimatorRunSums sums;
    std::int64_t window = 0;
    bool failed = false;
  };

  const StudySetting& setting_;
  std::vector<Kept>& kept_;
  std::int64_t run_ = 0;
  std::vector<Hearing> hearings_;
};

/// Runs `first` … `last` − 1 with all estimators.
void play(const StudySetting& setting, std::int64_t first, std::int64_t last, std::vector<Kept>& kept) {
  const auto player = setting.contest->player(setting.names);
  Keeper keeper(setting, kept);
  for (std::int64_t r = first; r < last; ++r) {
    keeper.start(r);
    player->play(r, keeper);
    keeper.end();
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
      writer.put(of.not_converged[static_cast<std::size_t>(r)]);
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
      reader.get(of.not_converged[static_cast<std::size_t>(r)]);
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
  if (squared.mean == 0.0) return {};
  squared.standard_error /= 2.0 * std::sqrt(squared.mean);
  for (double* value : {&squared.mean, &squared.lower, &squared.upper}) *value = std::sqrt(*value);
  return squared;
}

void summarise(const StudySetting& setting, const VehicleBound& bound, const Kept& kept, EstimatorRow& row) {
  const double confidence = setting.scenario.study.confidence;
  std::array<SkewedMoments, kEstimatorBlocks> nees;
  std::array<std::vector<double>, kEstimatorBlocks> sorted;
  SkewedMoments heading, position;
  Moments heading_variance, position_variance;
  for (const std::optional<EstimatorRunValues>& values : kept.values) {
    if (!values) continue;
    ++row.runs;
    heading.add(values->heading_squared);
    position.add(values->position_squared);
    heading_variance.add(values->heading_variance);
    position_variance.add(values->position_variance);
    for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
      if (std::isnan(values->nees[b])) continue;
      nees[b].add(values->nees[b]);
      sorted[b].push_back(values->nees[b]);
    }
  }
  for (const RunFailure& failure : kept.failures) {
    if (failure.outcome != Outcome::ok) row.failures.push_back(failure);
  }
  for (std::size_t r = 0; r < kept.not_converged.size(); ++r) {
    if (kept.not_converged[r] == 0) continue;
    row.not_converged.push_back({static_cast<std::int64_t>(r), kept.not_converged[r]});
  }
  for (std::size_t b = 0; b < kEstimatorBlocks; ++b) {
    row.nees[b] = run_mean_interval(nees[b], confidence);
    row.p_values[b] = run_mean_p_values(nees[b], 1.0);
    row.bands[b] = band_of(sorted[b]);
  }
  const SkewedMoments& pose = nees[at(EstimatorBlock::pose)];
  row.beyond_tolerance = {.optimistic = run_mean_p_values(pose, kToleratedFactor).optimistic,
                          .pessimistic = run_mean_p_values(pose, 1.0 / kToleratedFactor).pessimistic};
  const MeanInterval heading_squared = mean_square_interval(heading, confidence);
  const MeanInterval position_squared = mean_square_interval(position, confidence);
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

/// Holm over both directions of all rows, of the pose and the map.
void adjust_p_values(std::vector<EstimatorRow>& rows) {
  std::vector<double*> places;
  std::vector<double> p_values;
  for (EstimatorRow& row : rows) {
    for (const EstimatorBlock block : kJudgedBlocks) {
      DirectedPValues& p = row.p_values[at(block)];
      for (double* place : {&p.optimistic, &p.pessimistic}) {
        places.push_back(place);
        p_values.push_back(*place);
      }
    }
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < places.size(); ++i) *places[i] = adjusted[i];
}

PairedDifference compare(const StudySetting& setting, std::size_t a, std::size_t b,
                         const std::vector<Kept>& kept, bool of_position) {
  const auto value = [&](const EstimatorRunValues& v) {
    return of_position ? v.position_squared : v.nees[at(EstimatorBlock::pose)];
  };
  constexpr double kRounding = 1e-10;  // of two filters that are the same but for the order of their sums
  SkewedMoments difference;
  Moments first, second;
  for (std::size_t r = 0; r < kept[a].values.size(); ++r) {
    const auto &of_a = kept[a].values[r], &of_b = kept[b].values[r];
    if (!of_a || !of_b) continue;
    first.add(value(*of_a));
    second.add(value(*of_b));
    const double apart = value(*of_a) - value(*of_b);
    difference.add(std::abs(apart) <= kRounding * std::abs(value(*of_a)) ? 0.0 : apart);
  }
  PairedDifference result;
  result.first = setting.names[a];
  result.second = setting.names[b];
  result.of_position = of_position;
  result.difference = paired_interval(difference, setting.scenario.study.confidence);
  result.p_value = paired_p_value(difference);
  if (difference.variance() > 0.0)
    result.gain = (first.variance() + second.variance()) / difference.variance();
  return result;
}

/// What it is at its own Jacobians, along run 0.
void profile(const EstimatorContest& contest, EstimatorRow& row) {
  ObservabilityStack stack(contest.unknowns());
  row.profile = contest.profile(row.name, [&](const VectorRef& of_matrix) { stack.add(of_matrix); });
  const RankDecision rank = stack.rank();
  row.unobservable = row.profile.known - rank.rank;
  row.rank_gap = rank.gap;
}

std::string worlds_that_offer() {
  std::vector<std::string> names;
  for (const World* world : worlds()) {
    if (world->estimators != nullptr) names.push_back(fmt::format("\"{}\"", world->schema.name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

const EstimatorOffer& offer_of(const Scenario& scenario) {
  if (const EstimatorOffer* offer = world_of(scenario).estimators) return *offer;
  throw std::invalid_argument(fmt::format("world.model = \"{}\": estimators are compared in {}",
                                          scenario.world.model, worlds_that_offer()));
}

}  // namespace

ChosenEstimators choose_estimators(const Scenario& scenario, const std::vector<std::string>& asked) {
  const EstimatorOffer& offer = offer_of(scenario);
  const std::vector<std::string_view> offered = offer.names(&scenario);
  for (const std::string& name : asked) {
    if (std::ranges::find(offered, name) != offered.end()) continue;
    throw std::invalid_argument(
        fmt::format("this scenario has no estimator \"{}\"; it has {}", name, fmt::join(offered, ", ")));
  }
  if (!asked.empty()) return {asked, {}};
  ChosenEstimators chosen;
  const std::unique_ptr<EstimatorContest> contest = offer.contest(scenario);
  for (const std::string_view name : offered) {
    try {
      contest->player(std::array{std::string(name)});
      chosen.names.emplace_back(name);
    } catch (const std::invalid_argument& refusal) {
      chosen.left_out.push_back({std::string(name), refusal.what()});
    }
  }
  if (chosen.names.empty()) throw std::invalid_argument(chosen.left_out.front().reason);
  return chosen;
}

namespace {

EstimatorStudy played_study(const Scenario& scenario, const EstimatorStudyOptions& options) {
  ChosenEstimators chosen = choose_estimators(scenario, options.estimators);
  const StudySetting setting(scenario, offer_of(scenario).contest(scenario), std::move(chosen.names));
  const std::int64_t runs = scenario.study.runs;
  EstimatorStudy study;
  study.scenario = scenario;
  study.left_out = std::move(chosen.left_out);
  study.run_command = options.run_command;
  study.runs = runs;
  std::mutex mutex;
  StudyProgress progress{.runs_total = runs};
  const auto tell_progress = [&](std::int64_t done, double in_hand) {
    const std::lock_guard lock(mutex);
    progress.runs_done += done;
    progress.runs_in_hand = std::max(0.0, progress.runs_in_hand + in_hand);
    if (options.progress) options.progress(progress);
  };
  std::vector<Kept> kept(setting.names.size());
  for (std::size_t e = 0; e < kept.size(); ++e) {
    const auto count = static_cast<std::size_t>(runs);
    kept[e].values.resize(count);
    kept[e].failures.resize(count);
    kept[e].not_converged.resize(count);
    kept[e].windows.resize(count * static_cast<std::size_t>(setting.windows));
    study.rows.emplace_back().name = setting.names[e];
    if (is_helper(options.ranks)) continue;
    const PulseScope pulse([&](std::int64_t) { tell_progress(0, 0.0); });
    profile(*setting.contest, study.rows.back());
  }
  const auto end_of = [&](std::int64_t task) { return std::min(runs, (task + 1) * kRunsOfTask); };
  const auto runs_of = [&](std::int64_t task) { return end_of(task) - task * kRunsOfTask; };
  // A stop point is passed by every estimator at every step.
  const double passes_of_run = static_cast<double>(setting.contest->steps() * std::ssize(setting.names));
  SharedTasks tasks;
  tasks.count = (runs + kRunsOfTask - 1) / kRunsOfTask;
  tasks.identity =
      fmt::format("{}\n{}\n{}", version_text(), configuration_toml(scenario), fmt::join(setting.names, " "));
  tasks.here = [&](std::int64_t task) {
    double in_hand = 0.0;
    const PulseScope pulse([&](std::int64_t passes) {  // a run may take minutes
      const double more =
          std::min(static_cast<double>(passes) / passes_of_run, static_cast<double>(runs_of(task)) - in_hand);
      in_hand += more;
      tell_progress(0, more);
    });
    play(setting, task * kRunsOfTask, end_of(task), kept);
    tell_progress(runs_of(task), -in_hand);
  };
  tasks.there = [&](std::int64_t task) {
    play(setting, task * kRunsOfTask, end_of(task), kept);
    return kept_bytes(setting, task * kRunsOfTask, end_of(task), kept);
  };
  tasks.take = [&](std::int64_t task, std::span<const std::byte> bytes) {
    keep_bytes(setting, task * kRunsOfTask, end_of(task), bytes, kept);
    tell_progress(runs_of(task), 0.0);
  };
  for_each_shared_task(tasks, options.threads, options.stop, options.ranks);
  study.complete = progress.runs_done == runs;
  if (is_helper(options.ranks)) return study;
  for (std::int64_t w = 0; w < setting.windows; ++w) {
    study.window_ends.push_back(static_cast<double>(setting.window_end(w)));
  }
  study.has_vehicle = setting.contest->has_vehicle();
  study.bound = no_bound_reason(scenario).empty() ? setting.contest->bound() : VehicleBound{kNaN, kNaN};
  study.map_stride = setting.contest->map_stride();
  study.note = setting.contest->note();
  for (std::size_t e = 0; e < kept.size(); ++e) summarise(setting, study.bound, kept[e], study.rows[e]);
  adjust_p_values(study.rows);
  for (std::size_t a = 0; a < kept.size(); ++a) {
    for (std::size_t b = a + 1; b < kept.size(); ++b) {
      for (const bool of_position : {false, true}) {
        study.paired.push_back(compare(setting, a, b, kept, of_position));
      }
    }
  }
  return study;
}

}  // namespace

Verdict verdict_of(const EstimatorRow& row, EstimatorBlock block, double confidence) {
  const DirectedPValues& p = row.p_values[at(block)];
  return direction_of(p.optimistic <= 1.0 - confidence, p.pessimistic <= 1.0 - confidence);
}

bool any_inconsistent(const EstimatorStudy& study) {
  return std::ranges::any_of(study.rows, [&](const EstimatorRow& row) {
    return std::ranges::any_of(kJudgedBlocks, [&](EstimatorBlock block) {
      return is_inconsistent(verdict_of(row, block, study.scenario.study.confidence));
    });
  });
}

EstimatorStudy study_estimators(const Scenario& scenario, const EstimatorStudyOptions& options) {
  const StopScope scope(options.stop);
  try {
    return played_study(scenario, options);
  } catch (const Stopped&) {
    EstimatorStudy stopped;
    stopped.scenario = scenario;
    stopped.complete = false;
    return stopped;
  }
}

}  // namespace credence::internal
