"""Studies of a world and a filter written in Python."""

from __future__ import annotations

import concurrent.futures.process
import dataclasses
import multiprocessing
from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from . import _credence
from ._arrays import require_text, states_of
from ._check import collector, innovation_angles_of, require_confidence, require_whole
from ._play import LARGEST_SEED, Chunk, Plan, PlugError, Switches, batch_runs, play_batch, prior_of
from ._play import require_functions, require_same_twice, require_time_step, warn_of_no_batch
from ._result import Result


MOST_RUNS, MOST_STEPS = 10**9, 10**7  # as study.runs of a scenario, and as logs have them
_MOST_WORKERS = 4096


def _switches(noise: Optional[Mapping[str, Any]]) -> Switches:
    known = [field.name for field in dataclasses.fields(Switches)]
    for key in noise or {}:
        if key not in known:
            raise ValueError(f"noise['{key}']: expected one of {', '.join(known)}")
    return Switches(**(noise or {}))


def _play_in_processes(
    plan: Plan, bounds: "list[tuple[int, int]]", workers: int, add: Callable[[Chunk], None]
) -> None:
    """Plays the batches (first run, runs) and hands them on in their order. Whatever ends it, Ctrl-C among it, ends the
    processes at once."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)  # the script is being imported by a worker: the study that started it tells
    context = multiprocessing.get_context("spawn")
    pool = concurrent.futures.ProcessPoolExecutor(workers, mp_context=context)
    done = 0
    try:
        waiting = [pool.submit(play_batch, plan, *b) for b in bounds]
        for place, future in enumerate(waiting):
            add(future.result())
            done += 1
            waiting[place] = None  # type: ignore[call-overload]  # its arrays are no longer needed
    except BaseException as error:
        for process in list((getattr(pool, "_processes", None) or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        if done == 0 and isinstance(error, concurrent.futures.process.BrokenProcessPool):
            raise RuntimeError(
                "a process of workers ended before it played a run: the script must call study under "
                '`if __name__ == "__main__":`, world and filter must be importable (not of a notebook or of stdin), '
                "and memory must suffice for all of them"
            ) from None
        raise
    pool.shutdown()


def study(
    world: Any,
    filter: Callable[[], Any],
    *,
    runs: int = 1000,
    steps: int = 100,
    seed: int = 1,
    noise_group: int = 0,
    names: Optional[Sequence[str]] = None,
    angles: Any = None,
    innovation_angles: Any = None,
    blocks: Optional[Mapping[str, Any]] = None,
    confidence: float = 0.95,
    nonlinear: bool = False,
    inflated: bool = False,
    batch: bool = True,
    workers: int = 1,
    name: str = "study",
    noise: Optional[Mapping[str, Any]] = None,
) -> Result:
    """Judges a filter in a world, both written in Python, by a Monte Carlo study.

    world and filter work on batches: B runs at once, so that one call serves up to 512 of them. Arrays are float64.

    world.prior() -> mean (n,), P (n, n): what the filter starts from.
    world.initial(noise) -> x (B, n): the truth at the start. noise(c) gives (B, c) standard normals.
    world.step(x, k, noise) -> x: the truth at step k = 1, 2, …
    world.measure(x, k, noise) -> z: what the filter is given; None where nothing is measured.
    world.input(x, k, noise), if there is one: what predict is given.
    world.dt, if there is one: the time of a step, s, which predict is given last; a Q that does not scale with it is
        an error.
    world.minus(estimate, truth) -> (B, n), if there is one: the error. Otherwise the difference, angles wrapped; then
        the truth may be anything that ``state`` can be subtracted from.

    filter() makes a fresh filter:
    .reset(mean, P): (B, n) and (B, n, n), which are the filter's own. .predict() or .predict(input). .update(z).
    .state (B, n) and .covariance (B, n, n), or (n, n) if it is the same in all runs.
    .innovation (B, m) and .S (B, m, m) or (m, m), if it has them; dicts by sensor if there are several.
    .states(), of a filter whose state grows, as a map does: the numbers of the states that it has, of those of the world,
        from 0; .state and .covariance are of these alone. Where the runs of a batch differ: booleans (B, n), with .state
        and .covariance of all n. `names` has all n, and world.minus is given NaN for a state that is not there.

    batch=False: for a filter of one run, without the axis B; many times slower.
    noise_group: studies of one seed and group meet the same noise.
    workers: processes; world and filter must then be importable, and the script guarded by
        ``if __name__ == "__main__":``. The bits do not depend on it: the same runs are always one batch.
    names, angles, innovation_angles, blocks, confidence, nonlinear, inflated: as in ``check``.
    noise: what makes it other than a filter believes: {"outlier_rate": 0.01, "outlier_scale": 10, "student_dof": 4,
        "measurement_correlation": 0.5, "process_correlation": 0.5, "measurement_delay": 1}, each as the key of [noise]
        in docs/scenario.md. Of what world.step and world.input draw, and of what world.measure draws.

    An exception of the filter is a failed run, which is counted and named with seed, run and step: the batch is then
    played run by run. Raises PlugError, a ValueError, for a world or filter that is not such.
    """
    runs, steps = require_whole(runs, "runs", 1, MOST_RUNS), require_whole(steps, "steps", 1, MOST_STEPS)
    seed = require_whole(seed, "seed", 0, LARGEST_SEED)
    noise_group = require_whole(noise_group, "noise_group", 0, LARGEST_SEED)
    workers = require_whole(workers, "workers", 1, _MOST_WORKERS)
    require_confidence(confidence)
    made = filter()
    require_functions(world, made)
    n = prior_of(world)[2]
    if hasattr(made, "states") and names is not None:
        names = list(names)
        n = max(n, len(names))
    marked = np.flatnonzero(states_of(names, angles, n)[1])
    require_text(name, "name")
    plan = Plan(world, filter, steps, seed, noise_group, batch, marked, _switches(noise), n)
    require_same_twice(plan, runs)
    require_time_step(plan)

    size = batch_runs(steps, n)
    bounds = [(first, min(size, runs - first)) for first in range(0, runs, size)]
    collected, sensors, told = None, [], False

    def add(chunk: Chunk) -> None:
        nonlocal collected, sensors, told
        told = warn_of_no_batch(chunk, told)
        first = collected is None
        if first:
            sensors = [
                (sensor, nu.shape[-1], nu.shape[-1], innovation_angles_of(innovation_angles, sensor, nu.shape[-1]))
                for sensor, (nu, _) in chunk.innovations.items()
            ]
            collected = collector(names, angles, blocks, n, sensors, True, nonlinear, inflated)
        late = chunk.innovations.keys() - {sensor for sensor, *_ in sensors}
        if late:
            raise PlugError(f"filter.innovation has a sensor {sorted(late)} that the first {size} runs never show")
        pairs = []
        for sensor, m, *_ in sensors:
            shape = (*chunk.error.shape[:2], m)
            silent = np.full(shape, np.nan), np.broadcast_to(np.eye(m), (*shape, m))
            pairs.append((*chunk.innovations.get(sensor, silent), None))
        bundle = _credence.Bundle(chunk.error, chunk.P, pairs, chunk.estimate)
        if first:
            collected.look([bundle], _credence.Indexing.stacked, chunk.failures, True)
        collected.add([bundle], _credence.Indexing.stacked, 0, chunk.failures)

    if workers > 1:
        _play_in_processes(plan, bounds, workers, add)
    else:
        for first, count in bounds:
            add(play_batch(plan, first, count))
    source = f"simulated, {steps} steps, seed {seed}"
    dt = getattr(world, "dt", 0.0)
    return Result(collected.judge(name, source, confidence, False, dt=float(dt) if np.ndim(dt) == 0 else 0.0))
