"""Answers of a program to the probes of a declared exercise, as texts by which known mistakes are told."""

from __future__ import annotations

import numpy as np

from graders.core.compare.python_values import python_text
from graders.core.contract.values import Value
from graders.core.declared.playing import Played

#: Digits by which two programs are told apart.
PROBE_DIGITS = 9


def probe_answer(played: Played) -> str:
    """Return what a program did with a probe: its values, what it printed and wrote, or its fault."""
    if played.fault is not None:
        return f"{played.fault.outcome.value} {played.fault.exception or ''}"
    written = [dict(played.written)] if played.written else []
    return python_text(_typeless([*played.values, played.printed, *written]), PROBE_DIGITS)


def _typeless(value: Value) -> Value:
    """Return a value in which 1.0 is 1, and a tuple or an array is a list: what comparators take for the same."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_typeless(item) for item in value]
    if isinstance(value, dict):
        return {key: _typeless(value[key]) for key in sorted(value, key=repr)}
    return int(value) if isinstance(value, float) and value.is_integer() else value
