"""What the three functions are asked by hand: any headings, some that wrap, correlated weights."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.probes import ProbeAnswer, ProbeResults, Probes, same_probe_answer, undo_rule
from graders.core.contract.values import Arguments
from graders.l19.matrices import matrix
from graders.l19.pairs import ReadPair, part
from graders.l20 import world
from graders.l20.jacobienne_arete.judge import BOTH, DERIVATIVE, SYSTEM
from graders.l20.poses.probes import only_angle, only_position, only_turns, position
from graders.l20.poses.probes import read as read_three
from graders.l20.slam_graphe.probes import EDGES

OMEGA = matrix((2.0, 0.4, -0.3), (0.4, 1.3, 0.2), (-0.3, 0.2, 3.1))
OTHER = matrix((1.1, -0.5, 0.1), (-0.5, 2.4, 0.6), (0.1, 0.6, 0.9))
WEIGHED: tuple[Arguments, ...] = tuple((*EDGES[k], (OMEGA, OTHER)[k % 2]) for k in range(5))
#: What a finite difference may change in an answer that is compared with those of known mistakes.
ROUGH = 2e-4
#: How far off finite differences with too large a step may be, relative to what they approach.
STEEP = 0.3


@undo_rule
def large_step(shown: ProbeResults) -> str | None:
    """Right but for what turns with θi, which is nearly so: a finite difference whose step is too large."""
    got, right = part(shown.got, 0), part(shown.right, 0)
    beside, its = part(shown.got, 1), part(shown.right, 1)
    if got is None or right is None or beside is None or its is None:
        return None
    if any(matrix.shape != (3, 3) for matrix in (*got, *beside)):
        return None
    straight = all(
        np.allclose(A[:, :2], B[:, :2], atol=ROUGH) and np.allclose(A[2], B[2], atol=ROUGH)
        for A, B in zip(got, right, strict=True)
    )
    gaps = [float(np.abs(A - B).max()) for A, B in zip(got, right, strict=True)]
    sizes = [1.0 + float(np.abs(B[:2, 2]).max()) for B in right]
    near = all(gap < STEEP * size for gap, size in zip(gaps, sizes, strict=True))
    off = sum(gap > DERIVATIVE for gap in gaps) >= len(gaps) - 1
    return "pas_trop_grand" if straight and near and off and np.allclose(beside, its, atol=ROUGH) else None


def second_alone(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    """B alone, or b alone."""
    return shown[1] if isinstance(shown, list) and len(shown) == 2 else shown


PROBES = (
    Probes(
        function="residu",
        calls=EDGES,
        kit=world.STILL,
        read=read_three,
        facet=position,
        rules=(only_turns, only_angle("residu_angle"), only_position("residu_position")),
    ),
    Probes(
        function="jacobiennes",
        calls=EDGES[:6],
        kit=world.STILL,
        read=ReadPair(BOTH),
        same=partial(same_probe_answer, tolerance=ROUGH),
        facet=second_alone,
        rules=(large_step,),
    ),
    Probes(
        function="contribution",
        calls=WEIGHED,
        kit=world.STILL,
        read=ReadPair(SYSTEM),
        same=partial(same_probe_answer, tolerance=20 * ROUGH),
        facet=second_alone,
    ),
)
