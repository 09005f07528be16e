"""The data of the figures of l19/predire_corriger: a belief before and after, and the reading between the two."""

from __future__ import annotations

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l19.pairs import sane

MOVED, MEASURED = "predire", "corriger"


def belief_figure(kind: str, args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    m, v, value, variance = args
    curves = [("avant", m, v, "belief")]
    if kind == MEASURED:
        curves.append(("la mesure z", value, variance, "measure"))
    return {"kind": kind, "curves": curves, "expected": list(expected), "got": sane(got)}
