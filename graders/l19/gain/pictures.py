"""The data of the figures of l19/gain: measurements as curves, and a belief from reading to reading."""

from __future__ import annotations

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l19.pairs import sane

FUSION, CHAIN = "fusion", "chaine"


def opinions_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    measured, variances = args
    curves = [
        ("les mesures" if k == 0 else "_", float(z), float(r), "measure")
        for k, (z, r) in enumerate(zip(measured, variances, strict=True))
    ]
    return {"kind": FUSION, "curves": curves, "expected": list(expected), "got": sane(got)}


def chain_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    m, v, measured, variances = args
    return {
        "kind": CHAIN,
        "start": (m, v),
        "measured": measured,
        "variances": variances,
        "expected": expected,
        "got": got,
    }
