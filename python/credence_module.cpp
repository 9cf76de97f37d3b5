#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "app/scenario_files.h"
#include "core/control_characters.h"
#include "core/stop_point.h"
#include "core/utf8.h"
#include "core/version.h"
#include "datasets/arrays/array_copies.h"
#include "datasets/arrays/array_evidence.h"
#include "datasets/arrays/array_mistakes.h"
#include "datasets/data_error.h"
#include "montecarlo/engine/result_store_error.h"
#include "montecarlo/random/noise.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/scenario/scenario_text.h"
#include "python/interruptible.h"
#include "python/told.h"
#include "python/tuned_filter.h"
#include "reports/document/judge/judged.h"
#include "reports/document/logs/check_logs.h"
#include "reports/render/atomic_file.h"
#include "reports/render/text_page.h"
#include "reports/render/write_document.h"

/// @file
/// The compiled half of the Python module: arrays in, judged filters out. What a user calls, and what checks
/// the arguments, is Python (credence/*.py).

namespace py = pybind11;

namespace credence::internal {
namespace {

using Doubles = py::array_t<double, 0>;

/// Runs of one length: error, P, innovation, S and R (or none) of every sensor, and estimate; (runs, steps,
/// …) with contiguous rows.
struct ArrayBundle {
  std::optional<Doubles> error, P;
  std::vector<std::tuple<Doubles, Doubles, std::optional<Doubles>>> innovations;
  std::optional<Doubles> estimate;
};

void require_rows(const Doubles& array, std::initializer_list<Index> row) {
  auto stride = static_cast<py::ssize_t>(sizeof(double));
  const auto dims = static_cast<py::ssize_t>(row.size());
  bool fits = array.ndim() == 2 + dims;
  for (py::ssize_t d = dims - 1; fits && d >= 0; --d) {
    const Index wanted = *(row.begin() + d);
    fits = array.shape(2 + d) == wanted && (wanted == 1 || array.strides(2 + d) == stride);
    stride *= wanted;
  }
  if (!fits) throw std::invalid_argument("an array is not of (runs, steps, …) with contiguous rows");
}

ArrayRows rows_of(const Doubles& array, std::int64_t run) {
  constexpr auto kBytes = static_cast<py::ssize_t>(sizeof(double));
  return {array.data() + array.strides(0) / kBytes * run, array.strides(1) / kBytes};
}

/// A failed run of a bundle: step, outcome, and what was said.
using Failure = std::tuple<std::int64_t, std::string, std::string>;

/// The evidence of runs that come bundle by bundle.
class Collector {
 public:
  Collector(std::vector<std::string> states, std::vector<bool> angles, std::vector<std::string> units,
            const std::vector<std::pair<std::string, std::vector<Index>>>& blocks,
            const std::vector<std::tuple<std::string, Index, Index, std::vector<bool>>>& sensors,
            bool has_truth, bool nonlinear, bool inflated) {
    layout_.states = std::move(states);
    layout_.angles = std::move(angles);
    layout_.units = std::move(units);
    layout_.has_truth = has_truth;
    layout_.nonlinear = nonlinear;
    layout_.inflated = inflated;
    for (const auto& [name, members] : blocks) layout_.blocks.push_back({name, Part::other, members});
    if (blocks.empty()) add_named_blocks(layout_);
    for (const auto& [name, dim, observation, of_angles] : sensors) {
      layout_.sensors.push_back({.name = name, .dim = dim, .piece = observation, .angles = of_angles});
    }
  }

  void add(const std::vector<ArrayBundle>& bundles, ArrayIndexing indexing, int threads,
           const std::map<std::int64_t, Failure>& failures) {
    const ArrayRuns arrays = runs_of(bundles, indexing, failures);
    for (const auto& [run, failure] : failures)
      failures_said_.emplace(arrays.first_run + run, std::get<2>(failure));
    evidence_.merge(interruptible([&](const auto& stop, const auto&) {
      return add_arrays(arrays, threads, &stop, &calibration_, &judged_);
    }));
  }

  /// Looks for mistakes of who made these runs, to tell of them. `played`: they were played, so that their
  /// axes are known, and no run is a copy.
  void look(const std::vector<ArrayBundle>& bundles, ArrayIndexing indexing,
            const std::map<std::int64_t, Failure>& failures, bool played) {
    const ArrayRuns arrays = runs_of(bundles, indexing, failures);
    mistakes_ = interruptible([&](const auto& stop, const auto&) {
      const StopScope scope(&stop);
      try {
        if (!played) copies_ = array_copies(arrays);
        ArrayMistakes mistakes = array_mistakes(arrays);
        if (played) mistakes.swapped_axes.clear();
        return mistakes;
      } catch (const Stopped&) {
        return ArrayMistakes();
      }
    });
  }

  /// dt: the time of a step, s; 0: not known.
  Told judge(const std::string& name, const std::string& source, double confidence, bool sensitivity,
             double within, double dt) {
    const py::gil_scoped_release released;
    CheckedLogs runs;
    runs.name = name;
    runs.format = source;
    const bool swapped = !mistakes_.swapped_axes.empty();
    judge_collected(std::move(evidence_), std::move(calibration_),
                    {.confidence = confidence,
                     .sensitivity = sensitivity,
                     .margin = within,
                     .times = StepTimes::every(dt),
                     .copies = copies_.many() ? copies_.says : std::string()},
                    swapped ? InputMistakes{.said = {.misfits = {}, .others = {mistakes_.swapped_axes}},
                                            .swapped_axes = true}
                            : InputMistakes{.said = std::move(mistakes_.said)},
                    runs);
    if (!copies_.says.empty()) runs.remarks.push_back(std::move(copies_.says));
    std::ranges::move(judged_.sentences(), std::back_inserter(runs.remarks));
    runs.failures_said = std::move(failures_said_);
    evidence_ = {};
    calibration_ = {};
    failures_said_ = {};
    mistakes_ = {};
    copies_ = {};
    judged_ = {};
    return tell(JudgedFilter(judged_logs(std::move(runs))));
  }

 private:
  ArrayRuns runs_of(const std::vector<ArrayBundle>& bundles, ArrayIndexing indexing,
                    const std::map<std::int64_t, Failure>& failures) const {
    ArrayRuns arrays{.layout = layout_, .runs = {}, .indexing = indexing};
    arrays.first_run = evidence_.study.runs;
    for (const ArrayBundle& bundle : bundles) add_runs(bundle, arrays);
    for (const auto& [run, failure] : failures) {
      const auto& [step, outcome, said] = failure;
      ArrayRun& failed = arrays.runs.at(static_cast<std::size_t>(run));
      failed.failure = RunFailure{.run = run, .step = step, .outcome = outcome_named(outcome).value()};
      failed.steps = std::min(failed.steps, step - 1);
    }
    return arrays;
  }

  void add_runs(const ArrayBundle& bundle, ArrayRuns& arrays) const {
    const Index n = std::ssize(layout_.states);
    const Doubles& lead = bundle.error ? *bundle.error : std::get<0>(bundle.innovations.front());
    if (bundle.error) {
      require_rows(*bundle.error, {n});
      require_rows(*bundle.P, {n, n});
    }
    if (bundle.estimate) require_rows(*bundle.estimate, {n});
    for (std::size_t s = 0; s < bundle.innovations.size(); ++s) {
      const Index m = layout_.sensors[s].dim;
      const auto& [nu, S, R] = bundle.innovations[s];
      require_rows(nu, {m});
      require_rows(S, {m, m});
      if (R) require_rows(*R, {m, m});
    }
    for (std::int64_t run = 0; run < lead.shape(0); ++run) {
      ArrayRun& added = arrays.runs.emplace_back();
      added.steps = lead.shape(1);
      if (bundle.error) {
        added.error = rows_of(*bundle.error, run);
        added.P = rows_of(*bundle.P, run);
      }
      if (bundle.estimate) added.estimate = rows_of(*bundle.estimate, run);
      for (const auto& [nu, S, R] : bundle.innovations) {
        added.innovations.push_back({rows_of(nu, run), rows_of(S, run), R ? rows_of(*R, run) : ArrayRows()});
      }
    }
  }

  RunLayout layout_;
  Evidence evidence_;
  CalibrationUnits calibration_;
  std::map<std::int64_t, std::string> failures_said_;
  ArrayMistakes mistakes_;
  CopiedRuns copies_;
  JudgedStates judged_;
};

/// With its control characters but the line break as "\x1b": a traceback is printed as it stands.
std::string without_controls(std::string_view message) {
  std::string text;
  for (std::size_t i = 0; i < message.size();) {
    const std::size_t begin = i;
    const char32_t c = next_code_point(message, i);
    const bool obeyed = c != '\n' && has_control_character(message.substr(begin, i - begin));
    text += obeyed ? fmt::format("\\x{:02x}", static_cast<unsigned>(c))
                   : std::string(message.substr(begin, i - begin));
  }
  return text;
}

/// A message may hold what a file holds, which need not be UTF-8; as it stands Python would make it empty.
void raise(PyObject* type, std::string_view original) {
  const std::string message = without_controls(original);
  const py::object text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace"));
  PyErr_SetObject(type, text.ptr());
}

/// What it does not catch goes on to pybind11's own translators.
void translate_messages(std::exception_ptr error) {
  const auto type = [](const char* name) { return py::module_::import("credence._credence").attr(name); };
  try {
    if (error) std::rethrow_exception(error);
  } catch (const OutputError& e) {
    raise(type("OutputError").ptr(), e.what());
  } catch (const StoreError& e) {
    raise(type("StoreError").ptr(), e.what());
  } catch (const ScenarioError& e) {
    raise(type("ScenarioError").ptr(), e.what());
  } catch (const DataError& e) {
    raise(type("DataError").ptr(), e.what());
  } catch (const std::invalid_argument& e) {
    raise(PyExc_ValueError, e.what());
  }
}

/// Standard normals (runs, slots) of one step.
py::array_t<double> normals(const NoiseSource& source, std::int64_t first_run, std::int64_t runs,
                            std::int64_t step, NoisePurpose purpose, std::int64_t slots,
                            std::int64_t first_slot) {
  py::array_t<double> result({runs, slots});
  if (slots == 0) return result;  // no place that mutable_data could point to
  const auto n = static_cast<std::size_t>(slots);
  for (std::int64_t run = 0; run < runs; ++run) {
    source.normals(first_run + run, step, purpose, std::span(result.mutable_data(run, 0), n), first_slot);
  }
  return result;
}

/// Standard normals (4, runs, slots) of the steps first_step …, first_step mod 4 = 1.
py::array_t<double> normals_of_four_steps(const NoiseSource& source, std::int64_t first_run,
                                          std::int64_t runs, std::int64_t first_step, NoisePurpose purpose,
                                          std::int64_t slots) {
  py::array_t<double> result({std::int64_t{4}, runs, slots});
  if (slots == 0) return result;
  std::vector<double> four(static_cast<std::size_t>(4 * slots));
  for (std::int64_t run = 0; run < runs; ++run) {
    source.normals_of_four_steps(first_run + run, first_step, purpose, slots, four);
    for (std::int64_t k = 0; k < 4; ++k) {
      std::copy_n(four.begin() + k * slots, slots, result.mutable_data(k, run, 0));
    }
  }
  return result;
}

JudgeProgress telling(std::shared_ptr<WorkDone> work) {
  return [work = std::move(work)](std::int64_t done, std::int64_t total) {
    work->tell(static_cast<double>(done), static_cast<double>(total));
  };
}

/// play(options), interruptible.
template <class Play>
Told played(int threads, const PythonProgress& progress, const Play& play) {
  return interruptible(
      [&](const std::atomic<bool>& stop, const std::shared_ptr<WorkDone>& done) {
        return play(PlayOptions{.threads = threads, .stop = &stop, .progress = telling(done)});
      },
      progress);
}

/// Of a text, or else of a file.
Scenario scenario_of(const std::string& file, const std::optional<std::string>& text,
                     const std::vector<std::string>& overrides) {
  return text ? load_scenario_text(*text, file, overrides) : open_one_scenario(file, overrides);
}

}  // namespace

PYBIND11_MODULE(_credence, m) {
  m.doc() = "The compiled half of the module credence.";
  py::exception<OutputError>(m, "OutputError", PyExc_OSError);
  py::exception<StoreError>(m, "StoreError", PyExc_OSError);
  py::exception<ScenarioError>(m, "ScenarioError", PyExc_ValueError);
  py::exception<DataError>(m, "DataError", PyExc_ValueError);
  py::register_exception_translator(&translate_messages);

  py::class_<Told>(m, "Told")
      .def_readonly("verdict", &Told::verdict)
      .def_readonly("says", &Told::says)
      .def_readonly("p_value", &Told::p_value)
      .def_readonly("complete", &Told::complete)
      .def_readonly("is_sweep", &Told::is_sweep)
      .def("__deepcopy__", [](py::object told, const py::dict&) { return told; })  // nothing changes it
      .def("text", [](const Told& told) { return text_page(told.document); })
      .def("json", [](const Told& told) { return told.document.json(); })
      .def_readonly("tuned", &Told::tuned)
      .def(
          "write_report",
          [](const Told& told, const std::filesystem::path& folder) {
            write_document(told.document, folder);
          },
          py::call_guard<py::gil_scoped_release>());

  py::enum_<ArrayIndexing>(m, "Indexing")
      .value("single", ArrayIndexing::single)
      .value("stacked", ArrayIndexing::stacked)
      .value("listed", ArrayIndexing::listed);

  py::class_<CheckOptions>(m, "CheckOptions")
      .def(py::init([](std::string name, std::string format, std::vector<std::string> truths,
                       std::string topic, std::string truth_topic, std::optional<int> instance,
                       double max_time_difference, bool partial, double confidence, double within,
                       bool sensitivity, int threads) {
        CheckOptions options;
        options.name = std::move(name);
        options.format = std::move(format);
        options.truths = std::move(truths);
        options.reading.topic = std::move(topic);
        options.reading.truth_topic = std::move(truth_topic);
        options.reading.instance = instance;
        options.reading.matching.max_time_difference_s = max_time_difference;
        options.reading.partial = partial;
        options.confidence = confidence;
        options.within = within;
        options.sensitivity = sensitivity;
        options.threads = threads;
        return options;
      }));

  py::class_<ArrayBundle>(m, "Bundle")
      .def(py::init<std::optional<Doubles>, std::optional<Doubles>,
                    std::vector<std::tuple<Doubles, Doubles, std::optional<Doubles>>>,
                    std::optional<Doubles>>(),
           py::arg("error"), py::arg("P"), py::arg("innovations"), py::arg("estimate") = py::none());

  py::class_<Collector>(m, "Collector")
      .def(py::init<std::vector<std::string>, std::vector<bool>, std::vector<std::string>,
                    const std::vector<std::pair<std::string, std::vector<Index>>>&,
                    const std::vector<std::tuple<std::string, Index, Index, std::vector<bool>>>&, bool, bool,
                    bool>())
      .def("add", &Collector::add)
      .def("look", &Collector::look)
      .def("judge", &Collector::judge, py::arg("name"), py::arg("source"), py::arg("confidence"),
           py::arg("sensitivity"), py::arg("within") = 0.1, py::arg("dt") = 0.0);

  py::enum_<NoisePurpose>(m, "Purpose")
      .value("initial", NoisePurpose::initial)
      .value("process", NoisePurpose::process)
      .value("measurement", NoisePurpose::measurement);

  py::class_<NoiseSource>(m, "NoiseSource")
      .def(py::init<std::uint64_t, std::uint64_t>())
      .def("shaped",
           [](const NoiseSource& source, double process_correlation, double measurement_correlation,
              int student_dof, double outlier_rate, double outlier_scale) {
             return source.shaped({.correlation = process_correlation},
                                  {.correlation = measurement_correlation,
                                   .student_dof = student_dof,
                                   .outlier_rate = outlier_rate,
                                   .outlier_scale = outlier_scale});
           })
      .def("normals", &normals)
      .def("normals_of_four_steps", &normals_of_four_steps);

  m.attr("version") = std::string(version());
  m.attr("commit") = std::string(commit());
  m.def("check_logs", [](const std::vector<std::string>& logs, CheckOptions options, const std::string& chart,
                         const std::string& align, const std::string& truth_time,
                         const std::optional<std::variant<double, std::string>>& time_offset,
                         const std::vector<double>& lever_arm, const PythonProgress& progress) {
    TrajectoryMatching& matching = options.reading.matching;
    if (!chart.empty()) options.reading.chart = pose_chart_named(chart);
    matching.alignment = truth_alignment_named(align);
    matching.truth_time = truth_time == "nearest" ? TruthTime::nearest : TruthTime::interpolated;
    matching.lever_arm = lever_arm_of(lever_arm);
    if (time_offset) {
      if (const auto* word = std::get_if<std::string>(&*time_offset)) {
        matching.find_time_offset = *word == "each" ? TimeOffsetSearch::each : TimeOffsetSearch::together;
      } else {
        matching.time_offset_s = std::get<double>(*time_offset);
      }
    }
    return interruptible(
        [&](const std::atomic<bool>& stop, const std::shared_ptr<WorkDone>& done) {
          options.stop = &stop;
          options.progress = telling(done);
          return tell(check_logs(logs, options));
        },
        progress);
  });
  m.def("noise_group", [](const std::string& file, const std::optional<std::string>& text,
                          const std::vector<std::string>& overrides) {
    return noise_group(scenario_of(file, text, overrides));
  });
  m.def("has_sweep", [](const std::string& file, const std::optional<std::string>& text) {
    return !(text ? read_scenario_text(*text, file, {}) : open_scenario(file, {})).sweep.empty();
  });
  m.def("sweep", [](const std::string& file, const std::optional<std::string>& text,
                    const std::vector<std::string>& overrides, int threads, const PythonProgress& progress) {
    const ScenarioDocument document =
        text ? read_scenario_text(*text, file, overrides) : open_scenario(file, overrides);
    return played(threads, progress, [&](const PlayOptions& how) { return run_sweep(document, how); });
  });
  m.def("load", [](const std::filesystem::path& directory, int threads) {
    return played(threads, std::nullopt, [&](const PlayOptions& how) { return load_stored(directory, how); });
  });
  m.def("tune", [](const std::string& file, const std::optional<std::string>& text,
                   const std::vector<std::string>& overrides, const std::string& free, int threads,
                   const PythonProgress& progress) {
    const Scenario scenario = scenario_of(file, text, overrides);
    return played(threads, progress, [&](const PlayOptions& how) { return tune(scenario, free, how); });
  });
  m.def("tune_filter", &tune_filter);
  m.def("run", [](const std::string& file, const std::optional<std::string>& text,
                  const std::vector<std::string>& overrides, int threads, const PythonProgress& progress) {
    const Scenario scenario = scenario_of(file, text, overrides);
    return played(threads, progress, [&](const PlayOptions& how) { return run_scenario(scenario, how); });
  });
}

}  // namespace credence::internal
