"""The compiled half of the module. What users call is in the other files."""

import enum
from typing import Callable, Optional, Sequence, Union

import numpy as np

Progress = Optional[Callable[[float, float], object]]

version: str
commit: str

class OutputError(OSError): ...
class StoreError(OSError): ...
class ScenarioError(ValueError): ...
class DataError(ValueError): ...

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
    @property
    def is_sweep(self) -> bool: ...
    def text(self) -> str: ...
    def json(self) -> str: ...
    @property
    def tuned(self) -> str: ...
    def write_report(self, folder: str) -> None: ...

class CheckOptions:
    def __init__(
        self,
        name: str,
        format: str,
        truths: Sequence[str],
        topic: str,
        truth_topic: str,
        instance: Optional[int],
        max_time_difference: float,
        partial: bool,
        confidence: float,
        within: float,
        sensitivity: bool,
        threads: int,
    ) -> None: ...

def check_logs(
    logs: Sequence[bytes],
    options: CheckOptions,
    chart: str,
    align: str,
    truth_time: str,
    time_offset: Union[float, str, None],
    lever_arm: Sequence[float],
    progress: Progress,
) -> Told: ...

class Bundle:
    """Runs of one length: float64 (runs, steps, …) whose rows are contiguous; innovation, S and R of every sensor.

    estimate: where the error is its difference from the truth, angles wrapped.
    """

    def __init__(
        self,
        error: Optional[np.ndarray],
        P: Optional[np.ndarray],
        innovations: Sequence[tuple[np.ndarray, np.ndarray, Optional[np.ndarray]]],
        estimate: Optional[np.ndarray] = None,
    ) -> None: ...

class Collector:
    """Adds up runs and judges them."""

    def __init__(
        self,
        states: Sequence[str],
        angles: Sequence[bool],
        units: Sequence[str],
        blocks: Sequence[tuple[str, Sequence[int]]],
        sensors: Sequence[tuple[str, int, int, Sequence[bool]]],
        has_truth: bool,
        nonlinear: bool,
        inflated: bool,
    ) -> None: ...
    def add(
        self,
        bundles: Sequence[Bundle],
        indexing: Indexing,
        threads: int,
        failures: dict[int, tuple[int, str, str]],
    ) -> None: ...
    def look(
        self,
        bundles: Sequence[Bundle],
        indexing: Indexing,
        failures: "dict[int, tuple[int, str, str]]",
        played: bool,
    ) -> None: ...
    def judge(
        self, name: str, source: str, confidence: float, sensitivity: bool, within: float = 0.1, dt: float = 0.0
    ) -> Told: ...

class NoiseSource:
    """Standard normals as a function of (seed, group, run, step, purpose, slot)."""

    def __init__(self, seed: int, group: int) -> None: ...
    def shaped(
        self,
        process_correlation: float,
        measurement_correlation: float,
        student_dof: int,
        outlier_rate: float,
        outlier_scale: float,
    ) -> "NoiseSource": ...
    def normals(
        self, first_run: int, runs: int, step: int, purpose: Purpose, slots: int, first_slot: int
    ) -> np.ndarray: ...
    def normals_of_four_steps(
        self, first_run: int, runs: int, first_step: int, purpose: Purpose, slots: int
    ) -> np.ndarray: ...

def run(
    file: Union[str, bytes], text: Optional[str], overrides: Sequence[str], threads: int, progress: Progress
) -> Told: ...
def noise_group(file: Union[str, bytes], text: Optional[str], overrides: Sequence[str]) -> int: ...
def has_sweep(file: Union[str, bytes], text: Optional[str]) -> bool: ...
def load(directory: str, threads: int) -> Told: ...
def sweep(
    file: Union[str, bytes], text: Optional[str], overrides: Sequence[str], threads: int, progress: Progress
) -> Told: ...
def tune_filter(
    factors: Sequence[tuple[str, float]],
    runs: int,
    confidence: float,
    play: Callable[[Sequence[float]], tuple[np.ndarray, np.ndarray, np.ndarray, float, float, bool, bool]],
) -> Told: ...
def tune(
    file: Union[str, bytes], text: Optional[str], overrides: Sequence[str], free: str, threads: int, progress: Progress
) -> Told: ...
