"""The trials of `pas_mcl`: what one step shows, and a few; the scenes are always the same, only the program draws."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Arguments, Floats
from graders.l20 import journeys
from graders.l20.mcl.answers import ESTIMATE, STEP, stepped
from graders.l20.mcl.scenes import ALWAYS, HALL, Step, hall_kit, in_the_hall, judged, share_near, step
from graders.l20.mcl.telling import cloud_figure, number, observed, pose_text
from reference.se2 import compose, relative

MANY, HALF = 400, 200
FEWEST_DISTINCT = 10
#: Cells from the middle of a cloud beyond which a particle was sown anew.
FAR = 3.0
NEAR_PLACE, NEAR_HEADING = 0.3, 0.2
WINS, FILLS = 0.6, 0.7
STILL_SCANS = 8


@cache
def plain_steps(counts: tuple[int, int, int] = (40, 7, 200)) -> tuple[Step, ...]:
    """Clouds of so many particles, with unequal weights, in which a good part is near the robot."""
    rng = np.random.default_rng(ALWAYS)
    steps = []
    for pose, count in zip(((3.4, 3.2, 0.7), (19.6, 4.4, -2.0), (11.5, 7.9, 2.9)), counts, strict=True):
        made = step(rng, [(pose, count)], (0.5, 0.1, 0.2), spread=(0.25, 0.1))
        weights = rng.uniform(0.5, 1.5, count)
        steps.append(replace(made, weights=weights / weights.sum()))
    return tuple(steps)


@observed(STEP)
def well_formed(bench: Bench) -> None:
    """Particles (n, 3), and weights of sum 1."""
    for scene in plain_steps():
        stepped(bench, scene.inputs)


HEADINGS_AND_MOVES = (
    ((20.0, 5.0, 0.4), (0.9, 0.3, 0.8)),
    ((18.0, 4.5, 2.2), (0.8, -0.4, -0.7)),
    ((22.0, 4.5, -2.5), (-0.6, 0.6, 0.6)),
    ((19.0, 5.0, -0.9), (0.1, 0.9, -0.9)),
    ((21.0, 4.5, 1.1), (0.9, 0.0, 0.0)),
)


@cache
def heaps() -> tuple[Step, ...]:
    """All the particles at the very place of the robot, in the hall, which moves."""
    rng = np.random.default_rng(ALWAYS)
    return tuple(step(rng, [(pose, MANY)], move, in_hall=True, spread=(0.0, 0.0)) for pose, move in HEADINGS_AND_MOVES)


@observed(STEP)
def moved(bench: Bench) -> None:
    """On average, the particles make the move that the wheels told."""
    with in_the_hall(bench) as hall:
        for scene in heaps():
            judged(hall, partial(_moves, scene), hall_kit)


def _moves(scene: Step, bench: Bench) -> None:
    particles, weights = stepped(bench, scene.inputs)
    middle = _middle(particles, weights)
    gap, turn = journeys.away(middle, scene.truth)
    if gap > NEAR_PLACE or turn > NEAR_HEADING:
        raise _badly_moved(scene, particles, middle)


def _badly_moved(scene: Step, particles: Floats, mean: Floats) -> Rejection:
    return Rejection(
        f"{len(scene.particles)} particules confondues en {pose_text(scene.particles[0])} font le pas u = "
        f"{pose_text(scene.move)} : leur moyenne doit arriver près de {pose_text(scene.truth)}, elle est en "
        f"{pose_text(mean)}.",
        inputs={"une particule (toutes les mêmes)": scene.particles[0], "u": scene.move, "scan": scene.scan},
        expected=scene.truth,
        got=mean,
        figure=cloud_figure(HALL, scene, particles, "Un pas de particules confondues"),
    )


@observed(STEP)
def dispersed(bench: Bench) -> None:
    """Particles that were the same are no more, neither in place nor in heading."""
    with in_the_hall(bench) as hall:
        for scene in (*heaps()[:2], heaps()[-1]):  # the last one neither sideways nor turning: noise comes there too
            judged(hall, partial(_disperses, scene), hall_kit)


#: Beside the truth, half of the particles within this, in cells and radians: ten times the noise of the wheels.
WIDE = 0.35
#: What particles that were the same may still share: the step forward or aside is that of their own frame.
SAME = ("le même cap", "le même x", "le même y", "le même pas vers l'avant", "le même pas de côté")


#: Of the particles near the robot, and of their different poses, the share that makes a value theirs: some filters sow
#: a few poses of a table among them, whose headings or places are alike.
MOST_PARTICLES, MOST_POSES = 0.7, 0.5


def has_shared_value(values: Floats, poses: NDArray[np.signedinteger], fewest: int) -> bool:
    """Whether most particles have the same value to 1e-6, and not as copies of a few poses.

    `values` (n,) of the particles, `poses` (n,) the number of the pose of each; a cloud of fewer than `fewest` poses
    shares a value only where all of it does.
    """
    same = np.abs(values - np.median(values)) < 1e-6
    distinct, sharing = len(np.unique(poses)), len(np.unique(poses[same]))
    if distinct < fewest:
        return bool(same.all())
    return bool(same.mean() > MOST_PARTICLES) and sharing >= max(fewest, MOST_POSES * distinct)


def _disperses(scene: Step, bench: Bench) -> None:
    """What a filter that sows anew adds here and there is no noise: the particles near the robot are looked at."""
    particles, weights = stepped(bench, scene.inputs)
    close = np.hypot(*(particles[:, :2] - scene.truth[:2]).T) < FAR
    near = particles[close]
    unique, poses = np.unique(np.round(near, 9), axis=0, return_inverse=True)
    distinct, steps = len(unique), relative(scene.particles[:1], near)
    columns = (near[:, 2], near[:, 0], near[:, 1], steps[:, 0], steps[:, 1])
    shared = (distinct > 0 and has_shared_value(it, poses, FEWEST_DISTINCT) for it in columns)
    frozen = next((name for name, it in zip(SAME, shared, strict=True) if it), None)
    if distinct >= FEWEST_DISTINCT and frozen is None:
        _not_too_much(scene, particles, relative(scene.truth, near), weights[close])
        return
    now = f"{distinct} poses différentes" if frozen is None else frozen if distinct > 1 else "la même pose"
    how_many = "toutes" if frozen is None or np.ptp(columns[SAME.index(frozen)]) < 1e-6 else "pour la plupart"
    raise Rejection(
        f"{len(scene.particles)} particules confondues font un pas : elles ont encore {how_many} {now}. Sans un "
        "bruit tiré pour chacune, les copies d'une particule restent confondues pour toujours."
        if frozen
        else f"{len(scene.particles)} particules confondues font un pas : il n'en reste près du robot que {now}.",
        inputs={"une particule (toutes les mêmes)": scene.particles[0], "u": scene.move, "scan": scene.scan},
        expected="des particules dispersées, en position et en cap",
        got=particles[:6],
        figure=cloud_figure(HALL, scene, particles, "Un pas de particules confondues"),
    )


_TOO_NOISY = (
    "L'écart-type des roues est de {} : un bruit bien plus grand éparpille le nuage plus vite que les scans ne le "
    "resserrent."
)
_MISPLACED = "Ce n'est pas leur bruit : elles restent groupées, mais loin de l'endroit où ce pas mène."


def _not_too_much(scene: Step, particles: Floats, gaps: Floats, weights: Floats) -> None:
    """Refuse particles far from the truth; the hall teaches nothing there: they lie as move and noise put them."""
    axes = ("case vers l'avant", "case de côté", "radian")
    for k, (axis, usual) in enumerate(zip(axes, ("0,05 case", "0,05 case", "0,03 rad"), strict=True)):
        half = _median(np.abs(gaps[:, k]), weights)
        if half > WIDE:
            apart = _median(np.abs(gaps[:, k] - _median(gaps[:, k], weights)), weights)
            noisy = apart > WIDE / 2
            raise Rejection(
                f"{len(scene.particles)} particules confondues font un pas : la moitié d'entre elles se trompent de "
                f"plus de {number(half)} {axis}. {_TOO_NOISY.format(usual) if noisy else _MISPLACED}",
                inputs={"une particule (toutes les mêmes)": scene.particles[0], "u": scene.move, "scan": scene.scan},
                expected="un bruit de l'ordre de celui des roues, ou un peu plus" if noisy else scene.truth,
                got=particles[:6],
                figure=cloud_figure(HALL, scene, particles, "Un pas de particules confondues"),
            )


#: Where the robot is, where it is not, and its move. The last but two is the one where the robot arrives; in the last
#: two it turns on the spot, and nothing but the order of the rays tells its heading.
DOUBTS = (
    ((3.4, 3.2, 0.4), (11.2, 3.6, 0.4), (0.3, 0.0, 0.1)),
    ((3.0, 2.5, 0.3), (3.0, 2.5, 0.3 + np.pi / 2.0), (0.3, 0.0, 0.1)),
    ((2.6, 2.2, 0.5), (2.6, 4.8, np.pi / 18.0 - 0.5), (0.3, 0.0, 0.1)),
    ((17.6, 2.4, -0.6), (17.6, 2.4, np.pi - 0.6), (0.3, 0.0, 0.1)),
    ((13.2, 12.3, 2.0), (3.0, 10.7, 2.0), (0.3, 0.0, 0.1)),
    ((9.6, 2.4, 0.2), (11.1, 2.704, 0.9), (1.6, 0.0, 0.7)),
    ((3.0, 2.5, 0.3), (3.0, 2.5, 0.3 + np.pi / 2.0), (0.0, 0.0, 0.1)),
    ((17.6, 2.4, -0.6), (17.6, 2.4, np.pi - 0.6), (0.0, 0.0, 0.1)),
)


@cache
def doubts() -> tuple[Step, ...]:
    """Half of the particles where the robot is, half elsewhere: in another room, turned, mirrored, ahead of it."""
    rng = np.random.default_rng(ALWAYS)
    return tuple(step(rng, [(there, HALF), (elsewhere, HALF)], move) for there, elsewhere, move in DOUBTS)


@observed(STEP)
def won(bench: Bench) -> None:
    """The cloud that explains the scan gets the weight."""
    for scene, (_, elsewhere, _) in zip(doubts(), DOUBTS, strict=True):
        judged(bench, partial(_wins, scene, elsewhere))


def _wins(scene: Step, elsewhere: tuple[float, float, float], bench: Bench) -> None:
    particles, weights = stepped(bench, scene.inputs)
    other = compose(elsewhere, scene.move)
    share = float(weights[_nearer(particles, scene.truth, other)].sum())
    if share < WINS:
        raise Rejection(
            f"La moitié des particules est là où est le robot, l'autre moitié près de {pose_text(other)}. "
            "Le scan vient "
            f"de {pose_text(scene.truth)} : ces particules doivent l'emporter, et elles n'ont que "
            f"{number(100 * share)} % "
            "du poids.",
            inputs=scene.inputs,
            expected=f"plus de {100 * WINS:.0f} % du poids près de {pose_text(scene.truth)}",
            got=f"{number(100 * share)} %",
            figure=cloud_figure(journeys.module_map().free, scene, particles, "Deux nuages, un scan", other, weights),
        )


def _nearer(particles: Floats, pose: Floats, other: Floats) -> NDArray[np.bool_]:
    """Which particles are nearer to one pose than to another, a radian counting as a cell."""
    one, two = (np.add(*journeys.away(particles, place)) for place in (pose, other))
    return np.asarray(one < two)


@cache
def still() -> tuple[Step, Floats]:
    """A hundred particles near a robot that stays, 300 anywhere, and its scans."""
    rng = np.random.default_rng(ALWAYS)
    pose = np.array([12.2, 10.9, 0.6])
    cloud = np.vstack(
        [journeys.around(pose, 100, (0.2, 0.1), rng), journeys.scattered(journeys.module_map(), 300, rng)]
    )
    scans = journeys.read(journeys.module_map(), np.tile(pose, (STILL_SCANS, 1)), rng)
    return Step(cloud, np.full(len(cloud), 1.0 / len(cloud)), np.zeros(3), scans[0], pose), scans


@observed(STEP)
def filled(bench: Bench) -> None:
    """After eight scans of a robot that stays, the particles are where it is."""
    judged(bench, _fills)


def _fills(bench: Bench) -> None:
    scene, scans = still()
    particles, weights = scene.particles, scene.weights
    for scan in scans:
        particles, weights = stepped(bench, {"particules": particles, "poids": weights, "u": np.zeros(3), "scan": scan})
    even = np.full(len(particles), 1.0 / len(particles))
    share, weight = (share_near(particles, column, scene.truth.tolist()) for column in (even, weights))
    if min(share, weight) < FILLS:
        raise Rejection(
            f"Le robot reste en {pose_text(scene.truth)} pendant {STILL_SCANS} scans. Un quart des particules y "
            "était au "
            f"départ ; à la fin, elles ne sont que {number(100 * share)} %, avec {number(100 * weight)} % du poids. Le "
            "rééchantillonnage doit y ramener presque tout le nuage.",
            inputs={"particules": scene.particles, "poids": scene.weights, "u": scene.move, "scans": len(scans)},
            expected=f"plus de {100 * FILLS:.0f} % des particules, et du poids, près du robot",
            got=f"{number(100 * share)} % des particules, {number(100 * weight)} % du poids",
            figure=cloud_figure(
                journeys.module_map().free, scene, particles, "Après huit scans à l'arrêt", weights=weights
            ),
        )


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    scene = step(rng, [((3.4, 3.2, 0.7), 15), ((11.0, 3.5, 3.1), 45)], (0.5, 0.1, 0.2))
    return {STEP: scene.args, ESTIMATE: (scene.particles, scene.weights)}


def _middle(particles: Floats, weights: Floats) -> Floats:
    """The median place, and the mean heading around it: a few particles sown elsewhere do not move it."""
    place = np.array([_median(particles[:, k], weights) for k in (0, 1)])
    near = np.hypot(*(particles[:, :2] - place).T) < FAR
    return np.array([*place, np.angle(np.dot(weights[near], np.exp(1j * particles[near, 2])))])


def _median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    cumulated = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(cumulated, 0.5 * cumulated[-1])])
