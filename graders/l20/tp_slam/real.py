"""The same code on real scans: matches and graph, through the Intel laboratory."""

from __future__ import annotations

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.l20.tp_slam import journeys
from graders.l20.tp_slam.chain import Loop, ate, steps_of
from graders.l20.tp_slam.stages import film, matched, read_poses
from graders.l20.tp_slam.told import metres

#: In metres: the odometry that drifts comes to 1.19, the course's matches to 0.30, its graph to 0.11.
MATCHED, SOLVED = 0.70, 0.22
#: Loops of which fewer points agree are left out: half a turn of walls and people.
CONFIRMED = 0.6
TRUE_LOOP, TRUE_LOOP_TURN = 1.0, 0.2


def through_the_laboratory(bench: Bench) -> None:
    """Every scan on the one before, the loops that a guess allows, then the graph."""
    if bench.runner.failed & {"recalages", "graphe"}:
        raise Rejection(
            "Les vrais scans viendront quand les étapes A4 et A6 réussiront : il n’y a que du bruit à y ajouter.",
            inputs={}, expected="les étapes A4 et A6 réussies", got="pas encore",
        )  # fmt: skip
    place = journeys.indoor()
    moves = steps_of(place.odometry)
    pairs = [(place.clouds[k], place.clouds[k + 1], moves[k]) for k in range(len(moves))]
    matches, _ = matched(bench, pairs)
    start = journeys.added_up(matches)
    along = ate(start, place.truth)
    if along >= MATCHED:
        bench.observe("recaler", "intel", ok=False)
        raise Rejection(
            f"Sur les scans du laboratoire d’Intel, vos recalages mis bout à bout ont une ATE de {metres(along)}. "
            f"L’odométrie de départ en avait {metres(ate(place.odometry, place.truth))}.",
            inputs={"scans": len(place.clouds)},
            expected=f"une ATE sous {metres(MATCHED)}",
            got=f"une ATE de {metres(along)}",
        )
    loops = confirmed(bench)
    got = read_poses(bench, "optimiser", bench.call("optimiser", start, matches, moves, loops), len(start))
    after = ate(got, place.truth)
    bench.observe("optimiser", "intel", ok=after < SOLVED)
    film(bench, "intel", place.odometry, start, loops, got)
    if after >= SOLVED:
        raise Rejection(
            f"Sur le laboratoire d’Intel, l’ATE devrait tomber de {metres(along)} à {metres(0.11)} environ ; elle vaut "
            f"{metres(after)}.",
            inputs={"poses clés": len(start), "boucles": len(loops)},
            expected=f"une ATE sous {metres(SOLVED)}",
            got=f"une ATE de {metres(after)}",
        )


def confirmed(bench: Bench) -> list[Loop]:
    """The loops of which enough points agree once they are matched."""
    place = journeys.indoor()
    found, parts = matched(bench, [(place.clouds[a], place.clouds[b], guess) for a, b, guess in place.loops])
    return [
        (a, b, np.asarray(pose))
        for (a, b, _), pose, part in zip(place.loops, found, parts, strict=True)
        if part > CONFIRMED
    ]
