"""The noise that a filter should believe in."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import _credence
from ._arrays import require_text, written_report
from ._check import Progress, require_progress, require_threads
from ._messages import names_arguments
from ._result import Verdict
from ._run import Scenario, _of_study, _read


@dataclass(frozen=True)
class Parameter:
    """One number of the noise. Where it is not identifiable value is NaN, and lower and upper are limits, or NaN."""

    name: str
    before: float
    value: float
    lower: float
    upper: float
    identifiable: bool
    steps_for_10_percent: float
    reason: str = ""

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.lower:.4g} … {self.upper:.4g})" if self.identifiable else self.reason


def _number(value: Optional[float]) -> float:
    return math.nan if value is None else value


class Told:
    """What every tuning tells."""

    def __init__(self, told: _credence.Told):
        self._told = told
        self._document = json.loads(told.json())

    @property
    def parameters(self) -> "dict[str, Parameter]":
        """What is known of each number, by its name."""
        found = {}
        for p in self._document["parameters"]:
            numbers = [_number(p[key]) for key in ("before", "value", "lower", "upper")]
            steps = _number(p["steps_for_10_percent"])
            reason = p.get("null_reason", "")
            found[p["name"]] = Parameter(p["name"], *numbers, p["identifiable"], steps, reason)
        return found

    @property
    def correlation(self) -> np.ndarray:
        """Of the estimates, in the order of ``to_dict()["coordinates"]``."""
        return np.array(self._document["correlation"], dtype=np.float64)

    @property
    def notes(self) -> "list[str]":
        """What is held, ridges, and what a cost on NIS could not tell apart."""
        return list(self._document["notes"])

    def to_dict(self) -> "dict[str, Any]":
        """The document of ``credence tune --format json`` (docs/formats.md)."""
        return json.loads(self._told.json())

    def __repr__(self) -> str:
        return self._told.text()


class Tuning(Told):
    """A tuned scenario. ``print(tuning)`` is what ``credence tune`` prints on a terminal."""

    @property
    def verdict(self) -> Optional[Verdict]:
        """On the tuned filter with fresh noise; None where nothing could be told."""
        return Verdict(self._told.verdict) if self._told.verdict else None

    @property
    def scenario(self) -> Optional[str]:
        """The tuned scenario, TOML text that ``run`` takes; None where nothing could be told."""
        return self._told.tuned or None

    def report(self, directory: "str | os.PathLike[str]") -> str:
        """Writes the report and returns the path of its page, DIR/index.html."""
        return written_report(self._told, directory)


@names_arguments
def tune(
    scenario: Scenario,
    *,
    free: str = "Q,R",
    runs: Optional[int] = None,
    steps: Optional[int] = None,
    seed: Optional[int] = None,
    threads: int = 0,
    progress: Optional[Progress] = None,
    **overrides: Any,
) -> Tuning:
    """The noise with which the innovations of a scenario's runs score highest, with the bits of ``credence tune``.

    scenario, overrides: as in ``run``.
    free: "Q", "R", "P0" for one factor each, "diag(Q)" for every variance, "full(Q)" for every element; separated by
        commas.
    progress: progress(done, total) is called every so often: of the search with how often the runs were played and
        total = 0, as nobody knows it, then with runs of fresh noise; an exception ends the work.

    Raises ValueError for a scenario, or something to tune, that is not accepted.
    """
    require_threads(threads)
    require_progress(progress)
    require_text(free, "free")
    return Tuning(_credence.tune(*_read(scenario, _of_study(overrides, runs, steps, seed)), free, threads, progress))
