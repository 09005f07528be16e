"""Cases made by hand, one idea each: what is asked before the long journey, and once a check has failed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import unreadable
from graders.core.contract.values import Arguments, Floats, UnreadableError, read_array, read_indices
from graders.l20.tp_slam import pictures
from graders.l20.tp_slam.chain import Loop
from graders.l20.tp_slam.stages import matched, read_poses
from graders.l20.tp_slam.told import given_up
from reference.pose_graph import PoseGraph, gauss_newton
from reference.se2 import inverse, relative, transform, wrap_angle

Protocol = Callable[[Bench], None]
Cell = tuple[int, int]


def then(first: Protocol, second: Protocol, shown: Protocol | None = None) -> Protocol:
    """One after the other. Where the first one rejects, `shown` leaves a film of what the second one would see."""

    def both(bench: Bench) -> None:
        try:
            first(bench)
        except Rejection:
            if shown is not None and not bench.runner.reenacting:
                shown(bench)
            raise
        second(bench)

    return both


def rows(*poses: tuple[float, float, float]) -> Floats:
    return np.array(poses, dtype=np.float64)


LINE = np.column_stack([0.12 * np.arange(10), np.zeros(10), np.zeros(10)])
SPIN = np.column_stack([np.full(9, 2.0), np.full(9, -1.0), wrap_angle(2.8 + 0.15 * np.arange(9.0))])
RIGHT = np.column_stack([np.full(7, 0.5), np.full(7, 0.5), wrap_angle(-2.5 - 0.22 * np.arange(7.0))])
FAST = np.column_stack([0.4 * np.arange(4), np.zeros(4), np.full(4, 1.0)])
SLANT = np.column_stack([0.11 * np.arange(12), -0.13 * np.arange(12), np.full(12, -2.3)])
BOTH = rows(
    (1, 1, 0), (1.2, 1, 0.1), (1.25, 1, 0.35), (1.25, 1, 0.55), (1.25, 1.2, 0.6), (1.25, 1.32, 0.6), (1.3, 1.34, 0.9)
)
KEYS: tuple[tuple[Floats, list[int]], ...] = (
    (LINE, [0, 3, 6, 9]),
    (SPIN, [0, 3, 6]),
    (RIGHT, [0, 2, 4, 6]),
    (SLANT, [0, 2, 4, 6, 8, 10]),
    (BOTH, [0, 3, 5]),
    (FAST, [0, 1, 2, 3]),
)


def keys(bench: Bench) -> None:
    """Straight on, turning on the spot through the half turn, either way, slantwise, both at once, and fast."""
    for poses, wanted in KEYS:
        try:
            got = read_indices(bench.call("poses_cles", poses))
        except UnreadableError as error:
            raise given_up(bench, "poses_cles", unreadable(error)) from error
        bench.observe("poses_cles", got, ok=got == wanted)
        if got != wanted:
            raise Rejection(
                f"Sur ce chemin de {len(poses)} poses, on garde les indices {wanted}, et votre fonction {got[:20]}."
                f"{_first_difference(poses, wanted, got)}",
                inputs={"poses": np.round(poses, 3)},
                expected=wanted,
                got=got[:20],
            )


def _first_difference(poses: Floats, wanted: Sequence[int], got: Sequence[int]) -> str:
    """Return how far the robot comes, from the index kept before, to the first one that is kept wrongly or not kept."""
    index = min({*wanted} ^ {*got}, default=0)
    if not 0 < index < len(poses):
        return ""
    last = max(kept for kept in wanted if kept < index)
    length = float(np.hypot(*np.diff(poses[last : index + 1, :2], axis=0).T).sum())
    turn = abs(float(wrap_angle(poses[index, 2] - poses[last, 2])))
    return (
        f" À l'indice {index}, le robot a fait {render.number(100.0 * length, 3)} cm et tourné de "
        f"{render.number(turn, 3)} rad depuis l'indice {last}."
    )


def _scattered(seed: int, apart: float, count: int) -> Floats:
    """Points of a room of 4 m by 2.6, no two of which are closer than `apart`: two clouds fit in one way alone."""
    rng = np.random.default_rng(seed)
    points = [np.zeros(2)]
    while len(points) < count:
        point = rng.uniform((-1.5, -1.1), (2.5, 1.5))
        if np.min(np.hypot(*(np.array(points) - point).T)) > apart:
            points.append(point)
    return np.array(points)


ROOM = _scattered(3, 0.2, 90)
STRANGE = np.column_stack([np.linspace(5.0, 7.0, 40), np.linspace(3.0, -2.0, 40)])
FAR = np.column_stack([np.linspace(9.0, 11.0, 17), np.linspace(-7.0, -9.0, 17)])
POSE = np.array([0.45, -0.3, 0.5])
NEARBY = np.round(POSE + np.array([0.11, -0.09, 0.08]), 3)
BACK = np.array([-0.6, 0.2, -2.9])
BARELY = np.round(POSE + np.array([0.05, -0.04, 0.03]), 3)


def seen_from(pose: Floats, points: Floats) -> Floats:
    """The points in the frame of a pose."""
    return np.asarray(transform(inverse(pose), points))


def _beside(seed: int, count: int) -> Floats:
    """Points a little too far from those of the room: they are paired, and are no neighbours within 10 cm.

    With this seed they pull every way alike: the pose stays within 2 mm.
    """
    rng = np.random.default_rng(seed)
    points: list[Floats] = []
    while len(points) < count:
        point = ROOM[rng.integers(len(ROOM))] + rng.uniform(-0.25, 0.25, 2)
        if 0.14 < np.min(np.hypot(*(ROOM - point).T)) < 0.25:
            points.append(point)
    return np.array(points)


#: points_a, points_b, depart; then the pose and the share of points that come to lie near one of a.
MATCHES: tuple[tuple[tuple[Floats, Floats, Floats], Floats, float], ...] = (
    ((ROOM, ROOM, np.zeros(3)), np.zeros(3), 1.0),
    ((ROOM, seen_from(POSE, ROOM), NEARBY), POSE, 1.0),
    ((ROOM, seen_from(BACK, ROOM), np.round(BACK + np.array([-0.07, 0.05, -0.04]), 3)), BACK, 1.0),
    ((ROOM, np.vstack([seen_from(POSE, ROOM), STRANGE]), NEARBY), POSE, len(ROOM) / (len(ROOM) + len(STRANGE))),
    ((np.vstack([ROOM, STRANGE]), seen_from(POSE, ROOM)[::2], NEARBY), POSE, 1.0),
    ((ROOM, seen_from(POSE, np.vstack([ROOM, _beside(137, 30)])), NEARBY), POSE, 0.75),
    ((ROOM, np.vstack([seen_from(POSE, ROOM[[0, 20, 40]]), FAR]), BARELY), POSE, 0.15),
    ((ROOM, np.vstack([seen_from(POSE, ROOM[[0, 20]]), FAR]), BARELY), BARELY, 0.0),
    ((ROOM, ROOM + 30.0, np.array([1.0, 2.0, 0.3])), np.array([1.0, 2.0, 0.3]), 0.0),
)
EXACT, SHARE = 0.01, 0.02


def matches(bench: Bench) -> None:
    """A room on itself: as it is, from elsewhere, with points that the other scan did not see, with some that lie a
    little beside, by three points alone, by two, which are not enough, and too far away."""
    found, parts = matched(bench, [args for args, _, _ in MATCHES])
    for (args, wanted, share), pose, part in zip(MATCHES, found, parts, strict=True):
        lost = share == 0.0
        missed = relative(wanted, pose)
        well = bool(lost or np.abs(missed).max() < EXACT) and abs(part - share) < SHARE
        bench.observe("recaler", [*np.round(pose, 2).tolist(), round(part, 2)], ok=well)
        if not well:
            a, b, start = args
            raise Rejection(
                "Une pièce de 4 m sur 2,6 m, vue deux fois" + (", mais trop loin d’elle-même pour que l’on rapproche "
                "rien." if lost else ".") + " La pose de b vue de a, ou la part, n’est pas la bonne.",
                inputs={"points_a": f"{len(a)} points", "points_b": f"{len(b)} points", "depart": start},
                expected=[None if lost else np.round(wanted, 3), round(share, 3)],
                got=[np.round(pose, 3), round(part, 3)],
                figure=pictures.match_figure(a, b, wanted, pose, start),
            )  # fmt: skip


def _measured(truth: Floats) -> tuple[Floats, Floats, Floats, list[Loop]]:
    """What four poses are seen as: their chain, the matches, odometry, and a loop between the first and the last."""
    steps = np.round(relative(truth[:-1], truth[1:]), 3)
    return (
        np.round(truth + rows((0, 0, 0), (0.02, -0.03, 0.02), (0.05, 0.02, -0.04), (-0.04, 0.06, 0.05)), 3),
        np.round(steps + rows((0.02, 0.01, 0.01), (-0.03, 0.01, -0.02), (0.01, -0.04, 0.02)), 3),
        np.round(steps + rows((-0.05, 0.03, 0.06), (0.04, -0.05, 0.05), (0.06, 0.02, -0.08)), 3),
        [(0, 3, np.round(relative(truth[0], truth[3]) + np.array([0.05, -0.06, 0.03]), 3))],
    )


TRUTH = rows((0, 0, 0), (0.3, 0.05, 0.4), (0.5, 0.35, 1.4), (0.2, 0.5, 2.9))
#: The same shape, eight times as large: how far one trusts an angle moves the poses by centimetres.
WIDE = TRUTH * np.array([8.0, 8.0, 1.0])
CHAINED, FOUND, MOVED, LOOP = _measured(TRUTH)
BACKWARDS = [(3, 0, np.round(relative(TRUTH[3], TRUTH[0]) + np.array([-0.04, 0.05, 0.02]), 3))]
GRAPHS: tuple[Arguments, ...] = (
    (CHAINED, FOUND, MOVED, LOOP),
    (CHAINED, FOUND, np.round(relative(TRUTH[:-1], TRUTH[1:]), 3), []),
    (CHAINED, FOUND, FOUND, LOOP),
    (CHAINED, FOUND, MOVED, BACKWARDS),
    _measured(WIDE),
)
#: Standard deviations, of positions and of angles: matches, odometry, loops.
SIGMAS = ((0.02, 0.01), (0.03, 0.05), (0.03, 0.015))
SETTLED = 1e-3


def graph_of(args: Arguments) -> PoseGraph:
    """The three kinds of edges, each with its information."""
    chain, found, moved, loops = args
    omegas = [np.diag([s**-2, s**-2, a**-2]) for s, a in SIGMAS]
    edges = [(k, k + 1, z, omegas[0]) for k, z in enumerate(found)]
    edges += [(k, k + 1, z, omegas[1]) for k, z in enumerate(moved)]
    edges += [(a, b, z, omegas[2]) for a, b, z in loops]
    wrapped = [(a, b, np.array([z[0], z[1], wrap_angle(z[2])]), w) for a, b, z, w in edges]
    return PoseGraph.from_edges(len(chain), wrapped)


def graphs(bench: Bench) -> None:
    """Four poses: with a loop, without, where odometry repeats the matches, with a loop told backwards, and wide."""
    for args in GRAPHS:
        graph = graph_of(args)
        wanted = gauss_newton(graph, args[0], max_iterations=30).poses
        got = read_poses(bench, "optimiser", bench.call("optimiser", *args), len(wanted))
        apart = np.column_stack([got[:, :2] - wanted[:, :2], wrap_angle(got[:, 2] - wanted[:, 2])])
        well = float(np.abs(apart).max()) < SETTLED
        bench.observe("optimiser", np.round(got, 3), ok=well)
        if not well:
            k = int(np.argmax(np.abs(apart).max(axis=1)))
            raise Rejection(
                f"Quatre poses, {'une' if args[3] else 'aucune'} boucle : la pose {k} devrait finir en "
                f"({' ; '.join(_decimal(v) for v in wanted[k])}).",
                inputs={"chaine": args[0], "recalages": args[1], "deplacements": args[2], "boucles": args[3]},
                expected=wanted,
                got=got,
                figure=pictures.graph_figure(graph, args[0], wanted, got),
            )


def _decimal(value: float) -> str:
    return f"{value:.3f}".replace(".", ",").replace("-", "−")


#: Half a metre a cell, a grid of 12 rows and 30 columns whose corner is not the origin; no ray leaves it.
SHAPE, CORNER, SIDE = (12, 30), np.array([-1.0, -2.0]), 0.5
SCAN = np.array([8.0, 1.2, 0.7, 1.7])
PLACES = rows((0.25, 0.25, 0.0), (10.25, 0.25, np.pi))
TWICE = np.array([SCAN, SCAN])
#: Cells (row, column) that must be said occupied and free after the one scan of each place.
OCCUPIED = (((6, 2), (4, 1), (1, 2)), ((2, 22), (4, 23), (7, 22)))
OPEN = (
    ((4, 4), (4, 10), (4, 17), (5, 2), (3, 2), (2, 2)),
    ((4, 20), (4, 12), (4, 7), (3, 22), (5, 22), (6, 22)),
)
#: Where the ray ends that has seen nothing: no wall.
NO_WALL = ((4, 18), (4, 6))
OPEN_NEAR = ((4, 4), (4, 10), (5, 2), (3, 2), (2, 2))
BOTH_OCCUPIED, BOTH_OPEN = OCCUPIED[0] + OCCUPIED[1], OPEN[0] + OPEN[1]
MAPS: tuple[Arguments, ...] = (
    (PLACES[:1], TWICE[:1], SHAPE, CORNER, SIDE),
    (PLACES[1:], TWICE[:1], SHAPE, CORNER, SIDE),
    (PLACES, TWICE, SHAPE, CORNER, SIDE),
    # Another lidar, whose range is given: six metres read on it are nothing seen.
    (PLACES[:1], np.array([[6.0, *SCAN[1:]]]), SHAPE, CORNER, SIDE, 6.0),
)


def maps(bench: Bench) -> None:
    """One scan of four rays on a small grid, then two; then one of a shorter range."""
    ends = (NO_WALL[:1], NO_WALL[1:], NO_WALL, ((4, 14),))
    occupied_cells, open_cells = (*OCCUPIED, BOTH_OCCUPIED, OCCUPIED[0]), (*OPEN, BOTH_OPEN, OPEN_NEAR)
    for args, occupied, free, empty in zip(MAPS, occupied_cells, open_cells, ends, strict=True):
        try:
            got = read_array(bench.call("carte", *args))
        except UnreadableError as error:
            raise given_up(bench, "carte", unreadable(error)) from error
        shaped = got.shape == SHAPE and bool(np.all(np.isfinite(got)))
        wrong = _wrong_cells(got, occupied, free, empty) if shaped else []
        bench.observe("carte", np.sign(got) if shaped else list(got.shape), ok=shaped and not wrong)
        if not shaped or wrong:
            raise _misdrawn(args, got, _wishes(occupied, free, empty) if shaped else {}, wrong)


def _misdrawn(args: Arguments, got: Floats, wishes: Mapping[Cell, str], wrong: Sequence[Cell]) -> Rejection:
    """What is said of a map of another shape, or else of its first wrong cell."""
    poses, scans = args[0], args[1]
    inputs = {"poses": poses, "scans": scans, "forme": list(SHAPE), "origine": CORNER, "cote": SIDE}
    inputs |= {"portee": args[5]} if len(args) > 5 else {}
    if not wrong:
        return Rejection(
            f"carte doit renvoyer un tableau de forme {SHAPE}, sans nan ni infini.", inputs=inputs,
            expected=f"forme {SHAPE}",
            got=f"forme {got.shape}" if got.shape != SHAPE else "des nombres qui n’en sont pas",
        )  # fmt: skip
    cell = wrong[0]
    many = "Deux scans" if len(poses) > 1 else "Un scan"
    others = f" ; {len(wrong) - 1} autres cases sont fausses" if len(wrong) > 2 else ""
    return Rejection(
        f"{many} de quatre rayons : la case {cell} (ligne, colonne) devrait être {MUST_BE[wishes[cell]]}{others}.",
        inputs=inputs,
        expected=f"{wishes[cell]} dans la case {cell}",
        got=f"{_decimal(float(got[cell]))} dans la case {cell}",
        figure=pictures.small_map_figure(poses, scans, CORNER, SIDE, float(scans.max()), got, cell),
    )


POSITIVE, NEGATIVE, NOT_POSITIVE = "un log-odds positif", "un log-odds négatif", "un log-odds nul ou négatif"
MUST_BE = {
    POSITIVE: "occupée",
    NEGATIVE: "libre",
    NOT_POSITIVE: "sans mur : le rayon qui y finit n’a rien vu",
}


def _wishes(occupied: Sequence[Cell], free: Sequence[Cell], empty: Sequence[Cell]) -> dict[Cell, str]:
    return dict.fromkeys(empty, NOT_POSITIVE) | dict.fromkeys(free, NEGATIVE) | dict.fromkeys(occupied, POSITIVE)


def _wrong_cells(got: Floats, occupied: Sequence[Cell], free: Sequence[Cell], empty: Sequence[Cell]) -> list[Cell]:
    return [
        *(cell for cell in occupied if got[cell] <= 0),
        *(cell for cell in free if got[cell] >= 0),
        *(cell for cell in empty if got[cell] > 0),
    ]
