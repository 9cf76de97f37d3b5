"""Studies of a world and a filter written in Python."""

from __future__ import annotations

import dataclasses
import inspect
from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from . import _credence
from ._arrays import require_flag, require_text, states_of
from ._check import collector, innovation_angles_of, require_confidence, require_layout, require_whole
from ._play import LARGEST_SEED, Chunk, Plan, PlugError, Switches, batch_runs, prior_of
from ._play import require_functions, require_same_twice, require_time_step, warn_of_no_batch
from ._players import Players
from ._result import Result


MOST_RUNS, MOST_STEPS = 10**9, 10**7  # as study.runs of a scenario, and as logs have them
MOST_WORKERS = 4096


def switches_of(noise: Optional[Mapping[str, Any]]) -> Switches:
    if noise is not None and not isinstance(noise, Mapping):
        raise ValueError(f"noise = {noise!r}: expected a dict, as {{'outlier_rate': 0.01}}")
    known = [field.name for field in dataclasses.fields(Switches)]
    for key in noise or {}:
        if key not in known:
            raise ValueError(f"noise['{key}']: expected one of {', '.join(known)}")
    return Switches(**(noise or {}))


def _refused_arguments(filter: Callable[..., Any], factors: Mapping[str, Any]) -> str:
    """Why it cannot be called with these; empty where it can, or where nobody knows."""
    try:
        signature = inspect.signature(filter)
    except (TypeError, ValueError):  # of compiled code
        return ""
    try:
        signature.bind(**factors)
    except TypeError as error:
        return str(error)
    return ""


def made_by(filter: Callable[..., Any], **factors: Any) -> Any:
    """A filter. Raises PlugError for what makes none, or not of these arguments."""
    if not callable(filter):
        raise PlugError(f"the filter is a {type(filter).__name__}: expected what makes one when it is called, as its class")
    try:
        return filter(**factors)
    except TypeError as error:
        refused = _refused_arguments(filter, factors)
        if not refused:
            raise
        name = getattr(filter, "__name__", type(filter).__name__)
        call = f"{name}({', '.join(f'{factor}={value}' for factor, value in factors.items())})"
        hint = f"; {', '.join(factors)} of `start` are its keyword arguments" if factors else ""
        raise PlugError(f"the filter is to be made by {call}, which fails: {refused}{hint}") from error


def plugged_states(
    world: Any, made: Any, names: Optional[Sequence[str]], angles: Any
) -> "tuple[Optional[Sequence[str]], int, np.ndarray]":
    """The names, how many states there can be, and which are angles. Raises PlugError for a world or filter that is none."""
    require_functions(world, made)
    n = prior_of(world)[2]
    if hasattr(made, "states") and names is not None:
        names = list(names)
        n = max(n, len(names))
    return names, n, np.flatnonzero(states_of(names, angles, n)[1])


class _LateSensors(Exception):
    """The filter has sensors that the first runs did not show, by name with their dimension."""

    def __init__(self, dims: "dict[str, int]"):
        super().__init__()
        self.dims = dims


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
    units: Any = None,
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
        the truth may be anything that ``state`` can be subtracted from. NaN where the estimate is finite: no truth of
        that state there.

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
        ``if __name__ == "__main__":``. The same runs are always one batch: but for what numpy rounds by where an array
        lies, the bits do not depend on it.
    names, angles, units, innovation_angles, blocks, confidence, nonlinear, inflated: as in ``check``.
    noise: what makes it other than a filter believes: {"outlier_rate": 0.01, "outlier_scale": 10, "student_dof": 4,
        "measurement_correlation": 0.5, "process_correlation": 0.5, "measurement_delay": 1}, each as the key of [noise]
        in docs/scenario.md. Of what world.step and world.input draw, and of what world.measure draws.

    An exception of the filter is a failed run, which is counted and named with seed, run and step: the batch is then
    played run by run; so is one of world.minus of an estimate that is not finite. Raises PlugError, a ValueError, for a
    world or filter that is not such, and for a world that raises.
    """
    runs, steps = require_whole(runs, "runs", 1, MOST_RUNS), require_whole(steps, "steps", 1, MOST_STEPS)
    seed = require_whole(seed, "seed", 0, LARGEST_SEED)
    noise_group = require_whole(noise_group, "noise_group", 0, LARGEST_SEED)
    workers = require_whole(workers, "workers", 1, MOST_WORKERS)
    require_confidence(confidence)
    require_text(name, "name")
    batch = require_flag(batch, "batch")
    names, n, marked = plugged_states(world, made_by(filter), names, angles)
    require_layout(names, angles, units, blocks, n, nonlinear, inflated)
    plan = Plan(world, filter, steps, seed, noise_group, batch, marked, switches_of(noise), n)
    require_same_twice(plan, runs)
    require_time_step(plan)

    size = batch_runs(steps, n)
    bounds = [(first, min(size, runs - first)) for first in range(0, runs, size)]
    told = False

    def collected_of(players: Players, dims: "dict[str, int]") -> Any:
        """Of sensors that are known, and those of the first batch."""
        collected: Any = None

        def add(chunk: Chunk) -> None:
            nonlocal collected, told
            told = warn_of_no_batch(chunk, told)
            first = collected is None
            if first:
                dims.update({s: nu.shape[-1] for s, (nu, _) in chunk.innovations.items() if s not in dims})
                sensors = [(s, m, m, innovation_angles_of(innovation_angles, s, m)) for s, m in dims.items()]
                collected = collector(names, angles, units, blocks, n, sensors, True, nonlinear, inflated)
            late = {s: nu.shape[-1] for s, (nu, _) in chunk.innovations.items() if s not in dims}
            if late:
                raise _LateSensors(late)
            pairs = []
            for sensor, m in dims.items():
                shape = (*chunk.error.shape[:2], m)
                silent = np.full(shape, np.nan), np.broadcast_to(np.eye(m), (*shape, m))
                pairs.append((*chunk.innovations.get(sensor, silent), None))
            bundle = _credence.Bundle(chunk.error, chunk.P, pairs, chunk.estimate)
            if first:
                collected.look([bundle], _credence.Indexing.stacked, chunk.failures, True)
            collected.add([bundle], _credence.Indexing.stacked, 0, chunk.failures)

        players.play(plan, bounds, add)
        return collected

    dims: "dict[str, int]" = {}
    while True:  # from the first run on for every sensor that is heard late
        try:
            with Players(workers) as players:
                collected = collected_of(players, dims)
            break
        except _LateSensors as late:
            dims.update(late.dims)
    if innovation_angles is not None and not dims:
        raise ValueError("innovation_angles belongs to filter.innovation, which is None at every step")
    if isinstance(innovation_angles, Mapping) and not set(innovation_angles) <= set(dims):
        raise ValueError(f"innovation_angles has the sensors {sorted(innovation_angles)}, the filter's innovation {sorted(dims)}")
    source = f"simulated, {steps} steps, seed {seed}"
    dt = getattr(world, "dt", 0.0)
    return Result(collected.judge(name, source, confidence, False, dt=float(dt) if np.ndim(dt) == 0 else 0.0))
