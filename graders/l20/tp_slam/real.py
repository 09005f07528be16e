"""The same code on real scans and the robot's own odometry: matches, calibration, loops, graph."""

from __future__ import annotations

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Floats
from graders.l20.tp_slam import journeys
from graders.l20.tp_slam.chain import Loop, ate, steps_of
from graders.l20.tp_slam.stages import film, matched, read_poses
from graders.l20.tp_slam.told import metres
from reference.calibration import CalibrationError, calibrate_steps
from reference.se2 import compose

#: In metres: odometry comes to 10.8 and the course's matches from it to 0.80; from calibrated odometry, these come to
#: 0.21, and the graph to 0.10, or to 0.25 without loops.
MATCHED, MATCHED_AGAIN, SOLVED = 2.5, 0.6, 0.22
#: Loops of which fewer points agree are left out, and those that want the robot elsewhere than the others do by more
#: (m): in a corridor a scan slides, and nearly all of its points agree. Of one passage, true loops agree to 0.3 m with
#: their median, false ones miss it by 0.8 m and more.
CONFIRMED, ASTRAY = 0.6, 0.6


def through_the_laboratory(bench: Bench) -> None:
    """Every scan on the one before, again from odometry that these matches have calibrated; loops; then the graph."""
    if bench.runner.failed & {"recalages", "graphe"}:
        raise Rejection(
            "Les vrais scans viendront quand les étapes A4 et A6 réussiront : il n’y a que du bruit à y ajouter.",
            inputs={}, expected="les étapes A4 et A6 réussies", got="pas encore", neutral=True,
        )  # fmt: skip
    place = journeys.indoor()
    raw = steps_of(place.odometry)
    first = _chained(bench, raw, MATCHED, "l’odométrie du robot", ate(place.odometry, place.truth))
    moves = _calibrated(raw, first)
    matches = _chained(bench, moves, MATCHED_AGAIN, "l’odométrie étalonnée", ate(journeys.added_up(moves), place.truth))
    start = journeys.added_up(matches)
    loops = confirmed(bench, start)
    got = read_poses(bench, "optimiser", bench.call("optimiser", start, matches, moves, loops), len(start))
    along, after = ate(start, place.truth), ate(got, place.truth)
    bench.observe("optimiser", "intel", ok=after < SOLVED)
    film(bench, "intel", place.odometry, start, loops, got, before=journeys.added_up(first))
    if after >= SOLVED:
        raise Rejection(
            f"Sur le laboratoire d’Intel, l’ATE devrait tomber de {metres(along)} à {metres(0.10)} environ ; elle vaut "
            f"{metres(after)}.",
            inputs={"poses clés": len(start), "boucles": len(loops)},
            expected=f"une ATE sous {metres(SOLVED)}",
            got=f"une ATE de {metres(after)}",
        )
    bench.measured = (
        f"Vos ATE : {metres(ate(journeys.added_up(first), place.truth))} avec vos recalages, {metres(along)} une fois "
        f"l’odométrie étalonnée, {metres(after)} avec {len(loops)} boucles dans le graphe."
    )


def _chained(bench: Bench, moves: Floats, allowed: float, start: str, before: float) -> Floats:
    """The matches (k - 1, 3) of each scan on the one before, from what odometry says. Raises Rejection."""
    place = journeys.indoor()
    pairs = [(place.clouds[k], place.clouds[k + 1], moves[k]) for k in range(len(moves))]
    matches, _ = matched(bench, pairs)
    along = ate(journeys.added_up(matches), place.truth)
    if along >= allowed:
        bench.observe("recaler", "intel", ok=False)
        film(bench, "intel", place.odometry, journeys.added_up(matches))
        raise Rejection(
            f"Sur les scans du laboratoire d’Intel, vos recalages partis de {start} et mis bout à bout ont une ATE de "
            f"{metres(along)}. Cette odométrie en avait {metres(before)}.",
            inputs={"scans": len(place.clouds)},
            expected=f"une ATE sous {metres(allowed)}",
            got=f"une ATE de {metres(along)}",
        )
    return matches


def _calibrated(raw: Floats, matches: Floats) -> Floats:
    """The steps of odometry as three constants correct them, found on the submission's own matches."""
    try:
        return calibrate_steps(raw, matches).correct(raw)
    except CalibrationError as error:
        raise Rejection(
            "Vos recalages ne permettent pas d’étalonner l’odométrie : le robot n’y avance pas, ou n’y tourne pas.",
            inputs={"recalages": len(matches)}, expected="des pas et des virages", got=matches[:3],
        ) from error  # fmt: skip


def confirmed(bench: Bench, chain: Floats) -> list[Loop]:
    """The proposals of which enough points agree once they are matched, and that agree with most of the others."""
    place = journeys.indoor()
    found, parts = matched(bench, [(place.clouds[a], place.clouds[b], guess) for a, b, guess in place.loops])
    loops = [
        (a, b, np.asarray(pose))
        for (a, b, _), pose, part in zip(place.loops, found, parts, strict=True)
        if part > CONFIRMED
    ]
    wanted = np.array([compose(chain[a], pose)[:2] - chain[b, :2] for a, b, pose in loops]).reshape(-1, 2)
    away = np.hypot(*(wanted - np.median(wanted, axis=0)).T) if loops else np.zeros(0)
    return [loop for loop, apart in zip(loops, away, strict=True) if apart < ASTRAY]
