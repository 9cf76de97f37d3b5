"""Scenarios."""

from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Union

from . import _credence
from ._result import Result

Scenario = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_toml_value(str(k))} = {_toml_value(v)}" for k, v in value.items()) + "}"
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
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
        lines += [f"{key} = {_toml_value(value)}" for key, value in settings.items()]
    return "\n".join(lines)


def run(
    scenario: Scenario,
    *,
    runs: Optional[int] = None,
    steps: Optional[int] = None,
    seed: Optional[int] = None,
    threads: int = 0,
    **overrides: Any,
) -> Result:
    """Monte Carlo of one configuration, with the bits of ``credence run``.

    scenario: the path of a scenario file, its text in TOML (with a line break), or a dict of its sections
        (docs/scenario.md).
    overrides: any setting by its name: ``run(file, **{"filter.process_scale": 1.2})``.

    Raises ValueError for a scenario that is not accepted, naming the key.
    """
    for key, value in (("runs", runs), ("steps", steps), ("seed", seed)):
        if value is not None:
            overrides[f"study.{key}"] = value
    settings = [f"{key}={_toml_value(value)}" for key, value in overrides.items()]
    if isinstance(scenario, Mapping):
        file, text = "scenario", _toml(scenario)
    elif isinstance(scenario, str) and "\n" in scenario:
        file, text = "scenario", scenario
    else:
        file, text = os.fspath(scenario), None
    return Result(_credence.run(file, text, settings, threads))
