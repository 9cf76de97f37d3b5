"""Verdicts on arrays."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Sequence

import numpy as np

from . import _credence
from ._arrays import float_array, following, indices, leading, require_distinct, require_flag, require_text, states_of
from ._arrays import units_of
from ._result import Result

Progress = Callable[[float, float], Any]
"""Told (done, total) every so often."""


def _by_sensor(value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        return {"": value}
    return {require_text(sensor, "the name of a sensor"): of_sensor for sensor, of_sensor in value.items()}


def _label(array: str, sensor: str) -> str:
    return f"{array}['{sensor}']" if sensor else array


def _observation(observation: Any, sensor: str, m: int) -> int:
    piece = observation.get(sensor, m) if isinstance(observation, Mapping) else observation
    if piece is None:
        return m
    if isinstance(piece, bool) or not isinstance(piece, (int, np.integer)) or piece < 1 or m % piece:
        raise ValueError(f"{_label('observation', sensor)} = {piece}: expected a divisor of the {m} components")
    return int(piece)


def _noise(R: Any, sensor: str, m: int, piece: int) -> Any:
    """R of all components of an innovation of a sensor, where it is given for one observation of it."""
    R = R.get(sensor) if isinstance(R, Mapping) else R
    if piece < m and np.shape(R) == (piece, piece):
        return np.kron(np.eye(m // piece), float_array(R, _label("R", sensor)))
    return R


def innovation_angles_of(which: Any, sensor: str, piece: int) -> "list[bool]":
    """Of one observation of a sensor; none: []."""
    which = which.get(sensor) if isinstance(which, Mapping) else which
    if which is None or which is False:
        return []
    angle = np.zeros(piece, dtype=bool)
    components = [str(i) for i in range(piece)]
    label = _label("innovation_angles", sensor)
    angle[indices(slice(None) if which is True else which, components, label, "component", "innovation")] = True
    return angle.tolist() if angle.any() else []


def collector(
    names,
    angles,
    units,
    blocks,
    n: int,
    sensors: "list[tuple[str, int, int, list[bool]]]",
    has_truth: bool,
    nonlinear: bool,
    inflated: bool,
):
    """Where runs with a state of n and these sensors (name, dimension, that of one observation, its angles) are added up."""
    states, angle, named = states_of(names, angles, n) if has_truth else ([], np.zeros(0, dtype=bool), [])
    if blocks is not None and not isinstance(blocks, Mapping):
        raise ValueError(f"blocks = {blocks!r}: expected a dict of names and their states")
    of_blocks = [(name, indices(which, states, f"blocks['{name}']")) for name, which in (blocks or {}).items()]
    for name, which in of_blocks:
        require_text(name, "the name of a block")
        if not which:
            raise ValueError(f"blocks['{name}'] has no states")
    return _credence.Collector(
        states,
        angle.tolist(),
        units_of(units, states, angle, named) if has_truth else [],
        of_blocks,
        sensors,
        has_truth,
        require_flag(nonlinear, "nonlinear"),
        require_flag(inflated, "inflated"),
    )


def require_layout(names, angles, units, blocks, n: int, nonlinear: bool, inflated: bool) -> None:
    """Raises what ``collector`` would of a state of n, before anything is played."""
    collector(names, angles, units, blocks, n, [], True, nonlinear, inflated)


def require_between(value: Any, argument: str, least: float, most: float) -> None:
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not number or not least <= value <= most:
        raise ValueError(f"{argument} = {value!r}: expected {least} to {most}")


def require_confidence(confidence: float) -> None:
    require_between(confidence, "confidence", 0.5, 0.999999)


def require_whole(value: Any, argument: str, least: int, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        raise ValueError(f"{argument} = {value!r}: expected a whole number from {least} to {most}")
    return int(value)


def require_threads(threads: int) -> None:
    if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or not 0 <= threads <= 4096:
        raise ValueError(f"threads = {threads!r}: expected 0 to 4096")


def require_progress(progress: Any) -> None:
    if progress is not None and not callable(progress):
        raise ValueError(f"progress = {progress!r}: expected a function of (done, total)")


def check(
    error: Any = None,
    P: Any = None,
    innovation: Any = None,
    S: Any = None,
    *,
    estimate: Any = None,
    names: Optional[Sequence[str]] = None,
    angles: Any = None,
    units: Any = None,
    innovation_angles: Any = None,
    blocks: Optional[Mapping[str, Any]] = None,
    observation: Any = None,
    R: Any = None,
    confidence: float = 0.95,
    within: float = 0.1,
    dt: float = 0.0,
    nonlinear: bool = False,
    inflated: bool = False,
    sensitivity: bool = False,
    threads: int = 0,
    name: str = "arrays",
) -> Result:
    """Judges the errors, covariances and innovations of a filter.

    Shapes are (runs, steps, n), or (steps, n) for one run, or a list with (steps, n) for each run, whose steps may
    differ. What is C-contiguous float64 is read where it lies; anything else is converted once.

    error: float64 (runs, steps, n), estimate minus truth. NaN, or masked: that state has no estimate or no truth there.
    P: float64 (runs, steps, n, n), its covariance; not read where the error is NaN. (steps, n, n): the same in
        every run; (n, n): always the same.
    innovation: float64 (runs, steps, m), or a dict with one such array for each sensor. NaN: silent.
    S: float64 (runs, steps, m, m), its covariance, as P; a dict with the same keys.
    estimate: float64 (runs, steps, n), where error is estimate − truth, of angles wrapped. With it measurements that
        arrive late are told from other causes: the errors then point back along the way. Not read where the error is NaN.
    names: one for each state; "pose.x", "pose.y" are a block "pose", "heading:angle" is an angle in rad, "v [m/s]" a
        state v in m/s. Without names each state is a block.
    angles: the states that are angles in rad, by name, number or booleans: their errors are wrapped.
    units: of the states, as "m" or "m/s", one for each or a dict of some: what tables and figures say beside errors. An
        angle is in rad, and "rad" and "rad/s" are shown in degrees.
    innovation_angles: the components of an innovation (of one observation) that are angles in rad, by number from 0 or
        booleans, True for all: one beyond half a turn was not wrapped, and is named as a cause. A dict: for each sensor.
    blocks: name → states that are judged together, by name, number or slice, instead of those that names make.
    observation: of how many components an observation is, where an innovation holds several of one kind (as of
        landmarks), one after another: each is then followed through time on its own. A dict: for each sensor.
    R: float64 (runs, steps, m, m), the covariance of the measurement that the filter assumes, as S; (m, m): always the
        same; also that of one observation, where observation says so. With it the factor on R alone is told. A dict:
        for each sensor that has one.
    confidence: of the verdict: a consistent filter is called anything else with probability 1 − confidence at most.
    within: the margin of what is told as proved: mean NEES and NIS between 1/(1 + this) and 1 + this times what is
        expected. The verdict does not depend on it.
    dt: the time of a step, s, with which what is said of steps tells when they are; 0: not known.
    nonlinear: the filter linearises at its own estimates, as an EKF does: a cause that is named where it fits.
    inflated: the filter inflates its covariance on purpose.
    sensitivity: judge without gross outliers too.
    threads: 0 for one on each processor; the bits do not depend on it.

    Raises ValueError naming argument, shape, and the first bad index, and for a run that is there twice, whole or cut
    off. A covariance that is not positive semidefinite is data: the row is counted as rejected, and named.
    """
    if (error is None) != (P is None):
        raise ValueError("error and P belong together: one of them is None")
    if (innovation is None) != (S is None):
        raise ValueError("innovation and S belong together: one of them is None")
    if error is None and (innovation is None or (isinstance(innovation, Mapping) and not innovation)):
        raise ValueError("nothing to judge: give error and P, or innovation and S, or all four")
    of_states = {"estimate": estimate, "names": names, "angles": angles, "units": units, "blocks": blocks}
    of_sensors = {"innovation_angles": innovation_angles, "observation": observation, "R": R}
    for lead, given, arguments in (("error", error, of_states), ("innovation", innovation, of_sensors)):
        alone = [argument for argument, value in arguments.items() if value is not None]
        if given is None and alone:
            raise ValueError(f"{alone[0]} belongs to {lead}, which is None")
    require_confidence(confidence)
    require_threads(threads)
    require_between(within, "within", 0.001, 10)
    require_between(dt, "dt", 0, 1e6)
    require_text(name, "name")
    sensitivity = require_flag(sensitivity, "sensitivity")

    nus = {} if innovation is None else _by_sensor(innovation)
    covariances = {} if S is None else _by_sensor(S)
    if isinstance(observation, Mapping) and not set(observation) <= set(nus):
        raise ValueError(f"observation has the sensors {sorted(observation)}, innovation has {sorted(nus)}")
    if isinstance(innovation_angles, Mapping) and not set(innovation_angles) <= set(nus):
        raise ValueError(f"innovation_angles has the sensors {sorted(innovation_angles)}, innovation has {sorted(nus)}")
    if R is not None and not set(_by_sensor(R)) <= set(nus):
        raise ValueError(f"R has the sensors {sorted(_by_sensor(R))}, innovation has {sorted(nus)}")
    if set(nus) != set(covariances):
        raise ValueError(f"innovation has the sensors {sorted(nus)}, S has {sorted(covariances)}")

    shape = lead = error_parts = P_parts = estimate_parts = None
    n = 0
    if error is not None:
        shape, error_parts, n = leading(error, "error")
        lead = "error"
        P_parts = following(P, "P", (n, n), shape, lead)
        if estimate is not None:
            estimate_parts = following(estimate, "estimate", (n,), shape, lead)
    sensor_parts, sensors = [], []
    for sensor, nu in nus.items():
        label = _label("innovation", sensor)
        own, nu_parts, m = leading(nu, label)
        if shape is None:
            shape, lead = own, label
        else:
            nu_parts = following(nu, label, (m,), shape, lead)
        S_parts = following(covariances[sensor], _label("S", sensor), (m, m), shape, label)
        piece = _observation(observation, sensor, m)
        noise = _noise(R, sensor, m, piece)
        R_parts = [None] * len(nu_parts) if noise is None else following(noise, _label("R", sensor), (m, m), shape, label)
        sensors.append((sensor, m, piece, innovation_angles_of(innovation_angles, sensor, piece)))
        sensor_parts.append(list(zip(nu_parts, S_parts, R_parts)))

    if error_parts:
        require_distinct(error_parts, "error")
    for (sensor, *_), parts in zip(sensors, sensor_parts):
        require_distinct([nu for nu, _, _ in parts], _label("innovation", sensor))
    bundles = [
        _credence.Bundle(
            error_parts[i] if error_parts else None,
            P_parts[i] if P_parts else None,
            [parts[i] for parts in sensor_parts],
            estimate_parts[i] if estimate_parts else None,
        )
        for i in range(len(error_parts or sensor_parts[0]))
    ]
    runs = collector(names, angles, units, blocks, n, sensors, error is not None, nonlinear, inflated)
    runs.look(bundles, shape.indexing, {}, False)  # which counts runs from those already added
    runs.add(bundles, shape.indexing, threads, {})
    return Result(runs.judge(name, "arrays", confidence, sensitivity, within, dt))
