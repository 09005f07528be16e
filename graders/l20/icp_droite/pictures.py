"""The data of the figures of l20/icp_droite: a wall and its normals, paired points and their gaps."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value

NORMALS, PAIRS = "normales", "paires"


def normals_figure(args: Arguments, expected: Floats, got: Floats | None) -> FigureData:
    shown = got is not None and bool(np.all(np.isfinite(got)))
    return {
        "kind": NORMALS,
        "points": args[0].tolist(),
        "expected": expected.tolist(),
        "got": got.tolist() if shown and got is not None else None,
    }


def pairs_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    P, Q, N = args
    return {"kind": PAIRS, "P": P.tolist(), "Q": Q.tolist(), "N": N.tolist(), "centre": P.mean(axis=0).tolist()}
