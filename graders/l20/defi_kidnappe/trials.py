"""What a few steps show of a filter whose robot is carried away: it keeps weights, and looks elsewhere."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Floats
from graders.l20 import journeys
from graders.l20.defi_kidnappe import runs
from graders.l20.mcl.answers import MOST, STEP, seeded, stepped
from graders.l20.mcl.runs import PARTICLES
from graders.l20.mcl.scenes import ALWAYS, SPREAD, Step, judged, scan_of, step
from graders.l20.mcl.steps import plain_steps
from graders.l20.mcl.telling import cloud_figure, number, observed, pose_text
from graders.l20.world import RANGE

LARGE = (120, 100, 200)
COUNT, CALM, LOST_SCANS = 200, 5, 15
FAR = 3.0
HERE, THERE = np.array([3.6, 3.4, 0.6]), np.array([19.4, 11.3, -2.0])


@cache
def astray() -> tuple[Step, ...]:
    """Clouds in a room where the robot is not: the scans of three other rooms."""
    rng = np.random.default_rng(ALWAYS)
    cloud = journeys.around(HERE, COUNT, SPREAD, rng)
    even = np.full(COUNT, 1.0 / COUNT)
    return tuple(
        Step(cloud, even, np.array([0.3, 0.0, 0.1]), scan_of(journeys.module_map(), np.array(pose), RANGE, rng),
             np.array(pose))
        for pose in ((11.5, 7.9, 0.0), (19.4, 11.3, -2.0), (22.3, 14.4, 2.5))
    )  # fmt: skip


@observed(STEP)
def well_formed(bench: Bench) -> None:
    """Particles (n, 3), and weights of sum 1; a cloud that grows at each step makes a whole journey.

    The clouds are large: some filters always sow the same number anew.
    """
    grown = [len(stepped(bench, scene.inputs)[0]) > len(scene.particles) for scene in plain_steps(LARGE)]
    if all(grown):
        with bench.run_with_kit(runs.kit(bench, 0)) as own:
            _stays_below_the_most(own)


def _stays_below_the_most(bench: Bench) -> None:
    """The first hidden run, to its last step, for as long as the cloud grows at each step. Raises Rejection.

    The hidden runs stop when the robot is found, before most clouds without end are too large.
    """
    journey = runs.carried_away(0)
    particles = seeded(bench, PARTICLES)
    weights = np.full(len(particles), 1.0 / len(particles))
    for k, (move, scan) in enumerate(zip(journey.moves, journey.scans, strict=True)):
        try:
            args = {"particules": particles, "poids": weights, "u": move, "scan": scan}
            after, weights = stepped(bench, args)
        except Rejection as found:
            raise Rejection(
                f"Le premier essai part de initialiser({PARTICLES}) ; votre nuage y grossit à chaque pas. Au pas "
                f"{k + 1} sur {len(journey)}, {found.message}",
                inputs={"n": PARTICLES, "pas": k + 1},
                expected=f"{MOST} particules au plus, et leurs poids de somme 1",
                got=found.got,
                slip=found.slip,
                cause=found.cause,
            ) from found
        if len(after) <= len(particles):
            return
        particles = after


@observed(STEP)
def survives_being_lost(bench: Bench) -> None:
    """The weights of a cloud that explains nothing are still weights."""
    for scene in astray():
        stepped(bench, scene.inputs)


@cache
def carried() -> tuple[Step, Floats]:
    """A cloud around a robot at rest, its first scans, then those of another room."""
    rng = np.random.default_rng(ALWAYS)
    calm = step(rng, [(HERE.tolist(), COUNT)], (0.0, 0.0, 0.0))
    scans = np.vstack(
        [journeys.read(journeys.module_map(), np.tile(pose, (count, 1)), rng)
         for pose, count in ((HERE, CALM), (THERE, LOST_SCANS))]
    )  # fmt: skip
    return calm, scans


@observed(STEP)
def looks_elsewhere(bench: Bench) -> None:
    """Some particle, at some step after the robot was carried away, is far from where it was."""
    judged(bench, _looks_elsewhere)


def _looks_elsewhere(bench: Bench) -> None:
    calm, scans = carried()
    particles, weights = calm.particles, calm.weights
    furthest = 0.0
    for k, scan in enumerate(scans):
        particles, weights = stepped(bench, {"particules": particles, "poids": weights, "u": calm.move, "scan": scan})
        gaps = np.hypot(*(particles[weights > 0.0][:, :2] - HERE[:2]).T)
        furthest = max(furthest, float(gaps.max())) if k >= CALM else 0.0
        if furthest > FAR:
            return
    raise Rejection(
        f"Le robot reste en {pose_text(HERE)} pendant {CALM} scans, puis on le pose en {pose_text(THERE)}. Après "
        f"{LOST_SCANS} scans de là-bas, aucune particule qui ait un poids ne s'est trouvée à plus de "
        f"{number(furthest)} case de l'ancienne place : votre filtre ne peut pas retrouver le robot.",
        inputs={"particules": calm.particles, "poids": calm.weights, "u": calm.move, "scans": len(scans)},
        expected="quelques particules semées ailleurs",
        got=particles[:8],
        figure=cloud_figure(journeys.module_map().free, replace(calm, truth=THERE), particles, "Quinze scans après"),
    )
