"""Films of l20/mcl and l20/defi_kidnappe: the student's cloud on a hidden run, beside a filter of the reference."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.journeys import BEAMS, MOVE_NOISE, away
from graders.scene.replay import (
    Chart,
    Color,
    Frame,
    Grid,
    Key,
    Level,
    Mark,
    Points,
    Pose,
    Rays,
    Replay,
    Series,
    View,
    decimal,
)
from reference.localisation.mcl import InjectionRule, MonteCarloLocalization, uniform_poses
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.grid_map import GridMap
from reference.world.scan import Scan, full_turn_angles

FINE = 4
PARTICLES = 400
#: As the reference of the course's replays: a field of 0.35 cell, the likelihood to the power 0.4.
SIGMA, POWER = 0.35, 0.4
NEAR = {"mcl": 0.7, "kidnappe": 1.5}


class MeasuredMoves:
    """The moves of these runs, as particles need them: the noise that the statement tells, a little larger."""

    state_angles = np.array([False, False, True])

    def __init__(self, sensor: LikelihoodField) -> None:
        self.sensor = sensor

    def sample_motion(self, states: Floats, control: Floats, rng: np.random.Generator) -> Floats:
        forward, side, turn = (control + 1.5 * np.array(MOVE_NOISE) * rng.standard_normal(states.shape)).T
        x, y, heading = states.T
        c, s = np.cos(heading), np.sin(heading)
        return np.column_stack([x + c * forward - s * side, y + s * forward + c * side, heading + turn])

    def log_likelihood(self, states: Floats, measurement: Scan) -> Floats:
        return self.sensor.log_likelihood(states, measurement)


@dataclass
class Reference:
    """What a filter of the reference makes of the same run, from a cloud of its own."""

    estimates: list[Floats] = field(default_factory=list)

    @classmethod
    def on(cls, grid: GridMap, moves: Floats, scans: Floats) -> Reference:
        rng = np.random.default_rng(0)
        sensor = LikelihoodField(fine(grid), sigma=SIGMA, max_range=world.RANGE, power=POWER)
        robot = MonteCarloLocalization(
            fine(grid),
            sensor,
            uniform_poses(grid, PARTICLES, rng),
            rng,
            injection=InjectionRule(0.0, 0.0, 0.05, tries=20),
        )
        robot.model = MeasuredMoves(sensor)
        told = cls()
        for move, ranges in zip(moves, scans, strict=True):
            robot.predict(move)
            robot.correct(Scan(ranges, full_turn_angles(BEAMS), world.RANGE))
            told.estimates.append(robot.clusters()[0].mean)
        return told


def fine(grid: GridMap) -> GridMap:
    """Each cell in sixteen: distances to walls are truer."""
    return GridMap.from_free(np.kron(grid.free, np.ones((FINE, FINE), dtype=bool)), 1.0 / FINE)


def replay(data: dict[str, Any]) -> Replay:
    """The run step by step: the student's cloud, both estimates, the robot, and what its lidar reads."""
    free = np.array([[cell == "." for cell in row] for row in data["free"]])
    truth, moves, scans = (np.array(data[key], dtype=float) for key in ("truth", "moves", "scans"))
    steps = len(data["estimates"])
    told = [np.array(pose, dtype=float) for pose in data["estimates"]]
    reference = Reference.on(GridMap.from_free(free), moves[:steps], scans[:steps]).estimates
    frames = [Frame([_cloud(data, 0), Pose(truth[0], "truth")], "Au départ : le nuage, avant tout scan.", 0)]
    for k in range(1, steps + 1):
        frames.append(
            Frame(
                [_cloud(data, k), _rays(truth[k], scans[k - 1]), Pose(truth[k], "truth"),
                 Pose(reference[k - 1], "second", style="ghost", radius=0.45),
                 Pose(told[k - 1], "estimate", style="ghost", radius=0.55)],
                _caption(data, k, told[k - 1], truth[k]), k,
            )
        )  # fmt: skip
    height, width = free.shape
    return Replay(
        View(0.0, 0.0, float(width), float(height)),
        frames,
        _summary(data, told, reference, truth),
        layers=[Grid(1.0 - free, "walls")],
        charts=[_errors(data, told, reference, truth)],
        legend=[
            Key("dot", "estimate", "vos particules"),
            Key("ring", "estimate", "votre estimation"),
            Key("ring", "second", "estimation du filtre de référence"),
            Key("robot", "truth", "vrai robot"),
            Key("line", "measure", "scan"),
        ],
        period=0.4,
    )


def cells(distance: float | Floats) -> str:
    return f"{decimal(float(distance), 2)} case{'s' * (float(distance) >= 2.0)}"


def _cloud(data: dict[str, Any], k: int) -> Points:
    """The cloud kept after step k, or the last one kept before it."""
    cloud = np.array(data["clouds"][k // data["every"]], dtype=float).reshape(-1, 3) / 100.0
    return Points(cloud[:, :2], "estimate", size=2.2, headings=cloud[:, 2], opacity=0.6)


def _rays(pose: Floats, scan: Floats) -> Rays:
    angles = pose[2] + full_turn_angles(BEAMS)
    ends = pose[:2] + scan[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    return Rays(pose[:2], ends, hits=scan < world.RANGE)


def _caption(data: dict[str, Any], k: int, estimate: Floats, truth: Floats) -> str:
    gap, turn = away(estimate, truth)
    text = f"Pas {k} : votre estimation est à {cells(gap)} du robot, cap à {decimal(float(turn), 2)} rad."
    if k == data["jump"]:
        return f"Pas {k} : on vient de déposer le robot ailleurs, sans rien dire à ses roues."
    return f"{text} Ici le nuage a perdu le robot." if k == data["lost"] else text


def _errors(data: dict[str, Any], told: list[Floats], reference: list[Floats], truth: Floats) -> Chart:
    steps = np.arange(1.0, len(told) + 1.0)
    marks = [Mark(float(data["lost"]), "ici le nuage a perdu le robot")] if data["lost"] is not None else []
    if data["jump"] is not None:
        marks.append(Mark(float(data["jump"]), "enlèvement", "ink"))
    curves: tuple[tuple[str, Color, list[Floats]], ...] = (
        ("vous", "estimate", told),
        ("référence", "second", reference),
    )
    series = [
        Series(label, color, np.minimum([float(away(p, t)[0]) for p, t in zip(poses, truth[1:], strict=False)], 30.0),
               steps)
        for label, color, poses in curves
    ]  # fmt: skip
    return Chart(
        "Distance du vrai robot à l'estimation, en cases", series, "pas", (0.0, None),
        levels=[Level(NEAR[data["kind"]], "il faut moins")], marks=marks,
        cursor=[float(k) for k in range(len(told) + 1)],
    )  # fmt: skip


def _summary(data: dict[str, Any], told: list[Floats], reference: list[Floats], truth: Floats) -> list[str]:
    verdict = "réussi" if data["ok"] else "manqué"
    if not told:
        return [f"Essai {data['number']}, {verdict} : votre programme s'est arrêté avant la première estimation."]
    ends = [float(away(poses[-1], truth[len(poses)])[0]) for poses in (told, reference)]
    texts = [
        f"Essai {data['number']}, {verdict} : après {len(told)} pas, votre estimation est à {cells(ends[0])} "
        f"du robot, celle du filtre de référence à {cells(ends[1])}."
    ]
    if data["lost"] is not None:
        texts.append(f"À partir du pas {data['lost']}, plus aucune de vos particules n'est près du robot.")
    if "needed" in data:  # films of before do not say what their check made of the other runs
        enough = "c'est fait" if data["succeeded"] >= data["needed"] else "il en manque"
        texts.append(f"La vérification demande {data['needed']} essais réussis sur {data['runs']} : {enough}.")
    texts.append("Le filtre de référence part de particules semées partout, et en sème de nouvelles à chaque scan.")
    return texts


REPLAYS = {"mcl": replay, "kidnappe": replay}
