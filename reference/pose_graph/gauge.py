"""The gauge of a pose graph: moving everything together changes no relative measurement.

Three directions leave every residual unchanged, at any state: two translations and one rotation about the origin of the
world. So J v = 0, hence H v = J' omega J v = 0: the matrix H of all nodes, none of them fixed, is singular, with these
three for its null space where the graph is connected; some pose must be held.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from reference.pose_graph.graph import BLOCK, POINT, Floats


def gauge_null_vectors(poses: Floats, landmarks: Floats | None = None) -> Floats:
    """The three directions (3n + 2l, 3) for poses (n, 3) and landmarks (l, 2), laid out as the state is.

    (1, 0, 0) and (0, 1, 0) for every pose, (1, 0) and (0, 1) for every landmark; (-y, x, 1) and (-y, x).    (10)
    """
    points = np.zeros((0, POINT)) if landmarks is None else landmarks
    turns = np.column_stack([-poses[:, 1], poses[:, 0], np.ones(len(poses))])
    return np.column_stack(
        [
            np.concatenate([np.tile([1.0, 0.0, 0.0], len(poses)), np.tile([1.0, 0.0], len(points))]),
            np.concatenate([np.tile([0.0, 1.0, 0.0], len(poses)), np.tile([0.0, 1.0], len(points))]),
            np.concatenate([turns.ravel(), np.column_stack([-points[:, 1], points[:, 0]]).ravel()]),
        ]
    )


def gauge_dimension(n_poses: int, pairs: Sequence[tuple[int, int]]) -> int:
    """The dimension of the null space of H where no pose is held: 3 for each connected piece of the graph.

    Information is positive definite, so that H v = 0 is J v = 0; each block of J is invertible, so that v at one end of
    an edge gives v at the other. `pairs`: the ends of the edges.
    """
    i, j = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    adjacency = sparse.coo_array((np.ones(len(i)), (i, j)), shape=(n_poses, n_poses))
    count, _ = csgraph.connected_components(adjacency, directed=False)
    return BLOCK * int(count)
