"""What the four functions are asked by hand: bent walls, any pairs, matrices with one or two free directions."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array
from graders.l19.matrices import matrix
from graders.l19.pairs import ReadPair
from graders.l20 import world
from graders.l20.icp_droite.cases import ASKED, drawn_matrix, drawn_pairs, with_gradient
from graders.l20.icp_droite.judge import read_rows

PARTS = ("A", "g")
STEADY = np.random.default_rng(17)
WALLS: tuple[Arguments, ...] = (
    (matrix((3, 1), (2.4, 1.7), (1.1, 2.2), (-0.3, 2.1), (-0.9, 3.5)),),
    (matrix((0, 0.3), (1.2, 0.5), (2, 1.7), (1.6, 2.6)),),
)
CLOUDS: tuple[Arguments, ...] = tuple(drawn_pairs(STEADY) for _ in range(3))
MATRICES: tuple[Arguments, ...] = (
    *((drawn_matrix(STEADY, strengths),) for strengths in (
        (0.0, 0.5, 1.2), (0.002, 0.03, 0.8), (0.001, 0.003, 0.9), (0.05, 3.0, 9.0), (1e-5, 0.03, 0.3),
    )),
    *((drawn_matrix(STEADY, strengths), threshold) for strengths, threshold in ASKED),
)  # fmt: skip
STEPS: tuple[Arguments, ...] = tuple(with_gradient(STEADY, args) for args in MATRICES)
#: By which one more direction is free in the first matrix: a memory that forgets the threshold does not see it.
HIGHER = 0.7
#: Any direction, by which normals are turned to the same side.
SIDE = np.array([0.83, 0.55])


def read_normals(args: Arguments, value: Value) -> Value:
    try:
        rows = read_array(value)
    except UnreadableError as error:
        return str(error)
    if rows.shape != args[0].shape:
        return f"forme {rows.shape}"
    return rows * np.where(rows @ SIDE < 0.0, -1.0, 1.0)[:, None]


def read_span(args: Arguments, value: Value) -> Value:
    """How many rows there are, and the sum of their squares as a matrix, which is one whatever the basis."""
    try:
        rows = read_rows(value)
    except UnreadableError as error:
        return str(error)
    if rows.ndim != 2 or rows.shape[1] != 3:
        return f"forme {rows.shape}"
    return np.append((rows.T @ rows).ravel(), len(rows))


def read_step(args: Arguments, value: Value) -> Value:
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


PROBES = (
    Probes(function="normales", calls=WALLS, kit=world.STILL, read=read_normals),
    Probes(function="systeme_droite", calls=CLOUDS, kit=world.STILL, read=ReadPair(PARTS)),
    Probes(function="directions_libres", calls=(*MATRICES, (*MATRICES[0], HIGHER)), kit=world.STILL, read=read_span),
    Probes(function="pas_droite", calls=(*STEPS, (*STEPS[0], HIGHER)), kit=world.STILL, read=read_step),
)
