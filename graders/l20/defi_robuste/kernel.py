"""The checks of `dimension_noyau`: graphs in one, two or three pieces, at any poses, far from any optimum.

In drawn graphs weights and lengths are near one, and the eigenvalues that are not zero stay above 5e-3 of the largest;
in a fixed long chain the smallest is 3e-4 of it. The statement promises 1e-4: whoever counts below that, or takes a
rank, finds the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.slam_graphe.graphs import Edge, edge, rows
from reference.pose_graph import gauge_dimension
from reference.se2 import relative

FUNCTION = "dimension_noyau"
NAMES = ("poses", "aretes")
#: Draws that never change: an eigenvalue that is not zero is below 0.5 there, and below a tenth of the largest.
FIXED = (1, 20, 3)
QUARTER = math.pi / 2


def expected(poses: Floats, edges: Sequence[Edge]) -> int:
    return gauge_dimension(len(poses), [(i, j) for i, j, _, _ in edges])


def examples(rng: np.random.Generator) -> Iterator[Arguments]:
    """Two poses; a chain and its loop; two pairs; two pieces of which the numbers alternate, or that hold a
    loop; three pieces; a long chain."""
    square = rows((0, 0, 0), (2, 0, QUARTER), (2, 2, math.pi), (0, 2, -QUARTER))
    steps = [edge(k, (k + 1) % 4, (2, 0, QUARTER)) for k in range(4)]
    yield square[:2], steps[:1]
    yield square[:2], [edge(1, 0, (1, 1, 0)), edge(0, 1, (2, 0, 1), 4.0, 2.0)]
    yield square, steps[:3]
    yield square, steps
    yield square, [steps[0], steps[2]]
    five = rows((0, 0, 0), (1, 2, 0.5), (2, 0, 1), (3, 2, -0.5), (4, 0, 2))
    yield five, [edge(0, 2, (2, 0, 1)), edge(4, 2, (1, 1, 0.5)), edge(3, 1, (1, 0, 0))]
    yield five, [edge(0, 2, (2, 0, 1)), edge(1, 2, (1, 1, 0.5)), edge(0, 1, (1, 2, 0)), edge(3, 4, (1, 0, 0))]
    six = np.vstack([five, [5.0, 2.0, -1.0]])
    yield six, [edge(0, 1, (1, 1, 0)), edge(3, 2, (1, 0, 1)), edge(4, 5, (1, 2, 0), 2.0, 5.0)]
    yield rows(*((4 * k, 0, 0) for k in range(8))), [edge(k, k + 1, (4, 0, 0)) for k in range(7)]
    # All weights tiny, or huge: only what is null beside the largest counts. Then weights that differ by a thousand.
    for scale in (1e-7, 1e7):
        yield square, [(i, j, z, scale * omega) for i, j, z, omega in steps]
        yield square, [(i, j, z, scale * omega) for i, j, z, omega in (steps[0], steps[2])]
    yield square, [steps[0], (*steps[1][:3], 2e-3 * steps[1][3]), steps[2]]


def drawn(rng: np.random.Generator) -> Iterator[Arguments]:
    """Any poses and weights, one to three pieces, chords in some."""
    for k, pieces in enumerate((1, 2, 1, 3, 2)):
        source = np.random.default_rng(FIXED[k]) if k < len(FIXED) else rng
        yield in_pieces(source, pieces)


def in_pieces(rng: np.random.Generator, pieces: int) -> Arguments:
    """A graph of seven poses, piece by piece a chain, closed where there is room; numbers and directions shuffled."""
    poses = np.round(np.column_stack([rng.uniform(-2.0, 2.0, (7, 2)), rng.uniform(-3.0, 3.0, 7)]), 1).astype(np.float64)
    members = np.array_split(rng.permutation(7), pieces)
    edges = []
    for group in members:
        pairs = [(group[k], group[k + 1]) for k in range(len(group) - 1)]
        if len(group) > 2:
            pairs.append((group[-1], group[0]))
        for ends in pairs:
            i, j = rng.permutation(ends)
            z = np.round(relative(poses[i], poses[j]) + rng.uniform(-0.5, 0.5, 3), 1)
            z[2] = math.remainder(z[2], math.tau)
            edges.append(edge(int(i), int(j), z, float(rng.choice([1, 2, 4])), float(rng.choice([1, 5]))))
    return poses, [edges[k] for k in rng.permutation(len(edges))]


def shrink_edges(value: Value) -> Iterator[Value]:
    """The graph without one of its edges, as long as one is left."""
    for k in range(len(value)):
        if len(value) > 1:
            yield [*value[:k], *value[k + 1 :]]


def whole(args: Arguments) -> bool:
    """Is every pose held by some edge? A pose alone is not asked about."""
    poses, edges = args
    return {k for one in edges for k in one[:2]} == set(range(len(poses)))


def pieces_figure(args: Arguments, wanted: Value, got: Floats | None) -> FigureData:
    poses, edges = args
    return {
        "kind": "pieces",
        "poses": poses.tolist(),
        "edges": [[i, j] for i, j, _, _ in edges],
        "expected": int(wanted),
        "got": None if got is None else float(got),
    }
