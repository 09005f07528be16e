"""The hidden runs of l20/mcl: the same journeys for everybody, what a filter makes of them, and what is kept of it.

How often an honest filter succeeds was measured on the right programs of `specimens/ok` and on weaker ones, 20 times
each run (`tests/content/graders/l20/test_mcl.py`, slow, does it again): see the docstring of `grader`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache, partial

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.loops import ClosedLoopRun
from graders.core.contract.findings import FigureData
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Floats
from graders.l20 import journeys, world
from graders.l20.journeys import Journey
from graders.l20.mcl.answers import estimated, seeded, stepped
from graders.l20.mcl.telling import number, pose_text
from reference.world.grid_map import GridMap

RUNS = 8
TRACKED, FOUND = 6, 3
PARTICLES, GOOD = 500, 100
STEPS, STEPS_FROM_NOWHERE = 30, 20
NEAR, TURNED = 0.7, 0.4
#: The good particles at the start: standard deviations, in cells and in radians.
START = (0.3, 0.15)
TRACKING_SEED, GLOBAL_SEED = 1000, 2000
#: The small maps on which four honest filters found the robot fifteen times in sixteen at least, among 22 drawn.
CHOSEN = (3, 4, 19, 20, 0, 12, 13, 17)
#: Of a film: particles a step, and how far from the robot, in cells and radians, a particle still holds it.
FILMED, HOLDS, SOME = 90, (1.5, 0.6), 0.02


@cache
def tracking(number: int) -> tuple[Journey, Floats]:
    """A journey on the module's map, and a cloud of which 100 particles of 500 are near its start."""
    rng = np.random.default_rng(TRACKING_SEED + number)
    journey = journeys.wander(journeys.module_map(), STEPS, rng)
    good = journeys.around(journey.truth[0], GOOD, START, rng)
    return journey, np.vstack([good, journeys.scattered(journey.map, PARTICLES - GOOD, rng)])


@cache
def from_nowhere(number: int) -> Journey:
    """A journey on a small map of its own, 7 x 9."""
    rng = np.random.default_rng(GLOBAL_SEED + CHOSEN[number])
    return journeys.wander(GridMap.from_free(world.random_map(rng, 7, 9)), STEPS_FROM_NOWHERE, rng)


def kit_of_tracking(bench: Bench, number: int) -> KitSettings:
    return world.kit(bench.rng)


def kit_from_nowhere(bench: Bench, number: int) -> KitSettings:
    return world.kit(bench.rng, from_nowhere(number).map.free)


def play_tracking(run: ClosedLoopRun) -> None:
    journey, cloud = tracking(run.number)
    _play(run, journey, cloud)


def play_from_nowhere(run: ClosedLoopRun) -> None:
    _play(run, from_nowhere(run.number), seeded(run.bench, PARTICLES))


def _play(run: ClosedLoopRun, journey: Journey, cloud: Floats) -> None:
    """The filter follows a journey to its end, where its estimate must be near the robot. Raises Rejection."""
    follow = Following(run, journey)
    for particles, weights in follow.steps(cloud, np.full(len(cloud), 1.0 / len(cloud))):
        follow.estimate(estimated(run.bench, particles, weights))
    run.step = 0
    gap, turn = journeys.away(follow.estimates[-1], journey.truth[-1])
    follow.finished(ok=bool(gap <= NEAR and turn <= TURNED))
    if gap > NEAR or turn > TURNED:
        raise _lost(follow, float(gap), float(turn))


@dataclass
class Following:
    """A filter on a journey: its estimates, and what is kept of its clouds for a film."""

    run: ClosedLoopRun
    journey: Journey
    jump: int | None = None
    estimates: list[Floats] = field(default_factory=list)
    holding: list[float] = field(default_factory=list)
    clouds: list[list[int]] = field(default_factory=list)
    particles: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    kind: str = "mcl"
    filmed: int = FILMED
    every: int = 1

    def steps(self, particles: Floats, weights: Floats) -> Iterator[tuple[Floats, Floats]]:
        """The cloud after each step."""
        self._keep(particles, weights, 0)
        for k, (move, scan) in enumerate(zip(self.journey.moves, self.journey.scans, strict=True)):
            self.run.step = k + 1
            args = {"particules": particles, "poids": weights, "u": move, "scan": scan}
            particles, weights = stepped(self.run.bench, args)
            self._keep(particles, weights, k + 1)
            yield particles, weights

    def estimate(self, pose: Floats) -> None:
        self.estimates.append(pose)
        self.run.make_film = partial(self._film, ok=False)

    def finished(self, *, ok: bool) -> None:
        self.run.make_film = partial(self._film, ok=ok)

    @property
    def lost_at(self) -> int | None:
        """The step after which the cloud held the robot no more; None while it does."""
        held = [k for k, share in enumerate(self.holding) if share >= SOME]
        last = held[-1] if held else -1
        return None if last == len(self.holding) - 1 else last + 1

    def _keep(self, particles: Floats, weights: Floats, k: int) -> None:
        self.particles = particles
        gap, turn = journeys.away(particles, self.journey.truth[k])
        self.holding.append(float(weights[(gap < HOLDS[0]) & (turn < HOLDS[1])].sum()))
        if k % self.every:
            return
        shown = particles[np.linspace(0, len(particles) - 1, min(self.filmed, len(particles))).astype(int)]
        shown = np.clip(np.column_stack([shown[:, :2], np.remainder(shown[:, 2] + np.pi, 2 * np.pi) - np.pi]), -99, 99)
        self.clouds.append(np.round(100.0 * shown).astype(int).ravel().tolist())

    def _film(self, *, ok: bool) -> FigureData:
        """Plain values; lengths and angles of the clouds in hundredths, to be short."""
        return {
            "kind": self.kind,
            "every": self.every,
            "number": self.run.number + 1,
            "ok": ok,
            "free": ["".join(".#"[not cell] for cell in row) for row in self.journey.map.free],
            "truth": np.round(self.journey.truth, 3).tolist(),
            "moves": np.round(self.journey.moves, 3).tolist(),
            "scans": np.round(self.journey.scans, 2).tolist(),
            "clouds": self.clouds,
            "estimates": [np.round(np.clip(pose, -99.0, 99.0), 3).tolist() for pose in self.estimates],
            "lost": None if ok else self.lost_at,
            "jump": self.jump,
        }


def _lost(follow: Following, gap: float, turn: float) -> Rejection:
    truth, estimate = follow.journey.truth[-1], follow.estimates[-1]
    far = f"à {number(gap)} case de lui" if gap > NEAR else f"près de lui, mais le cap est faux de {number(turn)} rad"
    when = "" if not follow.lost_at else f" Plus aucune particule n'est près de lui depuis le pas {follow.lost_at}."
    return Rejection(
        f"au bout de {len(follow.journey)} pas, le robot est en {pose_text(truth)}, et votre estimation, "
        f"{pose_text(estimate)}, "
        f"est {far}.{when}",
        inputs={
            "départ du robot": follow.journey.truth[0],
            "pas": len(follow.journey),
            "libres": follow.journey.map.free,
        },
        expected=f"une estimation à moins de {number(NEAR)} case et de {number(TURNED)} rad de {pose_text(truth)}",
        got=estimate,
        figure=run_figure(follow, f"Essai {follow.run.number + 1} : le trajet, et votre nuage à la fin"),
    )


def run_figure(follow: Following, title: str, since: int = 0) -> FigureData:
    """The way of the robot and of the estimates from a step on, and the cloud at the end."""
    cloud = follow.particles
    return {
        "kind": "run",
        "free": follow.journey.map.free,
        "path": np.round(follow.journey.truth[since:, :2], 3),
        "truth": follow.journey.truth[-1],
        "estimates": np.round(np.array(follow.estimates)[max(since - 1, 0) :, :2], 3),
        "estimate": follow.estimates[-1],
        "after": np.round(cloud[:: max(1, -(-len(cloud) // 120))], 3),
        "title": title,
    }
