"""Films of l20/slam_graphe: a graph as it was given, and where the student's program led its poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.code.drawable import to_drawable_array
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Value
from graders.l20.slam_graphe.graphs import Graph

#: The iterations that are asked for one by one, of a graph that was not brought to its optimum: six in all, where
#: simplifying it takes hundreds. Nothing more is asked of a right program, whose verdict would wait for it.
STEPS = (1, 2, 3)
DECIMALS = 4


def film(graph: Graph, got: Value, first_steps: Sequence[Value], *, right: bool) -> FigureData:
    """`got` are the poses that came back in the end, `first_steps` those after each of `STEPS`."""
    return {
        "kind": "graphe",
        "right": right,
        "start": np.round(graph.poses, DECIMALS),
        "ends": [[i, j] for i, j, _, _ in graph.edges],
        "z": np.round([z for _, _, z, _ in graph.edges], DECIMALS),
        "weights": [[omega[0, 0], omega[2, 2]] for _, _, _, omega in graph.edges],
        "n_iter": graph.n_iter,
        "steps": [_poses(graph, poses) for poses in first_steps],
        "end": _poses(graph, got),
    }


def _poses(graph: Graph, got: Value) -> Value:
    poses = to_drawable_array(got, graph.poses.shape)
    return None if poses is None else np.round(poses, DECIMALS)
