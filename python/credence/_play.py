"""Plays runs of a world and a filter written in Python, a batch of them at once."""

from __future__ import annotations

import collections
import dataclasses
import inspect
import warnings
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Optional

import numpy as np

from . import _credence
from ._arrays import float_array

LARGEST_SEED = 2**64 - 1
CHUNK = 64  # runs that are judged as one
_MOST_CHUNKS, _MOST_DOUBLES = 8, 1 << 23  # of a batch; of its covariances, 64 MB
_OF_BATCHES = "world and filter are given batches, x is (B, n); those of one run take batch=False"
_INPUT_SLOTS = 1 << 20  # beyond those of the process noise
# As a share of a number or of its σ. The last bit of numpy's functions may depend on where an array lies (np.sin of a
# strided column); from a diffuse prior, variances of 1e11 times what is left, that bit may grow to this. Random numbers
# are far above it: even an average over a million of them differs by 1e-3 σ.
_ROUNDING = 1e-4


def batch_runs(steps: int, n: int) -> int:
    """Runs of one batch: whole chunks, by the size of a run alone, because how many there are may move the last bits."""
    return CHUNK * min(_MOST_CHUNKS, max(1, _MOST_DOUBLES // (CHUNK * steps * n * n)))


_MOST_DOF = 2**31 - 1


class PlugError(ValueError):
    """The world or the filter is not what ``study`` needs; the message says where."""


class _WorldRaised(Exception):
    """A function of the world raised, which no filter answers for."""

    def __init__(self, function: str, error: Exception):
        super().__init__(f"world.{function}() raises {type(error).__name__}: {error}")


def _of_world(world: Any, function: str, *given: Any) -> Any:
    """What the world's function returns. Raises _WorldRaised."""
    try:
        return getattr(world, function)(*given)
    except Exception as error:  # of the user's code
        raise _WorldRaised(function, error) from error


@dataclass(frozen=True)
class Switches:
    """What makes the noise of a study other than its filter believes, as the keys of [noise] in docs/scenario.md do."""

    outlier_rate: float = 0.0
    outlier_scale: float = 10.0
    student_dof: int = 0
    measurement_correlation: float = 0.0
    process_correlation: float = 0.0
    measurement_delay: int = 0

    def __post_init__(self) -> None:
        for key, value in vars(self).items():
            whole = key in ("student_dof", "measurement_delay")
            kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
            if isinstance(value, bool) or not isinstance(value, kinds):
                raise ValueError(f"noise['{key}'] = {value!r}: expected a {'whole ' if whole else ''}number")
        if not 0 <= self.student_dof <= _MOST_DOF:
            raise ValueError(f"noise['student_dof'] = {self.student_dof}: expected 0 to {_MOST_DOF}")
        if self.measurement_delay < 0:
            raise ValueError(f"noise['measurement_delay'] = {self.measurement_delay}: expected whole steps, from 0 on")


class Noise:
    """Standard normals of one step: a pure function of (seed, run, step, purpose, place in the order of drawing)."""

    def __init__(self, source: "_Source", step: int, purpose: _credence.Purpose, first_slot: int = 0):
        self._source, self._step, self._purpose, self._slot = source, step, purpose, first_slot

    def __call__(self, count: int) -> np.ndarray:
        """The next `count` of them: float64 (B, count), or (count,) without batches."""
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 0:
            raise ValueError(f"noise({count!r}): expected how many numbers, a whole number from 0")
        result = self._source.normals(self._step, self._purpose, self._slot, count)
        self._slot += count
        return result


class _Source:
    """The normals of a few runs; those of four steps are made at once."""

    def __init__(self, plan: "Plan", first_run: int, runs: int):
        s, batch = plan.switches, plan.batch
        self._noise = _credence.NoiseSource(plan.seed, plan.noise_group).shaped(
            s.process_correlation, s.measurement_correlation, s.student_dof, s.outlier_rate, s.outlier_scale
        )
        self._first_run, self._runs, self._batch = first_run, runs, batch
        self._blocks: dict = {}

    def normals(self, step: int, purpose, slot: int, count: int) -> np.ndarray:
        if step == 0 or slot > 0:
            result = self._noise.normals(self._first_run, self._runs, step, purpose, count, slot)
        else:
            first = step - (step - 1) % 4
            known = self._blocks.get((purpose, count))
            if known is None or known[0] != first:
                four = self._noise.normals_of_four_steps(self._first_run, self._runs, first, purpose, count)
                self._blocks[(purpose, count)] = known = (first, four)
            result = known[1][step - first].copy()
        return result if self._batch else result[0]


@dataclass
class Plan:
    world: Any
    make_filter: Callable[[], Any]
    steps: int
    seed: int
    noise_group: int
    batch: bool
    angles: Any = None
    switches: Switches = Switches()
    states: int = 0  # that there can be; 0: those of world.prior()


@dataclass
class Chunk:
    """What some runs showed: (runs, steps, …), NaN where nothing was shown, of errors also where there is no truth, and
    inf where the estimate is not finite. Of a state that is not there P is that of the identity."""

    error: np.ndarray
    P: np.ndarray
    innovations: "dict[str, tuple[np.ndarray, np.ndarray]]"
    estimate: Optional[np.ndarray]  # where the error is its difference from the truth
    failures: "dict[int, tuple[int, str, str]]" = field(default_factory=dict)
    no_batch: str = ""  # what a batch of these runs threw, each of which is well alone
    measured: bool = False  # at any step


def _shown(value: Any, name: str, shape: "tuple[int, ...]", runs: int) -> np.ndarray:
    """`value` as (runs, *shape), or as `shape`: the same for all runs."""
    array = float_array(value, name)
    if array.shape == (runs, *shape) or array.shape == shape:
        return array
    raise PlugError(f"{name} has shape {array.shape}: expected {(runs, *shape)} or {shape}")


def _own(value: Any) -> Any:
    """What another may change without harm: arrays copied, those of a mapping too; else the value itself."""
    if isinstance(value, Mapping):
        return {key: _own(one) for key, one in value.items()}
    return value.copy() if isinstance(value, np.ndarray) else value


def _minus(plan: Plan, estimate: Any, truth: Any, angles: np.ndarray) -> np.ndarray:
    if hasattr(plan.world, "minus"):
        try:
            return np.asarray(plan.world.minus(_own(estimate), _own(truth)), dtype=np.float64)
        except Exception as error:  # of the user's code; of an estimate that is not finite the filter's own
            finite = _finite(estimate)
            if finite is not None and finite.all():
                raise _WorldRaised("minus", error) from error
            raise
    shown, true = np.asarray(estimate, dtype=np.float64), np.asarray(truth, dtype=np.float64)
    if shown.shape != true.shape:  # which NumPy would broadcast
        raise PlugError(f"filter.state has shape {shown.shape}: expected {true.shape}")
    error = shown - true
    if angles.any():
        error[..., angles] = np.remainder(error[..., angles] + np.pi, 2.0 * np.pi) - np.pi
    return error


def _finite(estimate: Any) -> "Optional[np.ndarray]":
    """Which of its numbers are finite; None of a state of another kind, which world.minus alone can read."""
    try:
        return np.isfinite(np.asarray(estimate, dtype=np.float64))
    except (TypeError, ValueError):
        return None


def _is_lost(state: Any, error: np.ndarray, there: np.ndarray, runs: int) -> np.ndarray:
    """(runs,): whether the estimate has numbers that are not finite; NaN of the error alone says there is no truth."""
    finite = _finite(state)
    lost = (np.isnan(error) if finite is None else ~finite) & there
    return lost.reshape(runs, -1).any(axis=-1) if lost.shape[:1] == (runs,) else np.full(runs, lost.any())


def _innovations(made: Any, measured: Any, runs: int) -> "dict[str, tuple[np.ndarray, np.ndarray]]":
    """What the filter shows of its last update, by sensor."""
    # What a property throws is an error, an AttributeError too, and not that there is none.
    is_property = isinstance(inspect.getattr_static(type(made), "innovation", None), property)
    nu = made.innovation if is_property else getattr(made, "innovation", None)
    if nu is None or measured is None:
        return {}
    by_sensor, S = (nu, made.S) if isinstance(nu, Mapping) else ({"": nu}, {"": made.S})
    shown = {}
    for sensor, value in by_sensor.items():
        if value is None:
            continue
        label = f"['{sensor}']" if sensor else ""
        shape = np.shape(value)
        m = shape[-1] if shape else 0
        of_S = np.shape(S[sensor])
        if shape == (runs, runs) and of_S[-1:] != (runs,):
            raise PlugError(
                f"filter.innovation{label} has shape {shape}, and filter.S{label} {of_S}: is z, as measure() returns it, "
                f"of shape ({runs},), where ({runs}, m) is expected?"
            )
        shown[sensor] = (
            _shown(value, f"filter.innovation{label}", (m,), runs),
            _shown(S[sensor], f"filter.S{label}", (m, m), runs),
        )
    return shown


def prior_of(world: Any) -> "tuple[np.ndarray, np.ndarray, int]":
    """The mean (n,) and P (n, n) that a filter of this world starts from, and n."""
    told = world.prior()
    if not isinstance(told, (tuple, list)) or len(told) != 2:
        raise PlugError(f"world.prior() gives {type(told).__name__}: expected the mean (n,) and the covariance (n, n)")
    mean, P = told
    mean = float_array(mean, "the mean of world.prior()")
    if mean.ndim != 1 or mean.size == 0:
        raise PlugError(f"the mean of world.prior() has shape {mean.shape}: expected (n,)")
    n = mean.size
    P = float_array(P, "the covariance of world.prior()")
    if P.shape != (n, n):
        raise PlugError(f"the covariance of world.prior() has shape {P.shape}: expected {(n, n)}")
    for name, value in (("mean", mean), ("covariance", P)):
        if not np.all(np.isfinite(value)):
            raise PlugError(f"the {name} of world.prior() is not finite: {_brief(value.ravel())}")
    deviations = np.sqrt(np.abs(P.diagonal()))
    scale = np.where(deviations > 0.0, deviations, 1.0)
    correlation = P / scale / scale[:, None]
    if np.any(np.abs(correlation - correlation.T) > _ROUNDING):
        raise PlugError(f"the covariance of world.prior() is not symmetric, by rows: {_brief(P.ravel())}")
    if np.linalg.eigvalsh(correlation)[0] < -_ROUNDING:
        raise PlugError(f"the covariance of world.prior() is not positive semidefinite, by rows: {_brief(P.ravel())}")
    return mean, P, n


def _brief(array: np.ndarray) -> str:
    return np.array2string(array, threshold=10, separator=", ")


def _states_of(made: Any, n: int, runs: int) -> "tuple[np.ndarray, int]":
    """Which of the n states a filter with states() has, (n,) or (runs, n); and how many its arrays hold."""
    states = np.asarray(made.states())
    if states.dtype == bool and states.shape in ((n,), (runs, n)):
        return states, n
    there = np.zeros(n, dtype=bool)
    if states.ndim != 1 or (states.size and (states.dtype.kind not in "iu" or np.any(np.diff(states) < 1))):
        raise PlugError(
            f"filter.states() = {_brief(states)}: expected ascending numbers of states, from 0, or booleans of shape {(n,)} "
            f"or {(runs, n)}"
        )
    if states.size and not 0 <= states[0] <= states[-1] < n:
        raise PlugError(f"filter.states() = {_brief(states)}: there are {n} states; `names` has one for each that there can be")
    there[states.astype(int)] = True
    return there, states.size


def _spread(made: Any, n: int, runs: int) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """State (…, n), covariance (…, n, n) and which of them are there, of a filter with states(): NaN and the identity
    where one is not."""
    there, m = _states_of(made, n, runs)
    state, P = np.asarray(made.state, dtype=np.float64), np.asarray(made.covariance, dtype=np.float64)
    for name, array, row in (("state", state, (m,)), ("covariance", P, (m, m))):
        if array.shape not in (row, (runs, *row)):
            raise PlugError(f"filter.{name} has shape {array.shape}: expected {(runs, *row)}, of the states of states()")
    if m < n:
        own, own_P = state, P
        state, P = np.zeros((*own.shape[:-1], n)), np.zeros((*own_P.shape[:-2], n, n))
        state[..., there] = own
        P[..., there[:, np.newaxis] & there] = own_P.reshape(*own_P.shape[:-2], m * m)
    both = there[..., :, np.newaxis] & there[..., np.newaxis, :]
    return np.where(there, state, np.nan), np.where(both, P, np.eye(n)), there


def _initial(plan: Plan, runs: int):
    mean, P, n = prior_of(plan.world)
    if not plan.batch:
        return mean.copy(), P.copy(), n
    return np.tile(mean, (runs, 1)), np.tile(P, (runs, 1, 1)), n


def _told(world: Any, truth: Any, k: int, source: _Source, part: float = 1.0) -> list:
    """What predict is given: the input and the time of the step, or of a part of it, of a world that has them."""
    told = []
    if hasattr(world, "input"):
        noise = Noise(source, k, _credence.Purpose.process, _INPUT_SLOTS)
        told.append(_of_world(world, "input", _own(truth), k, noise))
    if hasattr(world, "dt"):
        told.append(world.dt * part)
    return told


class _Play:
    """Some runs, step by step; `step` is the one at hand when a filter throws."""

    def __init__(self, plan: Plan, first_run: int, runs: int):
        self.step = 1
        self._plan, self._first_run, self._runs = plan, first_run, runs

    def play(self) -> Chunk:
        plan, runs = self._plan, self._runs
        world, made = plan.world, plan.make_filter()
        source = _Source(plan, self._first_run, runs)
        mean, P0, n = _initial(plan, runs)
        n = max(n, plan.states)
        angles = np.zeros(n, dtype=bool)
        if plan.angles is not None:
            angles[plan.angles] = True
        error = np.full((runs, plan.steps, n), np.nan)
        estimate = None if hasattr(world, "minus") else error.copy()
        chunk = Chunk(error, np.empty((runs, plan.steps, n, n)), {}, estimate)
        self.chunk = chunk
        truth = _of_world(world, "initial", Noise(source, 0, _credence.Purpose.initial))
        made.reset(mean, P0)
        late = collections.deque()  # measurements on their way
        for k in range(1, plan.steps + 1):
            self.step = k
            truth = _of_world(world, "step", truth, k, Noise(source, k, _credence.Purpose.process))
            made.predict(*_told(world, truth, k, source))
            z = _of_world(world, "measure", _own(truth), k, Noise(source, k, _credence.Purpose.measurement))
            late.append(z)
            z = late.popleft() if len(late) > plan.switches.measurement_delay else None
            if z is not None:
                chunk.measured = True
                made.update(_own(z))
            self._show(made, truth, z, k, n, angles)
        self.name_diverged(plan.steps)
        return chunk

    def name_diverged(self, steps: int) -> None:
        """Runs whose numbers are not finite fail at the first of these steps where that is so."""
        chunk = self.chunk
        well = ~np.isinf(chunk.error[:, :steps]).any(axis=-1) & np.isfinite(chunk.P[:, :steps]).all(axis=(-2, -1))
        for nu, _ in chunk.innovations.values():
            well &= ~np.isinf(nu[:, :steps]).any(axis=-1)
        for run in np.flatnonzero(~well.all(axis=-1)):
            chunk.failures[int(run)] = (int(np.argmin(well[run])) + 1, "diverged", "its numbers are not finite")

    def _show(self, made: Any, truth: Any, z: Any, k: int, n: int, angles: np.ndarray) -> None:
        runs, chunk = self._runs, self.chunk
        state, covariance, there = made.state, made.covariance, np.True_
        if hasattr(made, "states"):
            state, covariance, there = _spread(made, n, runs)
        error = _minus(self._plan, state, truth, angles)
        if error.shape != ((runs, n) if self._plan.batch else (n,)):
            raise PlugError(f"filter.state minus the truth has shape {error.shape}: expected {(runs, n)}")
        P = _shown(covariance, "filter.covariance", (n, n), runs)
        chunk.error[:, k - 1], chunk.P[:, k - 1] = error, P
        chunk.error[_is_lost(state, error, there, runs), k - 1] = np.inf
        if chunk.estimate is not None:
            chunk.estimate[:, k - 1] = state
        for sensor, (nu, S) in _innovations(made, z, runs).items():
            if sensor not in chunk.innovations:
                m = nu.shape[-1]
                chunk.innovations[sensor] = (
                    np.full((runs, self._plan.steps, m), np.nan),
                    np.zeros((runs, self._plan.steps, m, m)),
                )
            all_nu, all_S = chunk.innovations[sensor]
            all_nu[:, k - 1], all_S[:, k - 1] = nu, S


def _joined(parts: "list[Chunk]") -> Chunk:
    sensors: dict[str, Any] = {}
    for part in parts:  # a sensor that only some runs show is missing in the others
        for sensor, pair in part.innovations.items():
            sensors.setdefault(sensor, pair)
    innovations = {}
    for sensor, (nu, S) in sensors.items():
        def of(part: Chunk, which: int, like: np.ndarray, sensor: str = sensor) -> np.ndarray:
            if sensor in part.innovations:
                return part.innovations[sensor][which]
            return np.full((len(part.error), *like.shape[1:]), np.nan)

        innovations[sensor] = (
            np.concatenate([of(part, 0, nu) for part in parts]),
            np.concatenate([of(part, 1, S) for part in parts]),
        )
    estimates = [part.estimate for part in parts if part.estimate is not None]
    joined = Chunk(
        np.concatenate([p.error for p in parts]),
        np.concatenate([p.P for p in parts]),
        innovations,
        np.concatenate(estimates) if estimates else None,
    )
    joined.no_batch = next((part.no_batch for part in parts if part.no_batch), "")
    joined.measured = any(part.measured for part in parts)
    first = 0
    for part in parts:
        joined.failures.update({first + run: failure for run, failure in part.failures.items()})
        first += len(part.error)
    return joined


def _play_alone(plan: Plan, run: int) -> Chunk:
    """One run; an exception of the filter ends it, and is told."""
    play = _Play(plan, run, 1)
    try:
        return play.play()
    except PlugError:
        raise
    except _WorldRaised as error:
        hint = f" ({_OF_BATCHES})" if plan.batch else ""
        raise PlugError(f"{error}, in run {run} at step {play.step}, seed {plan.seed}{hint}") from error.__cause__
    except Exception as error:  # of the user's code, whatever it is
        if not hasattr(play, "chunk"):
            raise
        play.name_diverged(play.step - 1)
        said = f"seed {plan.seed}: {type(error).__name__}: {error}"
        play.chunk.failures.setdefault(0, (play.step, "threw", said))
        return play.chunk


def play_batch(plan: Plan, first_run: int, runs: int) -> Chunk:
    """All runs of a batch at once; where that throws, chunk by chunk, and then one by one, to find which."""
    thrown = ""
    if plan.batch:
        try:
            return _Play(plan, first_run, runs).play()
        except PlugError:
            raise
        except Exception as error:  # of the user's code
            raised = error.__cause__ if isinstance(error, _WorldRaised) else error
            thrown = f"{type(raised).__name__}: {raised}"
    if plan.batch and runs > CHUNK:
        firsts = range(first_run, first_run + runs, CHUNK)
        return _joined([play_batch(plan, first, min(CHUNK, first_run + runs - first)) for first in firsts])
    alone = _joined([_play_alone(plan, run) for run in range(first_run, first_run + runs)])
    if runs > 1 and not any(outcome == "threw" for _, outcome, _ in alone.failures.values()):
        alone.no_batch = thrown
    return alone


def warn_of_no_batch(chunk: Chunk, told: bool) -> bool:
    """Warns, unless that was `told`, of runs that no batch could be made of; whether it is told now."""
    if told or not chunk.no_batch:
        return told
    warnings.warn(
        f"batches cannot be played, as they raise {chunk.no_batch}; each of the runs alone does not: they are played one "
        "by one, many times slower (batches are given x of (B, n) and z as world.measure makes it)",
        RuntimeWarning,
        stacklevel=4,
    )
    return True


def require_functions(world: Any, made: Any) -> None:
    """Raises PlugError for a world or a filter without a function that it needs, or given as a class."""
    for plug, what, functions in (
        (world, "world", ("prior", "initial", "step", "measure")),
        (made, "filter", ("reset", "predict", "update")),
    ):
        if isinstance(plug, type):
            raise PlugError(f"the {what} is the class {plug.__name__}: " + ("expected one of it" if plug is world
                            else "filter() is to make one of it"))
        for name in functions:
            if not callable(getattr(plug, name, None)):
                raise PlugError(
                    f"the {what} {type(plug).__name__} has no {name}(): it needs {', '.join(f'{f}()' for f in functions)}"
                    + (", .state and .covariance" if what == "filter" else "")
                )
    dt = getattr(world, "dt", 1.0)
    if np.ndim(dt) == 0 and not (isinstance(dt, (int, float, np.integer, np.floating)) and 0 < dt <= 1e6):
        raise PlugError(f"world.dt = {dt!r}: expected the time of a step in s, at most 1e6")


def _require_one_that_runs(plan: Plan, runs: int, tried: Chunk) -> None:
    """Where all runs throw, the first exception is of the plug, and no news of its covariance."""
    if len(tried.failures) < runs or any(outcome != "threw" for _, outcome, _ in tried.failures.values()):
        return
    play = _Play(plan, 0, runs if plan.batch else 1)
    try:
        play.play()
    except Exception as error:  # of the user's code
        hints = []
        if plan.batch:
            hints.append(_OF_BATCHES)
        if hasattr(plan.world, "dt"):
            hints.append("of a world with dt predict() is given the time of the step, last")
        raise PlugError(
            f"every run fails, the first at step {play.step}: {type(error).__name__}: {error}"
            + "".join(f" ({hint})" for hint in hints)
        ) from error


def require_time_step(plan: Plan) -> None:
    """From P = 0 a prediction leaves nothing but process noise, which two halves of a step make as large as one."""
    if not hasattr(plan.world, "dt"):
        return
    mean, P, n = _initial(plan, 1)

    def variances(parts: int) -> np.ndarray:
        made = plan.make_filter()
        made.reset(mean.copy(), np.zeros_like(P))
        for _ in range(parts):
            made.predict(*_told(plan.world, mean, 1, _Source(plan, 0, 1), 1.0 / parts))
        return np.diagonal(np.asarray(made.covariance, dtype=np.float64).reshape(-1, n, n)[0])

    try:
        once, twice = variances(1), variances(2)
    except Exception:  # a filter that cannot start from certainty, or a world whose state is no vector
        return
    least = np.min(twice[once > 0.0] / once[once > 0.0], initial=np.inf)
    if 1.5 <= least < np.inf:  # noise that is the same at each call gives 2 or more
        raise PlugError(
            "Q does not scale with dt: two predictions of half a step give every state at least "
            f"{least:.3g} times the variance of one of the whole step; scale Q by the time that predict() is given, or leave "
            "out the dt of the world"
        )


def require_same_twice(plan: Plan, runs: int) -> None:
    """Plays the first runs twice, as far as the first measurement and 5 steps at least."""
    runs = min(runs, CHUNK if plan.batch else 2)
    steps = min(plan.steps, 5)
    while True:
        short = dataclasses.replace(plan, steps=steps)
        once, again = play_batch(short, 0, runs), play_batch(short, 0, runs)
        _require_one_that_runs(short, runs, once)
        _require_same(once, again)
        if once.measured or steps == plan.steps:
            return
        steps = min(plan.steps, 2 * steps)


def _require_same(once: Chunk, again: Chunk) -> None:
    def deviations(P: np.ndarray) -> np.ndarray:
        return np.sqrt(np.abs(np.diagonal(P, axis1=-2, axis2=-1)))

    deviation = deviations(once.P)
    compared = [
        ("error", once.error, again.error, deviation),
        ("covariance", once.P, again.P, deviation[..., :, np.newaxis] * deviation[..., np.newaxis, :]),
    ]
    for sensor, (nu, S) in once.innovations.items():
        of_again = again.innovations.get(sensor, (np.empty(0), None))[0]
        if of_again.shape == nu.shape:
            compared.append((f"innovation of {sensor}" if sensor else "innovation", nu, of_again, deviations(S)))
    for name, a, b, scale in compared:
        with np.errstate(invalid="ignore"):  # of inf - inf, which are of runs that failed
            close = np.abs(a - b) <= _ROUNDING * np.maximum(np.abs(a), scale)
        same = close | (a == b) | (np.isnan(a) & np.isnan(b))
        for run in once.failures.keys() | again.failures.keys():
            same[run] = True
        if not same.all():
            at = tuple(np.argwhere(~same)[0])
            raise PlugError(
                f"run {at[0]} is not the same twice, in its {name} at step {at[1] + 1}, {a[at]:.6g} and then "
                f"{b[at]:.6g}, which is more than rounding: the world or the filter draws random numbers of its own, or "
                "keeps something from run to run"
            )
