"""What the three functions are asked by hand: graphs with a loop, correlated doubts, closures on both sides."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import ProbeFault, ProbeResults, Probes, measurement_rule, to_finite_array, undo_rule
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array
from graders.l19.pairs import ReadPair, only
from graders.l20 import world
from graders.l20.fermeture.cases import TARGETS, drawn_closure, drawn_graph, drawn_pair

VERDICT = ("d²", "accepte")
STEADY = np.random.default_rng(11)
GRAPHS: tuple[Arguments, ...] = (
    drawn_graph(STEADY, 4, (1, 3)),
    drawn_graph(STEADY, 4, (3, 1)),
    drawn_graph(STEADY, 5, (2, 4)),
    drawn_graph(STEADY, 3, (0, 2)),
)
PAIRS: tuple[Arguments, ...] = tuple(drawn_pair(STEADY) for _ in range(4))
ASKED = (*TARGETS[:11], (3.7, 0.5))
CLOSURES: tuple[Arguments, ...] = tuple(drawn_closure(STEADY, *target) for target in ASKED)
#: Beyond this, an answer comes from a matrix that has no inverse.
HUGE = 1e6


def read_matrix(args: Arguments, value: Value) -> Value:
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


@undo_rule
def no_gauge(shown: ProbeResults) -> str | None:
    """H is inverted as it is: it has no inverse, and what comes back is an exception, or absurd."""

    def lost(answer: object) -> bool:
        if isinstance(answer, ProbeFault):
            return answer.name == "LinAlgError"
        found = to_finite_array(answer)
        return found is None or bool(np.abs(found).max(initial=0.0) > HUGE)

    return "jauge_libre" if all(map(lost, shown.got)) else None


@measurement_rule
def other_gauge(shown: ProbeResults) -> str | None:
    """What is left where no motion of the whole counts is right, of poses other than the first; the rest is not."""
    for (H, i, j), answer, right in zip(shown.calls, shown.got, shown.right, strict=True):
        if not i or not j:
            continue
        found = to_finite_array(answer, (6, 6))
        if found is None or np.allclose(found, right, 1e-6, 1e-6):
            return None
        which = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
        of_the_whole = np.linalg.eigh(H)[1][which, :3]  # (6, 3): what the three free motions do to both poses
        inside = np.linalg.svd(of_the_whole.T)[2][3:]
        if not np.allclose(inside @ found @ inside.T, inside @ right @ inside.T, 1e-5, 1e-6):
            return None
    return "autre_jauge"


PROBES = (
    Probes(
        function="covariance_jointe", calls=GRAPHS, kit=world.STILL, read=read_matrix, rules=(no_gauge, other_gauge)
    ),
    Probes(function="covariance_relative", calls=PAIRS, kit=world.STILL, read=read_matrix),
    Probes(
        function="juger_fermeture",
        calls=CLOSURES,
        kit=world.STILL,
        read=ReadPair(VERDICT),
        last_rules=(only(1, "avis_faux", ()),),
    ),
)
