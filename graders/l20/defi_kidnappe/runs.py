"""The hidden runs of l20/defi_kidnappe: thirty steps, then the robot is put elsewhere, and sixty steps to find it."""

from __future__ import annotations

from functools import cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.loops import ClosedLoopRun
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Floats
from graders.l20 import journeys, world
from graders.l20.journeys import Journey
from graders.l20.mcl.answers import estimated, seeded
from graders.l20.mcl.runs import PARTICLES, Following, run_figure
from graders.l20.mcl.telling import number, pose_text
from reference.world.grid_map import GridMap

RUNS, FOUND = 15, 7
BEFORE, AFTER, WINDOW = 30, 60, 30
NEAR, IN_A_ROW = 1.5, 3
#: Cells between where the robot was and where it is put.
CARRIED = 5.0
#: The journeys were chosen, among forty drawn, where five particles in a hundred sown anywhere find the robot again
#: nearly nine times in ten: the remedy of the course must not be refused by bad luck. Measured: see `grader`.
SEED, CHOSEN = 3000, (0, 1, 3, 5, 9, 17, 20, 21, 24, 31, 35, 36, 10, 22, 34)
FILMED, EVERY = 60, 2


@cache
def carried_away(number: int) -> Journey:
    """A journey on a map of its own, 12 x 16, interrupted: the robot is somewhere else after step 30.

    The scan of step 30 is the last from the old place; the move of step 31 is one that it makes from the new place.
    """
    rng = np.random.default_rng(SEED + CHOSEN[number])
    grid = GridMap.from_free(world.random_map(rng))
    first = journeys.wander(grid, BEFORE, rng)
    while True:
        start = journeys.roomy_pose(grid, rng)
        if journeys.away(start, first.truth[-1])[0] > CARRIED:
            break
    then = journeys.wander(grid, AFTER, rng, start)
    truth = np.vstack([first.truth, then.truth[1:]])
    return Journey(grid, truth, np.vstack([first.moves, then.moves]), np.vstack([first.scans, then.scans]))


def kit(bench: Bench, number: int) -> KitSettings:
    return world.kit(bench.rng, carried_away(number).map.free)


def play(run: ClosedLoopRun) -> None:
    """Found: three steps in a row near the robot, among the last thirty. Raises Rejection."""
    journey = carried_away(run.number)
    follow = Following(run, journey, jump=BEFORE + 1, kind="kidnappe", filmed=FILMED, every=EVERY)
    cloud = seeded(run.bench, PARTICLES)
    for particles, weights in follow.steps(cloud, np.full(len(cloud), 1.0 / len(cloud))):
        follow.estimate(estimated(run.bench, particles, weights))
        if _found(follow):
            follow.finished(ok=True)
            return
    run.step = 0
    raise _lost(follow)


def gaps(follow: Following) -> Floats:
    """How far each estimate was from the robot."""
    return np.array([journeys.away(pose, truth)[0] for pose, truth in
                     zip(follow.estimates, follow.journey.truth[1:], strict=False)])  # fmt: skip


def _found(follow: Following) -> bool:
    """Are the last three steps near the robot, all of them among the last thirty?"""
    if len(follow.estimates) < BEFORE + AFTER - WINDOW + IN_A_ROW:
        return False
    return bool(np.all(gaps(follow)[-IN_A_ROW:] < NEAR))


def _lost(follow: Following) -> Rejection:
    journey, away = follow.journey, gaps(follow)
    late = away[-WINDOW:]
    before = "avant l'enlèvement, votre filtre le suivait" if away[BEFORE - 1] < NEAR else "il était déjà perdu avant"
    return Rejection(
        f"le robot, enlevé après le pas {BEFORE}, n'est pas retrouvé ({before}). Dans les {WINDOW} derniers pas, votre "
        f"estimation est au mieux à {number(float(late.min()))} case de lui, et {number(float(np.median(late)))} en "
        f"médiane ; il faut {IN_A_ROW} pas de suite à moins de {number(NEAR)} case.",
        inputs={
            "robot au pas 30": journey.truth[BEFORE],
            "robot à la fin": journey.truth[-1],
            "libres": journey.map.free,
        },
        expected=f"{IN_A_ROW} estimations de suite à moins de {number(NEAR)} case du robot, à la fin "
        f"vers {pose_text(journey.truth[-1])}",
        got=follow.estimates[-1],
        figure=run_figure(follow, f"Essai {follow.run.number + 1} : les {AFTER} pas après l'enlèvement", BEFORE + 1),
    )
