"""Le filtre à particules, sur une carte et depuis un nuage que l'on donne : ce que deux manipulations font calculer."""

from __future__ import annotations

import numpy as np

from curriculum.l20.rejeux._carte import en_cases, pluriel
from curriculum.l20.rejeux.mcl import Story, charts, cloud, since_near, weigh_and_resample
from graders.scene.replay import Frame, Grid, Key, Pose, Replay, View
from reference.localisation.mcl import MonteCarloLocalization
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry
from reference.se2 import relative
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar

RAYS, REACH, SIGMA, FINE = 16, 8.0, 0.1, 4
NOISE = OdometryNoise(0.15, 0.045, 0.15, 0.045)
BEFORE = -0.4
LEGEND = [
    Key("dot", "estimate", "particule (plus grosse : plus de poids)"),
    Key("ring", "estimate", "estimation"),
    Key("robot", "truth", "vrai robot"),
    Key("line", "measure", "scan"),
]


def fine_map(grid: GridMap) -> GridMap:
    """La même carte, chaque case coupée en seize."""
    return GridMap.from_free(np.kron(grid.free, np.ones((FINE, FINE), dtype=bool)), 1.0 / FINE)


def film(
    grid: GridMap, path: np.ndarray, particles: np.ndarray, injection: float, rng: np.random.Generator, begun: str
) -> Replay:
    """Le filtre le long d'un trajet (pas + 1, 3), depuis des particules (n, 3) ; `begun` dit d'où il part."""
    fine = fine_map(grid)
    field = LikelihoodField(fine, sigma=0.35, max_range=REACH, power=0.4)
    robot = MonteCarloLocalization(fine, field, particles, rng, motion=NOISE)
    lidar, story, count = SimulatedLidar.full_turn(RAYS, REACH, SIGMA), Story(), len(particles)
    story.sizes.append((BEFORE, count))
    story.show(0, BEFORE, begun, cloud(robot), Pose(path[0], "truth"))
    for step, truth in enumerate(path):
        if step > 0:
            robot.predict(sample_odometry(np.zeros((1, 3)), relative(path[step - 1], truth), NOISE, rng)[0])
            text = f"Pas {step}, déplacement : chaque particule suit l'odométrie, avec son propre bruit."
            story.show(step, BEFORE, text, cloud(robot, glide=True), Pose(truth, "truth", glide=True))
        weigh_and_resample(story, robot, step, truth, lidar, injection, rng, grid)
    height, width = grid.shape
    return Replay(
        View(0, 0, width, height),
        [Frame(frame.layers, frame.caption, frame.step) for frame in story.frames],
        summary(story, robot, len(path) - 1),
        layers=[Grid(~grid.free, "walls")],
        charts=charts(story, count, robot.threshold, None),
        legend=LEGEND,
        period=0.3,
    )


def summary(story: Story, robot: MonteCarloLocalization, steps: int) -> list[str]:
    since, last = since_near(np.array(story.errors)), story.errors[-1]
    clouds = [one for one in robot.clusters() if one.weight > 0.1]
    again = pluriel(story.resamplings, "rééchantillonnage", "rééchantillonnages")
    texts = [f"{pluriel(steps, 'pas', 'pas')}, {again}."]
    if since is None:
        texts.append(f"Le robot n'est pas retrouvé : l'estimation finit à {en_cases(last)} de lui.")
    else:
        near = f"l'estimation reste à moins d'une case, et finit à {en_cases(last)}"
        texts.append(f"Retrouvé : dès le pas {since}, {near}.")
    if len(clouds) > 1:
        texts.append(f"{len(clouds)} nuages se partagent encore le poids : vu de là, ces endroits se ressemblent.")
    return texts
