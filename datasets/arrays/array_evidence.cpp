#include "datasets/arrays/array_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "analysis/evidence/sums/evidence_recorder.h"
#include "core/parallel_tasks.h"
#include "core/stop_point.h"
#include "datasets/arrays/array_reader.h"
#include "montecarlo/engine/engine.h"

namespace credence::internal {
namespace {

Evidence add_chunk(const ArrayRuns& arrays, std::int64_t first, std::int64_t last,
                   CalibrationRecorder* calibration, JudgedStates& judged) {
  EvidenceRecorder recorder(arrays.layout);
  ArrayReader reader(arrays);
  Step step;
  for (std::int64_t r = first; r < last; ++r) {
    const ArrayRun& run = arrays.runs[static_cast<std::size_t>(r)];
    const std::string name = fmt::format("run {}", arrays.first_run + r);
    recorder.begin_file(name, arrays.layout);
    recorder.begin_run();
    judged.begin_run(name, arrays.layout);
    if (calibration != nullptr) calibration->begin_run(arrays.layout, name);
    for (std::int64_t row = 0; row < run.steps; ++row) {
      stop_point();
      reader.read(r, row, step);
      const bool taken = recorder.add(step);
      judged.add(step);
      if (taken && calibration != nullptr) calibration->add(step, kNaN, recorder.factored());
    }
    if (run.failure) {
      recorder.end_run(run.failure->outcome, run.failure->step);
      if (calibration != nullptr) calibration->drop_run();
      judged.failed();
    }
    judged.end_run();
  }
  return recorder.take();
}

}  // namespace

Evidence add_arrays(const ArrayRuns& arrays, int threads, const std::atomic<bool>* stop,
                    CalibrationUnits* calibration, JudgedStates* judged) {
  if (std::ranges::all_of(arrays.runs, [](const ArrayRun& run) { return run.steps == 0 && !run.failure; })) {
    throw std::invalid_argument("the arrays hold no step");
  }
  const std::int64_t runs = std::ssize(arrays.runs);
  std::vector<Evidence> chunks(static_cast<std::size_t>((runs + kChunkRuns - 1) / kChunkRuns));
  std::vector<CalibrationRecorder> recorders(calibration != nullptr ? chunks.size() : 0);
  std::vector<JudgedStates> states(chunks.size());
  for_each_task(std::ssize(chunks), threads, stop, [&](std::int64_t chunk) {
    const std::int64_t first = chunk * kChunkRuns;
    const auto i = static_cast<std::size_t>(chunk);
    chunks[i] = add_chunk(arrays, first, std::min(runs, first + kChunkRuns),
                          recorders.empty() ? nullptr : &recorders[i], states[i]);
  });
  for (CalibrationRecorder& recorder : recorders) calibration->append(recorder);
  for (const JudgedStates& of_chunk : states) {
    if (judged != nullptr) judged->merge(of_chunk);
  }
  Evidence all;
  for (Evidence& chunk : chunks) all.merge(std::move(chunk));
  return all;
}

}  // namespace credence::internal
