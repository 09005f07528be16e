"""What `systeme` and `slam_amers` are asked by hand: systems at any point; then one step, and all of them."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.probes import (
    ProbeAnswer,
    ProbeFault,
    ProbeResults,
    Probes,
    ProgramTrial,
    experiment_rule,
    measurement_rule,
    to_finite_array,
)
from graders.core.compare.comparison import Mismatch
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20 import world
from graders.l20.defi_amers.maps import Map, Sighting, placed, seen_from, sight
from graders.l20.defi_amers.optimum import Found, read_map
from graders.l20.defi_amers.system import COARSE, fingerprint
from graders.l20.slam_graphe.graphs import edge, rows
from graders.l20.slam_graphe.optimum import COARSENESS, FAR, LOST, gaps
from graders.l20.slam_graphe.probes import AROUND, LOOP, ROUND, START, TRUTH, TURNING
from graders.robotics.turned import is_detached_from_first, rigid_motion_between
from reference.se2 import relative

LANDMARKS = rows((2.5, 3.5), (0.5, 3.0))
OTHERS = rows((-0.5, -1.0), (1.5, -1.5))
SLANTED = np.array([[4.0, 1.5], [1.5, 2.0]])
SEEN_NOISE = rows((0.1, -0.06), (-0.08, 0.09), (0.05, 0.07), (-0.07, -0.1))
PAIRS = ((0, 0), (2, 0), (1, 1), (3, 1))


def _sightings(truth: Floats, landmarks: Floats) -> tuple[Sighting, ...]:
    weights = (SLANTED, 3.0 * np.eye(2), np.diag([2.0, 5.0]), SLANTED)
    return tuple(
        sight(i, j, np.round(seen_from(truth[i], landmarks[j]) + SEEN_NOISE[k], 3), weights[k])
        for k, (i, j) in enumerate(PAIRS)
    )


SEEN, SEEN_ROUND = _sightings(TRUTH, LANDMARKS), _sightings(ROUND, OTHERS)
AGAIN = (*SEEN, sight(0, 0, SEEN[0][2] + 0.2, SLANTED))
POINT = rows((0, 0, 0), (1, 0, 0))
SYSTEMS = (
    Map(POINT, rows((2, 1)), (edge(0, 1, (1, 0.5, 0.2)),), (sight(0, 0, (1, 3)),)),
    Map(START[:3], LANDMARKS, tuple(LOOP[:2]), SEEN[:3]),
    Map(START, LANDMARKS + 0.3, tuple(LOOP), SEEN),
    Map(AROUND, OTHERS - 0.2, tuple(TURNING), SEEN_ROUND),
    Map(rows((0, 0, -1.5), (1, 0, 1.5)), rows((1, 1)), (edge(0, 1, (1, 0.3, -3)),), (sight(0, 0, (1, 1.2), SLANTED),)),
    Map(rows((0, 0, 0.5), (1, 0, 1.5)), rows((1, 1)), (edge(0, 1, (1, 0.3, -1.2)),), (sight(1, 0, (1, 1.2), SLANTED),)),
    Map(START, LANDMARKS + 0.3, (*LOOP[:4], edge(0, 1, relative(TRUTH[0], TRUTH[1]) - 0.2, 5.0, 7.0)), AGAIN),
    Map(POINT, rows((2, 1)), (edge(0, 1, (1, 0.5, 0.2)),), (sight(0, 0, (1, -3), SLANTED),)),
)

PLACED, PLACED_ROUND = placed(START, SEEN, 2), placed(AROUND, SEEN_ROUND, 2)
FIRST = SYSTEMS[0]
MAPS = (
    Map(POINT, rows((3, 2)), FIRST.edges, (*FIRST.sightings, sight(1, 0, (1, 2), SLANTED)), 1, judged=False),
    Map(START, PLACED, tuple(LOOP), SEEN, 1, judged=False),
    Map(AROUND, PLACED_ROUND, tuple(TURNING), SEEN_ROUND, 1, judged=False),
    Map(START, PLACED, tuple(LOOP), SEEN, 2, judged=False),
    Map(START, PLACED, tuple(LOOP), SEEN),
    Map(AROUND, PLACED_ROUND, tuple(TURNING), SEEN_ROUND),
    Map(START, PLACED, tuple(LOOP[:3]), AGAIN),
    Map(START, PLACED, tuple(LOOP), SEEN, None),
)
STEPS, ENDED = range(4), range(4, 8)
PLAIN, WRAPPING = 4, 5
ONE_STEP = {PLAIN: 1, WRAPPING: 2}


CALLS: tuple[Arguments, ...] = tuple(tuple(one.at.values()) for one in SYSTEMS)
#: Thousands of mutants answer the same few calls: the right H and b of each are computed once.
POINTS = {id(args): one for args, one in zip(CALLS, SYSTEMS, strict=True)}


def read_point(args: Arguments, value: Value) -> Value:
    """H and b, coarse; in words what is neither."""
    return fingerprint(POINTS[id(args)], value)


def read(args: Arguments, value: Value) -> Value:
    """The map as one array, coarse; in words what is none, or is lost."""
    poses, landmarks, edges, sightings = args[:4]
    found = read_map(Map(poses, landmarks, tuple(edges), tuple(sightings)), value)
    if isinstance(found, Mismatch):
        return found.message
    numbers = np.concatenate([found.poses.ravel(), found.landmarks.ravel()])
    return numbers / COARSENESS if np.all(np.abs(numbers) < FAR) else LOST


def _found(shown: ProbeResults, k: int) -> Found | None:
    return _read_found(shown.got[k], MAPS[k])


def _read_found(answer: ProbeAnswer, one: Map) -> Found | None:
    numbers = to_finite_array(answer)
    if numbers is None:
        return None
    cut = 3 * len(one.poses)
    return Found(numbers[:cut].reshape(-1, 3) * COARSENESS, numbers[cut:].reshape(-1, 2) * COARSENESS)


def _reached(found: Found | None, one: Map) -> bool:
    return found is not None and _gap(found, one) < 1e-3


@measurement_rule
def half(shown: ProbeResults) -> str | None:
    """H is twice what it should be, or half of it, everywhere."""
    if any(isinstance(one, ProbeFault | str) for one in shown.got):
        return None
    sizes = [(3 * len(one.poses) + 2 * len(one.landmarks)) ** 2 for one in SYSTEMS]
    pairs = [
        (np.asarray(a)[:s] * COARSE, np.asarray(b)[:s] * COARSE)
        for a, b, s in zip(shown.got, shown.right, sizes, strict=True)
    ]
    scaled = any(all(np.allclose(a, factor * b, atol=1e-3) for a, b in pairs) for factor in (0.5, 2.0))
    return "facteur_deux" if scaled else None


@measurement_rule
def never_moves(shown: ProbeResults) -> str | None:
    found = [(_found(shown, k), MAPS[k]) for k in range(len(MAPS))]
    still = [
        f is not None and float(np.abs(gaps(m.poses, f.poses)).max()) < 1e-6
        and float(np.abs(m.landmarks - f.landmarks).max()) < 1e-6
        for f, m in found
    ]  # fmt: skip
    return "carte_de_depart" if all(still) else None


@measurement_rule
def landmarks_stay(shown: ProbeResults) -> str | None:
    """Poses move, landmarks never do."""
    found = [(_found(shown, k), MAPS[k]) for k in range(len(MAPS))]
    if never_moves(shown) is not None:
        return None
    still = [f is not None and float(np.abs(m.landmarks - f.landmarks).max()) < 1e-6 for f, m in found]
    return "amers_immobiles" if all(still) else None


@measurement_rule
def singular(shown: ProbeResults) -> str | None:
    """The first pose goes along, wherever the system has a solution; elsewhere it has none, or any, far away.

    Systems none of which can be solved tell nothing: without observations, landmarks are anywhere too.
    """
    lost = [isinstance(one, str) and one == LOST for one in shown.got]
    moved = [_first_moved(shown, k) for k in range(len(MAPS))]
    astray = all(left or gone for left, gone in zip(moved, lost, strict=True))
    return "jauge_libre" if astray and any(moved) and any(lost) else None


def _first_moved(shown: ProbeResults, k: int) -> bool:
    found = _found(shown, k)
    return found is not None and float(np.abs(gaps(MAPS[k].poses[:1], found.poses[:1])).max()) > 1e-3


@measurement_rule
def first_moves(shown: ProbeResults) -> str | None:
    """The first pose is not where it was given."""
    return "premiere_pose_bouge" if sum(_first_moved(shown, k) for k in range(len(MAPS))) >= len(MAPS) - 1 else None


@measurement_rule
def detached(shown: ProbeResults) -> str | None:
    """The optimum, moved as a whole, but for the first pose, which is where it was given."""
    found = [(MAPS[k].optimum, _found(shown, k)) for k in (PLAIN, WRAPPING)]
    apart = [
        one is not None and is_detached_from_first(poses, one.poses, (landmarks, one.landmarks))
        for (poses, landmarks), one in found
    ]
    return "carte_detachee" if all(apart) else None


@measurement_rule
def landmarks_left_behind(shown: ProbeResults) -> str | None:
    """Poses and landmarks are each those of the optimum, or of it moved as a whole, but not by the same motion."""
    found = [(MAPS[k].optimum, _found(shown, k)) for k in (PLAIN, WRAPPING)]
    behind = [one is not None and _is_left_behind(poses, landmarks, one) for (poses, landmarks), one in found]
    return "amers_mal_remis" if all(behind) else None


def _is_left_behind(poses: Floats, landmarks: Floats, found: Found) -> bool:
    right = float(np.abs(gaps(poses, found.poses)).max()) < 1e-3
    moved = float(np.abs(landmarks - found.landmarks).max()) > 1e-2
    shape = rigid_motion_between(landmarks, found.landmarks) is not None
    attached = is_detached_from_first(poses, found.poses, (landmarks, found.landmarks))
    return shape and moved and not attached and (right or is_detached_from_first(poses, found.poses))


@measurement_rule
def turns_only(shown: ProbeResults) -> str | None:
    """The optimum, with headings out of the interval."""
    found = [_found(shown, k) for k in ENDED]
    out = [f is not None and float(np.abs(f.poses[:, 2]).max()) > math.pi + 1e-6 for f in found]
    reached = all(map(_reached, found, [MAPS[k] for k in ENDED]))
    return "angles_jamais_ramenes" if any(out) and reached else None


def goes_on_from_its_end(trial: ProgramTrial) -> bool:
    """Asked again from where it ended, the program comes nearer to each optimum: it had stopped before it."""
    shown = trial.ask_probes()
    if len(shown.got) < len(shown.calls):
        return False
    ends = [_found(shown, k) for k in ONE_STEP]
    calls = [
        (end.poses, end.landmarks, *shown.calls[k][2:])
        for end, k in zip(ends, ONE_STEP, strict=True)
        if end is not None
    ]
    answers = trial.ask(calls) if len(calls) == len(ends) else ()
    if len(answers) < len(ends):
        return False
    return all(
        end is not None
        and (after := _read_found(answer, MAPS[k])) is not None
        and _gap(after, MAPS[k]) < 0.7 * _gap(end, MAPS[k])
        for k, end, answer in zip(ONE_STEP, ends, answers, strict=True)
    )


def _gap(found: Found, one: Map) -> float:
    return max(float(part.max()) for part in found.away(one))


@experiment_rule(goes_on_from_its_end)
def one_step_only(shown: ProbeResults) -> str | None:
    """Twenty iterations give what one gives."""
    arrays = [
        (to_finite_array(shown.got[all_of_them]), to_finite_array(shown.got[one]))
        for all_of_them, one in ONE_STEP.items()
    ]
    same = [a is not None and b is not None and np.allclose(a, b, atol=1e-8) for a, b in arrays]
    moved = never_moves(shown) is None and first_moves(shown) is None
    return "une_seule_iteration" if all(same) and moved and not _reached(_found(shown, PLAIN), MAPS[PLAIN]) else None


PROBES = (
    Probes(
        function="systeme",
        calls=CALLS,
        unique=False,
        kit=world.STILL,
        read=read_point,
        rules=(half,),
    ),
    Probes(
        function="slam_amers",
        calls=tuple(tuple(one.inputs.values()) for one in MAPS),
        unique=False,
        kit=world.STILL,
        read=read,
        faults={"LinAlgError": LOST},
        rules=(
            never_moves,
            landmarks_stay,
            singular,
            first_moves,
            turns_only,
            detached,
            landmarks_left_behind,
            one_step_only,
        ),
    ),
)
