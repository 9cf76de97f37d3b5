"""What a judgement says."""

from __future__ import annotations

import enum
import functools
import html
import json
import math
import os
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import _credence
from ._arrays import written_report
from ._messages import in_arguments


class Verdict(str, enum.Enum):
    """What the data say about a covariance. Compares and prints as its word."""

    consistent = "consistent"  # no evidence against it
    optimistic = "optimistic"  # errors are larger than it says: do not trust it
    pessimistic = "pessimistic"  # errors are smaller than it says
    mixed = "mixed"  # larger here, smaller there: do not trust it
    not_gaussian = "not Gaussian"  # it is right, the errors have heavier tails than a Gaussian law
    undecided = "undecided"  # there is not enough data

    __str__ = str.__str__
    __format__ = str.__format__


@dataclass(frozen=True)
class Factor:
    """A factor on a covariance that would make the mean right, with its interval; NaN, and a reason, where not
    known."""

    value: float
    lower: float
    upper: float
    reason: str = ""

    def __str__(self) -> str:
        return self.reason or f"{self.value:.3g} ({self.lower:.3g} … {self.upper:.3g})"


@dataclass(frozen=True)
class Test:
    """One test of the suite: its p-value alone, and what remains of it among all (Holm)."""

    name: str
    p_value: float
    adjusted: float
    exactness: str
    says: str


@dataclass(frozen=True)
class Block:
    """The NEES of one block of the state."""

    name: str
    verdict: Verdict
    p_value: float
    mean: float
    expected: float


@dataclass(frozen=True)
class Sensor:
    """The NIS of one sensor, and whether its innovations are white and of mean zero."""

    name: str
    verdict: Verdict
    p_value: float
    mean: float
    expected: float
    whiteness_p_value: float
    mean_p_value: float


@dataclass(frozen=True)
class Cause:
    """What most likely is wrong, and what speaks for it."""

    name: str
    why: str


def _number(value: Optional[float]) -> float:
    return math.nan if value is None else value


def _numbers(values: Optional[list]) -> np.ndarray:
    return np.array(values or [], dtype=np.float64)  # None becomes NaN


class Result:
    """A judged filter. ``print(result)`` is what ``credence`` prints on a terminal."""

    def __init__(self, told: _credence.Told):
        self._told = told

    @property
    def verdict(self) -> Verdict:
        """The one word over NEES, NIS and every block of the state."""
        return Verdict(self._told.verdict)

    @property
    def says(self) -> str:
        """What is wrong, where and when."""
        return self._told.says

    @property
    def p_value(self) -> float:
        """Of everything together: the verdict is optimistic, pessimistic or mixed only where it is at most 1 − confidence; of
        an undecided one ``says`` tells why."""
        return self._told.p_value

    @property
    def complete(self) -> bool:
        """False after an interruption."""
        return self._told.complete

    @functools.cached_property
    def _document(self) -> dict[str, Any]:
        return json.loads(self._told.json())

    def to_dict(self) -> dict[str, Any]:
        """The document that ``--format json`` prints (docs/formats.md)."""
        return json.loads(self._told.json())

    @property
    def _battery(self) -> dict[str, Any]:
        return self._document.get("battery", {})

    @property
    def tests(self) -> list[Test]:
        return [
            Test(t["name"], _number(t["p_value"]), _number(t["adjusted_p_value"]), t["law"], t["measured"])
            for t in self._battery.get("tests", [])
        ]

    @property
    def blocks(self) -> list[Block]:
        return [
            Block(b["name"], Verdict(b["verdict"]), _number(b["p_value"]), _number(b["mean"]), _number(b["expected"]))
            for b in self._battery.get("blocks", [])
        ]

    @property
    def sensors(self) -> list[Sensor]:
        """One for each innovation that was given; none of a scenario."""
        return [
            Sensor(
                s["name"],
                Verdict(s["nis"]["verdict"]),
                _number(s["nis"]["p_value"]),
                _number(s["nis"]["mean"]),
                _number(s["nis"]["expected"]),
                _number(s["whiteness"]["p_value"]),
                _number(s["innovation_mean"]["p_value"]),
            )
            for s in self._document.get("sensors", [])
        ]

    @property
    def causes(self) -> list[Cause]:
        """The most specific first; a hint, not a proof."""
        return [Cause(c["cause"], c["why"]) for c in self._battery.get("causes", [])]

    @property
    def factor(self) -> Factor:
        """On P: the true covariance over the claimed one, on average over steps."""
        scale = self._battery.get("scale", {}).get("covariance", {"reason": "interrupted"})
        return Factor(
            _number(scale.get("factor")),
            _number(scale.get("lower")),
            _number(scale.get("upper")),
            scale.get("reason", ""),
        )

    @property
    def mean_nees(self) -> np.ndarray:
        """(steps,) float64: mean over the runs; NaN without data."""
        return _numbers(self._document["nees"]["per_step"])

    @property
    def mean_nis(self) -> np.ndarray:
        """(steps,) float64: mean over the runs; NaN without data."""
        return _numbers(self._document["nis"]["per_step"])

    @property
    def nees_bounds(self) -> np.ndarray:
        """(steps, 2) float64: what a consistent filter's mean_nees keeps at single steps."""
        bounds = self._document["nees"]["per_step_bounds"]
        return np.stack([_numbers(bounds["lower"]), _numbers(bounds["upper"])], axis=-1)

    @property
    def nis_bounds(self) -> np.ndarray:
        """(steps, 2) float64: what a consistent filter's mean_nis keeps at single steps."""
        bounds = self._document["nis"]["per_step_bounds"]
        return np.stack([_numbers(bounds["lower"]), _numbers(bounds["upper"])], axis=-1)

    @property
    def rmse(self) -> dict[str, np.ndarray]:
        """Root mean squared errors by step, (steps,) float64 each: position_m, heading_rad, landmark_m."""
        return {key: _numbers(values) for key, values in self._document.get("rmse", {}).items()}

    @property
    def trace(self) -> np.ndarray:
        """(steps,) float64: the mean trace of P after the update."""
        return _numbers(self._document["covariance"]["trace"])

    @property
    def failures(self) -> list[dict[str, Any]]:
        """Runs that did not end well: run, step, outcome, and what the filter said."""
        return self._document["outcomes"]["failures"]

    def report(self, directory: "str | os.PathLike[str]") -> str:
        """Writes the report and returns the path of its page, DIR/index.html."""
        return written_report(self._told, directory)

    @property
    def remarks(self) -> list[str]:
        """What was left out of the logs, taken for something, or cannot be known."""
        return [in_arguments(sentence) for sentence in self._document.get("remarks", [])]

    def __repr__(self) -> str:
        return in_arguments(self._told.text())

    def _repr_html_(self) -> str:
        rows = [("NEES", self._document["nees"]), ("NIS", self._document["nis"])]
        rows = [(name, v) for name, v in rows if v["values"] > 0]
        rows += [(f"NEES of {b.name}", vars(b)) for b in self.blocks]
        cells = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{_number(v['mean']):.4g}</td><td>{_number(v['expected']):.4g}</td>"
            f"<td>{_number(v['p_value']):.3g}</td><td>{html.escape(str(v['verdict']))}</td></tr>"
            for name, v in rows
        )
        causes = "".join(f"<li>{html.escape(c.name)}: {html.escape(c.why)}</li>" for c in self.causes)
        return (
            f"<p><b>{html.escape(str(self.verdict))}</b>: {html.escape(self.says)}</p><table>"
            f"<tr><th></th><th>mean</th><th>expected</th><th>p</th><th>verdict</th></tr>{cells}</table>"
            + (f"<ul>{causes}</ul>" if causes else "")
        )
