"""The noise that a filter written in Python should believe in."""

from __future__ import annotations

import functools
import math
from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from . import _credence
from ._arrays import require_flag
from ._check import require_confidence, require_layout, require_whole
from ._play import CHUNK, LARGEST_SEED, Chunk, Plan, require_same_twice, warn_of_no_batch
from ._players import Players
from ._result import Result
from ._study import MOST_RUNS, MOST_STEPS, MOST_WORKERS, made_by, plugged_states, study, switches_of
from ._tune import Told


class FilterTuning(Told):
    """A tuned filter: ``tuning.parameters``, the ``factors`` to make it with, and its verdict on fresh noise."""

    def __init__(self, told: _credence.Told, start: Mapping[str, float]):
        super().__init__(told)
        self.factors: "dict[str, float]" = dict(start)
        """What to make the filter with; of a factor that is not identifiable its start, or the limit nearest to it."""
        for name, p in self.parameters.items():
            self.factors[name] = p.value if p.identifiable else float(np.clip(start[name], *_limits(p.lower, p.upper)))
        self.held_out: Optional[Result] = None
        """The study of the tuned filter with the noise of the next seed; None where nothing could be told."""
        self.before: Optional[Result] = None
        """The same study of the filter as it was."""

    def __repr__(self) -> str:
        told = super().__repr__()
        if self.before is None or self.held_out is None:
            return told
        tuned = self.held_out.verdict
        text = f"{told.rstrip()}\n\nVerdict on fresh noise: {self.before.verdict} as it was, {tuned} with the tuned noise"
        if tuned != "consistent":
            text += f" ({self.held_out.says}; more runs tune more closely, and docs/tune.md tells how often a right form is called so)"
        return text + ".\n"


def _limits(lower: float, upper: float) -> "tuple[float, float]":
    return -math.inf if math.isnan(lower) else lower, math.inf if math.isnan(upper) else upper


def _lag_one(u: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """(runs,): Σ of u (runs, steps, m), 0 where not shown, times what its component showed last, however long ago."""
    last = np.maximum.accumulate(np.where(shown, np.arange(u.shape[1])[:, np.newaxis], 0), axis=1)
    return (u[:, 1:] * np.take_along_axis(u, last[:, :-1], axis=1)).sum(axis=(-2, -1))


class _Scores:
    """Sums over the steps of each run."""

    def __init__(self) -> None:
        self.value: "list[np.ndarray]" = []
        self.nis: "list[np.ndarray]" = []
        self.lag_one: "list[np.ndarray]" = []
        self.steps = self.dof = 0.0
        self.ok, self.composite = True, False

    def add(self, chunk: Chunk) -> None:
        runs = len(chunk.error)
        value, nis, lag_one = np.zeros(runs), np.zeros(runs), np.zeros(runs)
        self.ok = self.ok and not chunk.failures and bool(chunk.innovations)
        heard = np.zeros(chunk.error.shape[:2], dtype=bool)  # runs and steps
        for nu, S in chunk.innovations.values() if self.ok else ():
            shown = np.isfinite(nu)
            both = shown[..., :, np.newaxis] & shown[..., np.newaxis, :]
            try:  # with 1 for the variance of a silent component the others have the root of their own block
                root = np.linalg.cholesky(np.where(both, S, np.eye(nu.shape[-1])))
            except np.linalg.LinAlgError:
                self.ok = False
                break
            u = np.linalg.solve(root, np.where(shown, nu, 0.0)[..., None])[..., 0]
            logarithms = np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
            dof = shown.sum(axis=-1)
            value -= (0.5 * dof * math.log(2.0 * math.pi) + 0.5 * (u**2).sum(axis=-1) + logarithms).sum(axis=-1)
            nis += (u**2).sum(axis=(-2, -1))
            lag_one += _lag_one(u, shown)
            self.composite = self.composite or bool((heard & (dof > 0)).any())
            heard |= dof > 0
            self.dof += float(dof.sum())
        self.steps += float(heard.sum())
        self.value.append(value)
        self.nis.append(nis)
        self.lag_one.append(lag_one)

    def all(self) -> "tuple[np.ndarray, np.ndarray, np.ndarray, float, float, bool, bool]":
        sums = [np.concatenate(part) for part in (self.value, self.nis, self.lag_one)]
        return sums[0], sums[1], sums[2], self.steps, self.dof, self.ok, self.composite


def _factors(start: Mapping[str, float]) -> "dict[str, float]":
    if not isinstance(start, Mapping):
        raise ValueError(f"start = {start!r}: expected factors by name, as {{'q': 1.0}}")
    for name, value in start.items():
        if not isinstance(name, str) or not name.isidentifier():
            raise ValueError(f"start: {name!r}: expected the name of an argument of the filter")
        if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
            raise ValueError(f"start: {name} = {value!r}: expected a number")
    return {name: float(value) for name, value in start.items()}


def tune_filter(
    world: Any,
    filter: Callable[..., Any],
    start: Mapping[str, float],
    *,
    runs: int = 100,
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
    noise: Optional[Mapping[str, Any]] = None,
) -> FilterTuning:
    """The factors with which the innovations of a filter written in Python score highest.

    world: as in ``study``.
    filter(**factors): makes a fresh filter, as in ``study``; it must have innovation and S.
    start: the present factors by name, each > 0, such as {"Q": 1.0, "R": 1.0}.

    The runs are played again with the same noise for every trial of the factors. Nothing is judged on the runs tuned on:
    ``held_out`` and ``before`` are studies with as many runs of the next seed.
    names, angles, units, innovation_angles, blocks, confidence, nonlinear, inflated, batch, workers, noise: as in ``study``.
    A trial that any run fails in is no better than any other; with `start` none may.

    Raises ValueError for no factor or one that is not positive, and for a filter that has no scores with its start; PlugError as
    ``study``, and for a filter that does not take the factors as keyword arguments.
    """
    runs, steps = require_whole(runs, "runs", 1, MOST_RUNS), require_whole(steps, "steps", 1, MOST_STEPS)
    seed = require_whole(seed, "seed", 0, LARGEST_SEED)
    noise_group = require_whole(noise_group, "noise_group", 0, LARGEST_SEED)
    workers = require_whole(workers, "workers", 1, MOST_WORKERS)
    require_confidence(confidence)
    batch = require_flag(batch, "batch")
    factors = _factors(start)
    names, n, marked = plugged_states(world, made_by(filter, **factors), names, angles)
    require_layout(names, angles, units, blocks, n, nonlinear, inflated)
    switches = switches_of(noise)
    bounds = [(first, min(CHUNK, runs - first)) for first in range(0, runs, CHUNK)]
    told = False

    def plan_with(values: Sequence[float]) -> Plan:
        make = functools.partial(filter, **dict(zip(factors, values)))
        return Plan(world, make, steps, seed, noise_group, batch, marked, switches, n)

    def play(players: Players, values: Sequence[float]) -> Any:
        scores = _Scores()

        def add(chunk: Chunk) -> None:
            nonlocal told
            told = warn_of_no_batch(chunk, told)
            scores.add(chunk)

        players.play(plan_with(values), bounds, add)
        return scores.all()

    require_same_twice(plan_with(list(factors.values())), runs)
    with Players(workers) as players:
        score = functools.partial(play, players)
        tuning = FilterTuning(_credence.tune_filter(list(factors.items()), runs, confidence, score), factors)
    if any(p.identifiable for p in tuning.parameters.values()):
        def fresh(values: Mapping[str, float]) -> Result:
            return study(
                world, functools.partial(filter, **values), runs=runs, steps=steps, noise_group=noise_group, names=names,
                seed=seed + 1 if seed < LARGEST_SEED else 0, angles=angles, units=units, innovation_angles=innovation_angles,
                blocks=blocks, confidence=confidence, nonlinear=nonlinear, inflated=inflated, batch=batch,
                workers=workers, noise=noise,
            )  # fmt: skip

        tuning.before, tuning.held_out = fresh(factors), fresh(tuning.factors)
    return tuning
