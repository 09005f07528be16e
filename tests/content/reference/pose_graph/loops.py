"""A small noisy graph for the tests, with or without landmarks."""

from __future__ import annotations

import numpy as np

from reference.pose_graph import G2oGraph, PoseGraph, Sightings, to_g2o
from reference.se2 import compose, relative, wrap_angle

EYE = np.eye(3)


def loop(seed: int, n: int = 8, noise: float = 0.08, n_landmarks: int = 0, **settings) -> G2oGraph:
    """A ring with two chords, with noise and unlike full information; started from odometry, landmarks from the truth.

    Every pose sees every landmark.
    """
    rng = np.random.default_rng(seed)
    turn = 2 * np.pi * np.arange(n) / n
    truth = np.column_stack([3 * np.cos(turn), 3 * np.sin(turn), wrap_angle(turn + np.pi / 2)])
    ends = [*((k, k + 1) for k in range(n - 1)), (n - 1, 0), (0, n // 2), (n // 2 + 1, 1)]
    edges = []
    for i, j in ends:
        root = rng.normal(size=(3, 3)) + 3 * EYE
        edges.append((i, j, relative(truth[i], truth[j]) + rng.normal(0, noise, 3), root @ root.T))
    start = [truth[0]]
    for k in range(n - 1):
        start.append(compose(start[-1], edges[k][2]))
    points = rng.normal(0, 3, (n_landmarks, 2))
    seen = []
    for i in range(n if n_landmarks else 0):
        for k, point in enumerate(points):
            root = rng.normal(size=(2, 2)) + 3 * np.eye(2)
            seen.append((i, k, relative(truth[i], [*point, 0])[:2] + rng.normal(0, noise, 2), root @ root.T))
    graph = PoseGraph.from_edges(n, edges, sightings=Sightings.from_edges(n_landmarks, seen), **settings)
    return to_g2o(graph, np.array(start), points)


def odometry(graph: PoseGraph, first: np.ndarray) -> np.ndarray:
    """Poses (n, 3) by the edges from each pose to the next alone."""
    step = {int(i): z for i, j, z in zip(graph.i, graph.j, graph.z_i_j, strict=True) if j == i + 1}
    poses = [first]
    for k in range(graph.n_poses - 1):
        poses.append(compose(poses[-1], step[k]))
    return np.array(poses)
