"""The data of the figures of l20/jacobienne_arete: what j does in the frame of i when a pose moves a little."""

from __future__ import annotations

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.slam_graphe.residual import edge_figure

EDGE, COLUMNS = "edge", "colonnes"


def residual_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    return edge_figure(args, expected, got)


def columns_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    """Where j stands in the frame of i, and the derivatives of that place (2, 6), expected and obtained."""
    xi, xj = args[:2]
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[:2] - xi[:2]
    drawable = got is not None and all(np.all(np.isfinite(matrix)) for matrix in got)
    return {
        "kind": COLUMNS,
        "seen": [float(c * dx + s * dy), float(-s * dx + c * dy)],
        "expected": np.hstack(expected)[:2].tolist(),
        "got": np.hstack(got)[:2].tolist() if drawable else None,
    }
