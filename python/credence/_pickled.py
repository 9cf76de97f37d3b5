"""What is left of a judgement in another process, as after ``multiprocessing`` or ``joblib``: all but its report."""

from __future__ import annotations

import copyreg
from dataclasses import dataclass
from typing import Any

from . import _credence


@dataclass(frozen=True)
class PickledTold:
    """In place of a _credence.Told, whose report draws from what the process that judged still holds."""

    verdict: str
    says: str
    p_value: float
    complete: bool
    is_sweep: bool
    tuned: str
    _text: str
    _json: str

    def text(self) -> str:
        return self._text

    def json(self) -> str:
        return self._json

    def write_report(self, folder: str) -> None:
        raise ValueError(f"report({folder!r}): a result that was pickled has no figures left; write its report where it was judged")


def _reduced(told: _credence.Told) -> "tuple[Any, ...]":
    fields = told.verdict, told.says, told.p_value, told.complete, told.is_sweep, told.tuned
    return PickledTold, (*fields, told.text(), told.json())


copyreg.pickle(_credence.Told, _reduced)
