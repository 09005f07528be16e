"""The data of the figures of l20/tf_date: poses that are known, the one that is asked; the frames of a chain."""

from __future__ import annotations

import math

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.tf_date.truth import right_lookup

BETWEEN, CHAIN = "entre", "chaine"
#: Frames and poses farther than this from the others are not drawn.
BEYOND = 100.0


def between_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    a, b, _ = args
    return {"kind": BETWEEN, "known": np.array([a, b]), "expected": expected, "got": sane(got)}


def history_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData | None:
    if isinstance(expected, str):
        return None
    return {"kind": BETWEEN, "known": args[1], "expected": expected, "got": sane(got)}


def chain_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData | None:
    """The frames from the source up, seen from the target."""
    messages, target, source, date = args
    if isinstance(expected, str):
        return None
    parents = {child: parent for parent, child, _, _ in messages}
    names, frame = [], source
    while frame != target:
        names.append(frame)
        frame = parents[frame]
    frames = [(name, right_lookup(messages, target, name, date)) for name in reversed(names)]
    return {"kind": CHAIN, "target": target, "date": date, "frames": frames, "source": source, "got": sane(got)}


def sane(pose: Floats | None) -> list[float] | None:
    """A pose that can be drawn, else None."""
    if pose is None or np.shape(pose) != (3,):
        return None
    values = [float(value) for value in pose]
    return values if all(map(math.isfinite, values)) and max(map(abs, values)) < BEYOND else None
