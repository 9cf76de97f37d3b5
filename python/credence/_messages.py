"""The library's messages in the words of this module: its arguments instead of the options of the command line."""

from __future__ import annotations

import functools
import re
from typing import Any, Callable, TypeVar

_ARGUMENTS = {
    "align": "align",
    "chart": "chart",
    "input": "format",
    "instance": "instance",
    "lever-arm": "lever_arm",
    "sensitivity": "sensitivity",
    "max-time-difference": "max_time_difference",
    "time-offset": "time_offset",
    "topic": "topic",
    "truth": "truth",
    "truth-time": "truth_time",
    "truth-topic": "truth_topic",
}
# The first: "--chart or --orientation-error", of which there is one argument. A value may follow: "--instance 2", or N.
_OPTION = re.compile(
    r"(?<![\w-])--(?:(chart) or --orientation-error|(" + "|".join(_ARGUMENTS) + r")(?![\w-])( (?=[\d/+-]|N\b))?)"
)

_Function = TypeVar("_Function", bound=Callable[..., Any])


def in_arguments(message: str) -> str:
    """`message` with "--truth-topic" as "truth_topic", and "--set key=value" as "key=value"."""

    def argument(option: "re.Match[str]") -> str:
        return _ARGUMENTS[option[1] or option[2]] + ("=" if option[3] else "")

    return re.sub(r"(?<![\w-])--set (?=[\w\"])", "", _OPTION.sub(argument, message))


def names_arguments(function: _Function) -> _Function:
    """What `function` raises names arguments."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except (ValueError, OSError) as error:
            message = in_arguments(str(error))
            if message == str(error) or len(error.args) != 1:
                raise
            raise type(error)(message) from None

    return call  # type: ignore[return-value]
