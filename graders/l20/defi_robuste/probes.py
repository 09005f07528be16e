"""What `dimension_noyau` and `gauss_newton_robuste` are asked by hand: small graphs, some with a false chord."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import ProbeResults, Probes, measurement_rule, to_finite_array
from graders.core.compare.comparison import Mismatch
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_scalar
from graders.l20 import world
from graders.l20.defi_robuste.graphs import DELTA, Robust
from graders.l20.defi_robuste.kernel import examples
from graders.l20.defi_robuste.robust import HELD, read_answer
from graders.l20.slam_graphe.graphs import Edge, Graph, edge, odometry, rows
from graders.l20.slam_graphe.optimum import COARSENESS, FAR, LOST, gaps
from reference.se2 import relative


def _chain(*order: int) -> Arguments:
    """Six poses held by one chain, whose steps are listed in this order."""
    poses = rows(*((k, 0.5 * (k % 2), 0.2 * k) for k in range(6)))
    steps = [edge(k, k + 1, (1, 0, 0.1)) for k in range(5)]
    return poses, [steps[k] for k in order]


#: One graph, the same edges in other orders, then the first of them again.
REORDERED: tuple[Arguments, ...] = (
    _chain(0, 1, 2, 3, 4),
    _chain(4, 3, 2, 1, 0),
    _chain(0, 2, 4, 1, 3),
    _chain(0, 1, 2, 3, 4),
)
STAR = ((0, 1), (0, 2), (0, 3), (3, 4), (3, 5))
#: One tree, then the same with each edge the other way round: of poses at one place, H is the same then.
REVERSED: tuple[Arguments, ...] = tuple(
    (np.zeros((6, 3)), [edge(*ends, (1, 0, 0.1), 1.7 + 0.3 * k, 2.9) for k, ends in enumerate(pairs)])
    for pairs in (STAR, [ends[::-1] for ends in STAR])
)
COUNTED: tuple[Arguments, ...] = (*examples(np.random.default_rng(0)), *REVERSED, *REORDERED)

TRUTH = rows((1, 2, 0.3), (3, 2.5, 0.9), (3.5, 4.5, 2.2), (1.5, 5, -2.9), (0.5, 3, -1.6))
NOISE = rows((0.1, -0.05, 0.06), (-0.08, 0.12, -0.05), (0.06, 0.07, 0.04), (-0.12, 0.05, -0.07), (0.07, -0.1, 0.05))
PAIRS = ((0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (2, 0), (1, 4))


def _measured() -> list[Edge]:
    made = []
    for k, (i, j) in enumerate(PAIRS):
        z = np.round(relative(TRUTH[i], TRUTH[j]) + NOISE[k % len(NOISE)], 3)
        made.append(edge(i, j, z, (100.0, 25.0)[k > 3], (400.0, 100.0)[k > 3]))
    return made


TRUE = _measured()
LIE = edge(3, 1, (0.2, -0.1, 0.3), 25.0, 100.0)
START = odometry(TRUTH[0], TRUE[:4], 5)


def _graph(edges: list[Edge], n_iter: int) -> Robust:
    return Robust(START, tuple(edges), TRUTH, np.array([one is LIE for one in edges]), n_iter)


AMONG = [*TRUE[:2], LIE, *TRUE[2:]]
GRAPHS = (_graph(AMONG, 1), _graph(AMONG, 2), _graph(TRUE, 15), _graph(AMONG, 15))
LAST = 3
#: Below this, an edge is believed no more.
REJECTED = 0.1


def count(args: Arguments, value: Value) -> Value:
    """The number that came back, in words what is none."""
    try:
        return read_scalar(value)
    except UnreadableError as error:
        return str(error)


def read(args: Arguments, value: Value) -> Value:
    """Poses and weights as one array, coarse; in words what is neither, or is lost."""
    poses, edges = args[:2]
    found = read_answer(Robust(poses, tuple(edges), poses, np.zeros(len(edges), dtype=np.bool_)), value)
    if isinstance(found, Mismatch):
        return found.message
    if not np.all(np.abs(found.poses) < FAR):
        return LOST
    return np.concatenate([found.poses.ravel(), found.weights]) / COARSENESS


def _shown(shown: ProbeResults, k: int) -> tuple[Floats, Floats] | None:
    numbers = to_finite_array(shown.got[k])
    if numbers is None or numbers.shape != (15 + len(GRAPHS[k].edges),):
        return None
    return numbers[:15].reshape(-1, 3) * COARSENESS, numbers[15:] * COARSENESS


def _near(poses: Floats, other: Floats) -> bool:
    return float(np.abs(gaps(other, poses)).max()) < 1e-3


@measurement_rule
def plain_least_squares(shown: ProbeResults) -> str | None:
    """What is reached is the optimum of plain least squares."""
    found = _shown(shown, LAST)
    return "moindres_carres_ordinaires" if found and _near(found[0], GRAPHS[LAST].plain) else None


@measurement_rule
def never_moves(shown: ProbeResults) -> str | None:
    found = [_shown(shown, k) for k in range(len(GRAPHS))]
    return "rien_ne_bouge" if all(one is not None and _near(one[0], START) for one in found) else None


@measurement_rule
def first_moves(shown: ProbeResults) -> str | None:
    """No pose is held, or another than the first: it is not where it was given, or the system cannot be solved.

    Systems none of which can be solved tell nothing: with weights of zero there is no other either.
    """
    unsolved = [isinstance(one, str) and one == LOST for one in shown.got]
    found = [_shown(shown, k) for k in range(len(GRAPHS))]
    moved = [one is not None and float(np.abs(gaps(START[:1], one[0][:1])).max()) > HELD for one in found]
    astray = [left or gone for left, gone in zip(moved, unsolved, strict=True)]
    return "jauge_libre" if any(moved) and sum(astray) >= len(GRAPHS) - 1 else None


@measurement_rule
def weights_out(shown: ProbeResults) -> str | None:
    """Weights above one or below zero, with poses that are not those of plain least squares."""
    found = _shown(shown, LAST)
    if found is None or plain_least_squares(shown):
        return None
    return "poids_hors_intervalle" if np.any(found[1] > 1.0 + 1e-4) or np.any(found[1] < -1e-4) else None


def true_optimum() -> Floats:
    """The optimum of the true edges."""
    return Graph(START, tuple(TRUE)).optimum


@measurement_rule
def all_trusted(shown: ProbeResults) -> str | None:
    """The map is near the right one, but the weights that are told are all ones."""
    found = _shown(shown, LAST)
    if found is None or plain_least_squares(shown):
        return None
    near = float(np.abs(gaps(true_optimum(), found[0])).max()) < 0.2
    return "poids_tous_a_un" if near and np.allclose(found[1], 1.0, atol=1e-4) else None


@measurement_rule
def misplaced(shown: ProbeResults) -> str | None:
    """The map is near the right one, and the only small weight is told of another edge than the false one."""
    found = _shown(shown, LAST)
    if found is None or plain_least_squares(shown):
        return None
    near = float(np.abs(gaps(true_optimum(), found[0])).max()) < 0.2
    small = np.flatnonzero(found[1] < REJECTED)
    lie = next(k for k, one in enumerate(AMONG) if one is LIE)
    wrong = small.size == 1 and small[0] != lie and found[1][lie] > 0.5
    return "poids_dans_le_desordre" if near and wrong else None


@measurement_rule
def constant(shown: ProbeResults) -> str | None:
    """The same number, whatever the graph."""
    numbers = {float(one) for one in shown.got if isinstance(one, int | float)}
    return "toujours_pareil" if len(numbers) == 1 and len(shown.got) > 1 else None


@measurement_rule
def depends_on_the_order(shown: ProbeResults) -> str | None:
    """Other numbers for one graph whose edges come in another order, and the same for the same call asked again."""
    numbers = _steady_numbers(shown)
    return "ordre_des_aretes" if len(set(numbers[-len(REORDERED) :])) > 1 else None


@measurement_rule
def depends_on_directions(shown: ProbeResults) -> str | None:
    """Other numbers for one tree whose edges go the other way, and the same for the same call asked again."""
    numbers = _steady_numbers(shown)[-len(REORDERED) - len(REVERSED) :]
    return "sens_qui_compte" if len(set(numbers[: len(REVERSED)])) > 1 else None


def _steady_numbers(shown: ProbeResults) -> list[float]:
    """All answers; none where one is no number, or where the same call has another answer when it is asked again."""
    numbers = [float(one) for one in shown.got if isinstance(one, int | float)]
    again = numbers[-len(REORDERED) :]
    return numbers if len(numbers) == len(COUNTED) and again[0] == again[-1] else []


PROBES = (
    Probes(
        function="dimension_noyau",
        calls=COUNTED,
        kit=world.STILL,
        read=count,
        rules=(constant, depends_on_the_order, depends_on_directions),
    ),
    Probes(
        function="gauss_newton_robuste",
        calls=tuple((one.poses, list(one.edges), DELTA, one.n_iter) for one in GRAPHS),
        unique=False,
        kit=world.STILL,
        read=read,
        faults={"LinAlgError": LOST},
        rules=(never_moves, first_moves, plain_least_squares, all_trusted, misplaced, weights_out),
    ),
)
