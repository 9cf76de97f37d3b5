"""Can this covariance be trusted?

``check`` judges arrays of errors and covariances, ``check_logs`` log files, ``run`` a scenario, ``load`` what one has stored, ``study`` a world and a filter written in
Python. Each returns a ``Result``: its verdict, the tests and the causes behind it, and its report. ``tune`` returns the
noise that the innovations of a scenario ask for, ``tune_filter`` that of a filter written in Python.
"""

from . import _credence, _pickled  # noqa: F401
from ._check import check
from ._credence import DataError, OutputError, ScenarioError, StoreError
from ._logs import check_logs
from ._play import Noise, PlugError
from ._result import Block, Cause, Factor, Result, Sensor, Test, Verdict
from ._run import Sweep, load, noise_group, run, sweep
from ._study import study
from ._tune import Parameter, Tuning, tune
from ._tune_filter import FilterTuning, tune_filter

__version__ = _credence.version
__commit__ = _credence.commit  # of the source that was built; "+" behind it: with changes; "": not known

__all__ = [
    "Block",
    "Cause",
    "DataError",
    "Factor",
    "FilterTuning",
    "Noise",
    "OutputError",
    "Parameter",
    "PlugError",
    "Result",
    "ScenarioError",
    "Sensor",
    "StoreError",
    "Sweep",
    "Test",
    "Tuning",
    "Verdict",
    "check",
    "check_logs",
    "load",
    "noise_group",
    "run",
    "study",
    "sweep",
    "tune",
    "tune_filter",
]
