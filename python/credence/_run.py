"""Scenarios."""

from __future__ import annotations

import html
import json
import math
import os
import warnings
from typing import Any, Mapping, Optional, Union

import numpy as np

from . import _credence
from ._arrays import folder_path, require_text, system_path, written_report
from ._check import Progress, require_progress, require_threads
from ._messages import names_arguments
from ._result import Result, Verdict

Scenario = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def _toml_value(value: Any) -> str:
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_toml_value(str(k))} = {_toml_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml_value(v) for v in value) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise ValueError(f"a scenario holds no {type(value).__name__}: {value!r}")


def _toml(document: Mapping[str, Any]) -> str:
    lines = []
    for section, settings in document.items():
        if not isinstance(settings, Mapping):
            raise ValueError(f"scenario: '{section}' is no section; expected {{'world': {{...}}, 'filter': {{...}}}}")
        lines.append(f"[{section}]")
        lines += [f"{_toml_value(str(key))} = {_toml_value(value)}" for key, value in settings.items()]
    return "\n".join(lines)


def _read(scenario: Scenario, overrides: Mapping[str, Any]) -> "tuple[str | bytes, Optional[str], list[str]]":
    """File, text if there is one, and the settings over it."""
    for key in overrides:
        require_text(key, "a setting")
    settings = [f"{key}={_toml_value(value)}" for key, value in overrides.items()]
    if isinstance(scenario, Mapping):
        return "scenario", _toml(scenario), settings
    if isinstance(scenario, str) and "\n" in scenario:
        return "scenario", scenario, settings
    return system_path(scenario), None, settings


def _of_study(
    overrides: Mapping[str, Any], runs: Optional[int], steps: Optional[int], seed: Optional[int]
) -> "dict[str, Any]":
    """Settings, with those of [study] that have arguments of their own."""
    own = {"runs": runs, "steps": steps, "seed": seed}
    for key, value in own.items():
        if value is not None and f"study.{key}" in overrides:
            raise ValueError(f"{key} = {value!r} and study.{key} = {overrides[f'study.{key}']!r}: expected one of them")
    return {**overrides, **{f"study.{key}": value for key, value in own.items() if value is not None}}


@names_arguments
def run(
    scenario: Scenario,
    *,
    runs: Optional[int] = None,
    steps: Optional[int] = None,
    seed: Optional[int] = None,
    threads: int = 0,
    progress: Optional[Progress] = None,
    **overrides: Any,
) -> Result:
    """Monte Carlo of one configuration, with the bits of ``credence run``.

    scenario: the path of a scenario file, the name of one that comes with the module (``credence list``), its text in
        TOML (with a line break), or a dict of its sections (docs/scenario.md).
    progress: progress(done, total) is called every so often, with runs; an exception ends the work.
    overrides: any setting by its name: ``run(file, **{"filter.process_scale": 1.2})``.

    Raises ValueError for a scenario that is not accepted, naming the key.
    """
    require_threads(threads)
    require_progress(progress)
    file, text, settings = _read(scenario, _of_study(overrides, runs, steps, seed))
    if _credence.has_sweep(file, text):
        warnings.warn(
            f"{os.fsdecode(file)} has a [sweep], which run leaves aside; credence.sweep runs all of its configurations",
            stacklevel=3,
        )
    return Result(_credence.run(file, text, settings, threads, progress))


class Sweep:
    """The studies of all configurations of a sweep. ``print(sweep)`` is what ``credence sweep`` prints."""

    def __init__(self, told: _credence.Told):
        self._told = told

    def to_dict(self) -> "dict[str, Any]":
        """The document of ``credence sweep --format json`` (docs/formats.md)."""
        return json.loads(self._told.json())

    @property
    def array(self) -> np.ndarray:
        """A structured array with a row for each configuration, which pandas takes as it is: the swept keys, verdict,
        p_value, sweep_p_value (adjusted over all of them), factor on P with its interval, mean_nees, expected_nees,
        mean_nis, expected_nis, runs, failed."""
        document = self.to_dict()
        if "configurations" not in document:
            raise ValueError("a map of ranks has no verdicts: see to_dict()['rank_map']")
        rows = []
        for c in document["configurations"]:
            nees, nis = c["nees"], c["nis"]
            factor = nees["factor"]
            word = c.get("stop") or c["word"]
            numbers = [word["p_value"], c["sweep_p_value"], factor["value"], factor["lower"], factor["upper"]]
            numbers += [nees["mean"], nees["expected"], nis["mean"], nis["expected"]]
            rows.append(
                (*(c["swept"] or {}).values(), c["verdict"], *(math.nan if x is None else x for x in numbers))
                + (c["runs"], len(c["outcomes"]["failures"]))
            )
        if not rows:
            raise ValueError("interrupted before the first runs were done")
        swept = list(document["configurations"][0]["swept"] or {})
        names = ["p_value", "sweep_p_value", "factor", "factor_lower", "factor_upper"]
        names += ["mean_nees", "expected_nees", "mean_nis", "expected_nis"]
        kinds = [(key, _column_type([row[i] for row in rows])) for i, key in enumerate(swept)]
        kinds.append(("verdict", f"U{max(len(v) for v in Verdict)}"))
        kinds += [*((name, "f8") for name in names), ("runs", "i8"), ("failed", "i8")]
        return np.array(rows, dtype=kinds)

    def report(self, directory: "str | os.PathLike[str]") -> str:
        """Writes the report and returns the path of its page, DIR/index.html."""
        return written_report(self._told, directory)

    def __repr__(self) -> str:
        return self._told.text()

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self._told.text())}</pre>"


def _column_type(values: list) -> str:
    if all(isinstance(v, bool) for v in values):
        return "?"
    if all(isinstance(v, int) for v in values):
        return "i8"
    if all(isinstance(v, (int, float)) for v in values):
        return "f8"
    return f"U{max(len(str(v)) for v in values)}"


@names_arguments
def sweep(
    scenario: Scenario,
    *,
    runs: Optional[int] = None,
    steps: Optional[int] = None,
    seed: Optional[int] = None,
    threads: int = 0,
    progress: Optional[Progress] = None,
    **overrides: Any,
) -> Sweep:
    """Monte Carlo of all configurations of a [sweep] table, with the bits of ``credence sweep``.

    Arguments are those of ``run``; a dict may have a section "sweep": {"filter.process_scale": [0.5, 1.0]}.
    """
    require_threads(threads)
    require_progress(progress)
    return Sweep(_credence.sweep(*_read(scenario, _of_study(overrides, runs, steps, seed)), threads, progress))


@names_arguments
def load(directory: "str | os.PathLike[str]", *, threads: int = 0) -> "Result | Sweep":
    """What ``credence run --out DIR`` or ``credence sweep --out DIR`` has stored, also while it still runs: a Result, or
    of a sweep a Sweep, whose ``array`` is a structured array.

    Verdicts are those of ``credence show DIR``. Raises StoreError, an OSError, where no results are stored.
    """
    require_threads(threads)
    told = _credence.load(folder_path(directory), threads)
    return Sweep(told) if told.is_sweep else Result(told)


@names_arguments
def noise_group(scenario: Scenario, **overrides: Any) -> int:
    """What names the noise of a scenario's world: a ``study`` in this group, with its seed, meets the same noise."""
    return _credence.noise_group(*_read(scenario, overrides))
