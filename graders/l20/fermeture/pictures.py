"""The data of the figures of l20/fermeture: ellipses in the frame of i, of the expectation and of the measurement."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.fermeture.cases import LEVEL, right_relative, threshold
from reference.se2 import relative

RELATIVE, GATE = "relative", "porte"


def relative_figure(args: Arguments, expected: Floats, got: Floats | None) -> FigureData:
    xi, xj, _ = args
    shown = got is not None and bool(np.all(np.isfinite(got)))
    return {
        "kind": RELATIVE,
        "seen": relative(xi, xj)[:2].tolist(),
        "expected": expected[:2, :2].tolist(),
        "got": got[:2, :2].tolist() if shown and got is not None else None,
    }


def gate_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    """The gate in the plane, for the angle of the measurement as it is: the ellipsoid is cut at its residual."""
    xi, xj, z, sigma, omega = args[:5]
    S = right_relative(xi, xj, sigma) + np.linalg.inv(omega)
    limit = threshold(args[5] if len(args) > 5 else LEVEL)
    return {
        "kind": GATE,
        "seen": relative(xi, xj)[:2].tolist(),
        "measured": z[:2].tolist(),
        "gate": (limit * S[:2, :2]).tolist(),
        "distance": float(expected[0]),
        "limit": limit,
        "accepted": bool(expected[1]),
    }
