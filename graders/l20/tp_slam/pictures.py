"""The data of the figures of the small cases: a graph of four poses, and a map of one or two scans of four rays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Floats
from reference.occupancy import OccupancyGrid
from reference.pose_graph import PoseGraph, edge_chi2
from reference.world.scan import Scan

GRAPH, SMALL_MAP, MAP, MATCH = "graphe", "petite_carte", "carte", "recalage"
#: Poses beyond it, in metres, are drawn at its edge.
FAR = 1e4


def match_figure(a: Floats, b: Floats, wanted: Floats, got: Floats, start: Floats) -> FigureData:
    """Two clouds (n, 2) and the pose of b in the frame of a (3,): expected, obtained, and from where one began."""
    clouds = {"a": np.round(a, 3), "b": np.round(b, 3)}
    return {"kind": MATCH, **clouds, "wanted": wanted, "got": np.clip(got, -FAR, FAR), "start": start}


def graph_figure(graph: PoseGraph, start: Floats, expected: Floats, got: Floats) -> FigureData:
    """The poses (k, 3) given, expected and obtained, with the error √(eᵀΩe) that each edge keeps."""
    near = np.clip(got, -FAR, FAR)
    return {
        "kind": GRAPH,
        "ends": np.column_stack([graph.i, graph.j]).tolist(),
        "start": start.tolist(),
        "expected": expected.tolist(),
        "got": near.tolist(),
        "errors_expected": np.sqrt(edge_chi2(graph, expected)).tolist(),
        "errors_got": np.sqrt(edge_chi2(graph, near)).tolist(),
    }


def small_map_figure(
    poses: Floats, scans: Floats, corner: Floats, side: float, reach: float, got: Floats, cell: tuple[int, int]
) -> FigureData:
    """The map (H, W) that full-turn scans draw from their poses, the one obtained, and the first wrong `cell`."""
    grid = OccupancyGrid(np.zeros(got.shape), side, np.array([*corner, 0.0]))
    for pose, scan in zip(poses, scans, strict=True):
        grid.integrate(Scan.full_turn(scan, reach), pose)
    return {
        "kind": SMALL_MAP,
        "wanted": np.round(grid.log_odds, 2).tolist(),
        "got": np.round(np.clip(got, -6.0, 6.0), 2).tolist(),
        "rays": [_rays(pose, scan) for pose, scan in zip(poses, scans, strict=True)],
        "corner": list(corner),
        "side": side,
        "cell": list(cell),
    }


def _rays(pose: Floats, scan: Floats) -> Sequence[Sequence[float]]:
    """Where the lidar stands, then where each ray of a full turn ends."""
    x, y, theta = pose
    angles = theta + 2.0 * np.pi * np.arange(len(scan)) / len(scan)
    ends = np.array([x, y]) + scan[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    return [[float(x), float(y)], *np.round(ends, 3).tolist()]
