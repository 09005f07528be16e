"""The data of the figures of l19/coherence: an error beside its ellipse, a band, the NEES of every run."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l19.coherence.truth import LEVEL, right_band, right_nees
from graders.l19.pairs import sane

ERROR, BAND, RUNS = "erreur", "bande", "essais"
#: How many runs are drawn.
MOST = 60


def error_figure(args: Arguments, expected: Value, got: Value) -> FigureData | None:
    true, estimated, P = args
    if len(true) != 2:
        return None
    return {"kind": ERROR, "true": true, "estimated": estimated, "P": P, "expected": expected, "got": got}


def band_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    n, N = args[:2]
    level = args[2] if len(args) > 2 else LEVEL
    return {"kind": BAND, "n": n, "N": N, "level": level, "expected": list(expected), "got": sane(got)}


def runs_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    true, _, covariances = args
    values = [right_nees(*run) for run in zip(*(one[:MOST] for one in args), strict=True)]
    return {
        "kind": RUNS,
        "values": values,
        "band": list(right_band(true.shape[1], len(covariances))),
        "mean": expected[0],
        "got": None if got is None or not np.isfinite(got[0]) else float(got[0]),
    }
