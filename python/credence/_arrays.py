"""From what users have, to runs by steps by rows of float64 that lie one after the other. Copies only what is not
so already."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from ._credence import Indexing


@dataclass
class Shape:
    """How the leading axes of the arrays are laid out: the first array given decides for all."""

    indexing: Indexing
    runs: int  # of single: 1
    steps: "int | list[int]"  # one for each run if listed


def _entries(of: "Sequence[Any]") -> str:
    return "1 entry" if len(of) == 1 else f"{len(of)} entries"


def _require_held(array: np.ndarray, name: str) -> None:
    """Numbers that broadcasting repeats take no memory, so that there can be more of them than anyone can judge."""
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    needed = 8 * array.size
    if needed > memory and any(s == 0 and n > 1 for s, n in zip(array.strides, array.shape)):
        raise ValueError(
            f"{name} has shape {array.shape}: it repeats by broadcasting what would take {1e-9 * needed:.3g} GB, of "
            f"which there are {1e-9 * memory:.3g}; runs and steps that are data hold numbers of their own"
        )


def float_array(value: Any, name: str, held: bool = False) -> np.ndarray:
    """`value` as float64, what is masked as NaN; no copy if it is that. `held`: every number is to be one of its own,
    or at least to have room."""
    if isinstance(value, np.ma.MaskedArray) and value.dtype.kind in "fiu":
        return value.astype(np.float64).filled(np.nan)
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    if held:
        _require_held(array, name)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} is of dtype {array.dtype}: expected float64")
    return array.astype(np.float64, copy=False)


def _contiguous_rows(array: np.ndarray, dims: int) -> np.ndarray:
    stride = array.itemsize
    for axis in range(array.ndim - 1, array.ndim - 1 - dims, -1):
        if array.shape[axis] != 1 and array.strides[axis] != stride:
            return np.ascontiguousarray(array)
        stride *= array.shape[axis]
    return array


def is_list_of_runs(value: Any, dims: int) -> bool:
    """Whether `value` is a list with an array of (steps, …) for each run, where a row has `dims` axes."""
    try:
        return isinstance(value, (list, tuple)) and len(value) > 0 and all(np.ndim(v) == dims + 1 for v in value)
    except ValueError:  # lists of different lengths within, of which float_array says more
        return False


def _require_rows(array: np.ndarray, name: str) -> None:
    if array.shape[-1] == 0:
        raise ValueError(f"{name} has shape {array.shape}: its last axis is empty")
    if array.size == 0:
        raise ValueError(f"{name} has shape {array.shape}: it holds no steps")


def leading(value: Any, name: str) -> "tuple[Shape, list[np.ndarray], int]":
    """The array that decides: its shape, its parts as (runs, steps, n), and n."""
    if is_list_of_runs(value, 1):
        parts = [float_array(v, f"{name}[{i}]") for i, v in enumerate(value)]
        n = parts[0].shape[1]
        for i, part in enumerate(parts):
            if part.shape[1] != n:
                raise ValueError(f"{name}[{i}] has shape {part.shape}: {name}[0] has {n} columns")
            _require_rows(part, f"{name}[{i}]")
        shape = Shape(Indexing.listed, len(parts), [part.shape[0] for part in parts])
        return shape, [_contiguous_rows(part, 1)[np.newaxis] for part in parts], n
    array = float_array(value, name, held=True)
    if array.ndim not in (2, 3):
        raise ValueError(
            f"{name} has shape {array.shape}: expected (runs, steps, n), (steps, n) for one run, "
            "or a list of (steps, n)"
        )
    _require_rows(array, name)
    single = array.ndim == 2
    stacked = _contiguous_rows(array[np.newaxis] if single else array, 1)
    shape = Shape(Indexing.single if single else Indexing.stacked, stacked.shape[0], stacked.shape[1])
    return shape, [stacked], stacked.shape[2]


ENOUGH_BITS = 100.0  # that two runs agree is no chance


def coincidence_bits(run: np.ndarray) -> float:
    """-log2 of the chance that an independent run has the same (steps, n), as datasets/logs/run_fingerprints.h tells
    it: of the numbers that are neither zero nor what they were in the row before, by how often two are equal."""
    counts = np.isfinite(run) & (run != 0.0)
    counts[1:] &= run[1:] != run[:-1]
    numbers = run[counts]
    if numbers.size < 2:
        return 0.0
    times = np.unique(numbers, return_counts=True)[1].astype(float)
    equal_pairs = np.sum(times * (times - 1.0)) / 2.0
    return -numbers.size * float(np.log2((1.0 + equal_pairs) / (numbers.size * (numbers.size - 1.0) / 2.0)))


def _is_telling(run: np.ndarray) -> bool:
    first = 64  # rows, which are enough of most
    return coincidence_bits(run[:first]) >= ENOUGH_BITS or coincidence_bits(run) >= ENOUGH_BITS


def _without_end(run: np.ndarray) -> np.ndarray:
    """A run without the rows of NaN at its end."""
    rows = np.flatnonzero(~np.isnan(run).all(axis=1))
    return run[: rows[-1] + 1 if rows.size else 0]


def require_distinct(parts: "list[np.ndarray]", name: str) -> None:
    """Raises ValueError for a run that is there twice, whole or cut off: independent runs share no errors to the last
    bit. `parts` are those of the array that decides."""
    if sum(len(part) for part in parts) < 2:
        return
    runs = [_without_end(run) for part in parts for run in part]
    telling = [i for i, run in enumerate(runs) if _is_telling(run)]
    # The longest beginning of 1, 2, 4, ... rows of a copy is a beginning of the other as well.
    longest: "dict[tuple[int, int], list[int]]" = {}
    for i in telling:
        rows = 1 << (len(runs[i]).bit_length() - 1)
        longest.setdefault((rows, hash(runs[i][:rows].tobytes())), []).append(i)
    lengths = {rows for rows, _ in longest}
    found = None
    for i in telling:
        for rows in (rows for rows in lengths if rows <= len(runs[i])):
            for j in longest.get((rows, hash(runs[i][:rows].tobytes())), []):
                short = min(len(runs[i]), len(runs[j]))
                if j == i or (found is not None and (max(i, j), min(i, j)) >= found[:2]):
                    continue
                if np.array_equal(runs[i][:short], runs[j][:short], equal_nan=True):
                    found = (max(i, j), min(i, j), short)
    if found is not None:
        later, before, short = found
        whole = len(runs[later]) == len(runs[before])
        raise ValueError(
            f"{name}[{later}] has the same numbers as {name}[{before}]{'' if whole else f' in its first {short} steps'}, "
            "to the last bit: independent runs cannot, and it would be counted twice"
        )


def following(value: Any, name: str, row: "tuple[int, ...]", shape: Shape, like: str) -> "list[np.ndarray]":
    """The parts of another array, with rows of shape `row`. A covariance may also be given once for all runs,
    (steps, n, n), or once for all, (n, n)."""
    dims = len(row)
    covariance = dims == 2
    if shape.indexing is Indexing.listed and is_list_of_runs(value, dims):
        if len(value) != shape.runs:
            raise ValueError(f"{name} has {len(value)} runs: {like} has {shape.runs}")
        parts = []
        for i, (v, steps) in enumerate(zip(value, shape.steps)):
            part = float_array(v, f"{name}[{i}]")
            if part.shape != (steps, *row):
                raise ValueError(f"{name}[{i}] has shape {part.shape}: expected {(steps, *row)}, as {like}[{i}]")
            parts.append(_contiguous_rows(part, dims)[np.newaxis])
        return parts
    array = float_array(value, name)
    if covariance and array.shape == row:
        array = _contiguous_rows(array, dims)
        counts = shape.steps if isinstance(shape.steps, list) else [shape.steps]
        runs = 1 if shape.indexing is Indexing.listed else shape.runs
        return [np.broadcast_to(array, (runs, steps, *row)) for steps in counts]
    if shape.indexing is Indexing.listed:
        raise ValueError(f"{name} has shape {array.shape}: expected a list of {shape.runs} arrays, as {like}")
    stacked, once = (shape.runs, shape.steps, *row), (shape.steps, *row)
    if array.shape == stacked and shape.indexing is Indexing.stacked:
        return [_contiguous_rows(array, dims)]
    if array.shape == once and (covariance or shape.indexing is Indexing.single):
        return [np.broadcast_to(_contiguous_rows(array, dims), stacked)]
    expected = once if shape.indexing is Indexing.single else stacked
    shorter = [row] if shape.indexing is Indexing.single else [once, row]
    same = f" (or {' or '.join(map(str, shorter))} where all are the same)" if covariance else ""
    variances = covariance and array.shape == expected[:-1]
    hint = "; variances alone are a covariance as v[..., None] * numpy.eye(n)" if variances else ""
    raise ValueError(f"{name} has shape {array.shape}: expected {expected}{same}, as {like}{hint}")


def system_path(path: "str | bytes | os.PathLike") -> bytes:
    """The path in the bytes that the system has."""
    try:
        encoded = os.fsencode(path)
    except UnicodeEncodeError:
        raise ValueError(f"{path!r} is no path: it holds what is no character") from None
    if b"\0" in encoded:
        raise ValueError(f"{path!r} is no path: it holds a null character")
    return encoded


_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")  # as core/control_characters.h


def require_text(value: Any, argument: str) -> str:
    """A str that UTF-8 can hold, as the library's texts are."""
    if not isinstance(value, str):
        raise ValueError(f"{argument} = {value!r}: expected a str")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{argument} = {value!r}: expected characters of Unicode") from None
    if _CONTROL.search(value):
        raise ValueError(f"{argument} = {value!r}: holds a control character")
    return value


def folder_path(directory: Any) -> str:
    """What names a folder, as the library takes it."""
    if not isinstance(directory, (str, bytes, os.PathLike)):
        raise ValueError(f"{directory!r} is no path")
    return os.fsdecode(system_path(directory))


def written_report(told: Any, directory: Any) -> str:
    """Writes the report of what the library told; the path of its page."""
    folder = folder_path(directory)
    told.write_report(folder)
    return os.path.join(folder, "index.html")


def require_flag(value: Any, argument: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{argument} = {value!r}: expected True or False")
    return bool(value)


def indices(which: Any, names: "list[str]", argument: str, kind: str = "state", whole: str = "state") -> "list[int]":
    """States that are named, numbered, marked by booleans, or sliced, as ascending numbers; or what else the whole has."""
    if isinstance(which, slice):
        return list(range(len(names)))[which]
    if isinstance(which, (str, int, np.integer)):
        which = [which]
    if not np.iterable(which):
        raise ValueError(f"{argument} = {which!r}: expected names, numbers, booleans or a slice")
    which = list(which)
    if which and all(isinstance(w, (bool, np.bool_)) for w in which):
        if len(which) != len(names):
            raise ValueError(f"{argument} has {_entries(which)}: the {whole} has {len(names)}")
        return [i for i, w in enumerate(which) if w]
    found = set()
    for w in which:
        if isinstance(w, str):
            if w not in names:
                raise ValueError(f"{argument}: there is no {kind} '{w}' among {', '.join(names)}")
            i = names.index(w)
        elif isinstance(w, (int, np.integer)) and not isinstance(w, bool) and -len(names) <= w < len(names):
            i = int(w) % len(names)
        else:
            raise ValueError(f"{argument}: there is no {kind} {w!r}; the {whole} has {len(names)}")
        if i in found:
            raise ValueError(f"{argument} has {w!r} twice")
        found.add(i)
    return sorted(found)


_ANGLE = ":angle"
_UNIT = re.compile(r"(.*[^ \t])[ \t]*\[[ \t]*([^\[\]]*[^\[\] \t])[ \t]*\]", re.DOTALL)


def states_of(names: "Optional[Sequence[str]]", angles: Any, n: int) -> "tuple[list[str], np.ndarray, list[str]]":
    """The n names, which states are angles in rad, and the units that names tell: of "heading:angle" and "velocity [m/s]"
    the states are "heading" and "velocity", as in every other place where states have names. `angles` are angles too."""
    written = _state_names(names, n)
    told = [_UNIT.fullmatch(name) for name in written]
    marked = [unit[1] if unit else name for unit, name in zip(told, written)]
    states = [name.removesuffix(_ANGLE) for name in marked]
    if len(set(states)) != n or not all(states):
        raise ValueError("names must be different words, one for each state, ':angle' and '[unit]' not counted")
    angle = np.array([name.endswith(_ANGLE) for name in marked], dtype=bool)
    if angles is not None:
        angle[indices(angles, states, "angles")] = True
    return states, angle, [unit[2] if unit else "" for unit in told]


def units_of(units: Any, states: "list[str]", angle: np.ndarray, named: "list[str]") -> "list[str]":
    """The unit of each state: of a list one for each, of a dict those that it has, the others as their names tell; "" as
    not known. Nothing where no unit is told of any."""
    if units is None:
        units = named
    elif isinstance(units, Mapping):
        for state in units:
            if state not in states:
                raise ValueError(f"units: there is no state {state!r} among {', '.join(states)}")
        units = [units.get(state, unit) for state, unit in zip(states, named)]
    elif isinstance(units, str) or not np.iterable(units):
        raise ValueError(f"units = {units!r}: expected one for each state, or a dict of states and their units")
    told = [require_text(unit, "units") for unit in units]
    if len(told) != len(states):
        raise ValueError(f"units has {_entries(told)}: the state has {len(states)}")
    for state, unit, is_angle, of_name in zip(states, told, angle, named):
        if is_angle and unit not in ("", "rad"):
            raise ValueError(f"units: {state} is an angle, in {unit!r}; an angle is in rad")
        if of_name and unit != of_name:
            raise ValueError(f"units: {state} is in {unit!r}, and by its name in {of_name!r}")
    return told if any(told) else []


def _state_names(names: "Optional[Sequence[str]]", n: int) -> "list[str]":
    if names is None:
        return [f"x{i + 1}" for i in range(n)]
    if isinstance(names, str) or not np.iterable(names):
        raise ValueError(f"names = {names!r}: expected one for each state")
    names = list(names)
    if len(names) != n:
        raise ValueError(f"names has {_entries(names)}: the state has {n}")
    if len(set(names)) != n or not all(isinstance(name, str) and name for name in names):
        raise ValueError("names must be different words, one for each state")
    return [require_text(name, "names") for name in names]
