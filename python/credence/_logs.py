"""Verdicts on log files."""

from __future__ import annotations

import os
from typing import Optional, Sequence, Union

import numpy as np

from . import _credence
from ._arrays import require_flag, require_text, system_path
from ._check import Progress, require_between, require_confidence, require_progress, require_threads, require_whole
from ._messages import names_arguments
from ._result import Result

Path = Union[str, "os.PathLike[str]"]


def _paths(given: "Path | Sequence[Path]", argument: str) -> list[bytes]:
    """As the system has them: a name need not be UTF-8."""
    one = isinstance(given, (str, bytes, os.PathLike))
    if not one and (isinstance(given, np.ndarray) or not np.iterable(given)):
        raise ValueError(f"{argument} = {given!r}: expected files, or folders of them")
    paths = [given] if one else list(given)
    for path in paths:
        if not isinstance(path, (str, bytes, os.PathLike)):
            raise ValueError(f"{argument} holds {path!r}: expected files, or folders of them")
    return [system_path(path) for path in paths]


@names_arguments
def check_logs(
    logs: "Path | Sequence[Path]",
    *,
    truth: "Path | Sequence[Path]" = (),
    format: str = "auto",
    topic: str = "",
    truth_topic: str = "",
    instance: Optional[int] = None,
    chart: str = "",
    align: str = "none",
    truth_time: str = "interpolated",
    max_time_difference: float = 0.02,
    time_offset: Union[float, str, None] = None,
    lever_arm: Sequence[float] = (),
    partial: bool = False,
    confidence: float = 0.95,
    within: float = 0.1,
    sensitivity: bool = False,
    threads: int = 0,
    name: str = "",
    progress: Optional[Progress] = None,
) -> Result:
    """Judges the logs of one filter, as ``credence check --pool`` does: bags, flight logs, arrays, trajectories, CSV.

    logs: files, or folders of them; the format of each is seen from how it begins (docs/logs.md).
    truth: of logs that do not hold it: one file for all of them, or one for each.
    topic, truth_topic: of bags, where several topics could be it.
    instance: of several estimators in one flight log, the one to judge.
    chart: how a library writes the covariance of a pose; "" is what the format means by itself.
    align: moves the truth onto the estimate first: "none", "se2", "yaw" or "se3".
    truth_time: which truth belongs to an estimate: "interpolated" or "nearest".
    max_time_difference: how far the truth used may be from an estimate, s.
    time_offset: what the times of the truth are ahead, s, or "estimate" (one of all logs) or "each" (one of each); of
        logs of poses.
    lever_arm: of logs of poses, where the frame of the truth is on the body of the estimate: (x, y, z) in m, or with
        (qx, qy, qz, qw) behind it.
    partial: of a file that is cut off, judge what comes before.
    within, confidence, sensitivity, threads, name: as in ``check``.
    progress: progress(done, total) is called every so often, with bytes; an exception ends the work.

    Raises DataError, a ValueError, for a file that cannot be read, naming its line, and for a run that is there twice;
    ValueError for options that do not fit the files.
    """
    require_confidence(confidence)
    require_threads(threads)
    words = {"name": name, "format": format, "topic": topic, "truth_topic": truth_topic, "chart": chart, "align": align}
    for argument, word in words.items():
        require_text(word, argument)
    partial, sensitivity = require_flag(partial, "partial"), require_flag(sensitivity, "sensitivity")
    require_progress(progress)
    require_between(within, "within", 0.001, 10)
    require_between(max_time_difference, "max_time_difference", 1e-9, 1e9)
    if isinstance(time_offset, str) and time_offset not in ("estimate", "each"):
        raise ValueError(f"time_offset = {time_offset!r}: expected seconds, 'estimate' or 'each'")
    if not isinstance(time_offset, str) and time_offset is not None:
        require_between(time_offset, "time_offset", -1e9, 1e9)
    if instance is not None:
        require_whole(instance, "instance", 0, 2**31 - 1)
    if isinstance(lever_arm, str) or not np.iterable(lever_arm):
        raise ValueError(f"lever_arm = {lever_arm!r}: expected (x, y, z), or with (qx, qy, qz, qw)")
    for number in lever_arm:
        require_between(number, "lever_arm", -1e9, 1e9)
    if truth_time not in ("interpolated", "nearest"):
        raise ValueError(f"truth_time = {truth_time!r}: expected 'interpolated' or 'nearest'")
    files = _paths(logs, "logs")
    if not files:
        raise ValueError("logs is empty: expected files, or folders of them")
    options = _credence.CheckOptions(
        name,
        format,
        _paths(truth, "truth"),
        topic,
        truth_topic,
        instance,
        max_time_difference,
        partial,
        confidence,
        within,
        sensitivity,
        threads,
    )
    return Result(
        _credence.check_logs(
            files, options, chart, align, truth_time, time_offset, [float(x) for x in lever_arm], progress
        )
    )
