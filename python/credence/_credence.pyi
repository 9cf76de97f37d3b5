"""The compiled half of the module. What users call is in the other files."""

import enum
from typing import Optional, Sequence

import numpy as np

class OutputError(OSError): ...
class ScenarioError(ValueError): ...

class Indexing(enum.Enum):
    single = ...
    stacked = ...
    listed = ...

class Purpose(enum.Enum):
    initial = ...
    process = ...
    measurement = ...

class Told:
    """What is told of a judged filter."""

    @property
    def verdict(self) -> str: ...
    @property
    def says(self) -> str: ...
    @property
    def p_value(self) -> float: ...
    @property
    def complete(self) -> bool: ...
    def text(self) -> str: ...
    def json(self) -> str: ...
    def write_report(self, folder: str) -> None: ...

class Bundle:
    """Runs of one length: float64 (runs, steps, …) whose rows are contiguous; innovation and S of every sensor."""

    def __init__(
        self,
        error: Optional[np.ndarray],
        P: Optional[np.ndarray],
        innovations: Sequence[tuple[np.ndarray, np.ndarray]],
    ) -> None: ...

class Collector:
    """Adds up runs and judges them."""

    def __init__(
        self,
        states: Sequence[str],
        angles: Sequence[bool],
        blocks: Sequence[tuple[str, Sequence[int]]],
        sensors: Sequence[tuple[str, int]],
        has_truth: bool,
    ) -> None: ...
    def add(
        self,
        bundles: Sequence[Bundle],
        indexing: Indexing,
        threads: int,
        failures: dict[int, tuple[int, str, str]],
    ) -> None: ...
    def judge(self, name: str, source: str, confidence: float, inflated: bool, sensitivity: bool) -> Told: ...

class NoiseSource:
    """Standard normals as a function of (seed, group, run, step, purpose, slot)."""

    def __init__(self, seed: int, group: int) -> None: ...
    def normals(
        self, first_run: int, runs: int, step: int, purpose: Purpose, slots: int, first_slot: int
    ) -> np.ndarray: ...
    def normals_of_four_steps(
        self, first_run: int, runs: int, first_step: int, purpose: Purpose, slots: int
    ) -> np.ndarray: ...

def run(file: str, text: Optional[str], overrides: Sequence[str], threads: int) -> Told: ...
