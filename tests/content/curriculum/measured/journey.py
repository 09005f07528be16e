"""Part A of the practical work, step by step, with `reference/` in the place of a student's functions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.fichiers import parcours
from reference.metrics import absolute_trajectory_error
from reference.pose_graph import PoseGraph, gauss_newton
from reference.registration import icp
from reference.registration.icp import PairingRule
from reference.se2 import compose, relative, transform, wrap_angle
from reference.world.scan import full_turn_angles
from reference.world.simulation import SimulatedRun

Floats = NDArray[np.float64]

RANGE, NEAR = 8.0, 0.1


@cache
def journey() -> SimulatedRun:
    return parcours.journey()


@dataclass(frozen=True)
class Match:
    """The pose of a scan seen from another, and the share of its points with a neighbour within 10 cm."""

    T_a_b: Floats
    share: float


@cache
def points(scan: int) -> Floats:
    ranges, angles = journey().ranges[scan], full_turn_angles(180)
    return np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])[ranges < RANGE]


@cache
def truth() -> Floats:
    run = journey()
    return np.array([relative(run.truth[0], pose) for pose in run.truth])


@cache
def odometry() -> Floats:
    poses = [np.zeros(3)]
    for left, right in journey().wheels:
        poses.append(compose(poses[-1], journey().drive.pose_increment(left, right)))
    return np.array(poses)


@cache
def keys() -> tuple[int, ...]:
    """The scans 30 cm or 0.4 rad after the one before, by odometry."""
    poses, chosen, path = odometry(), [0], 0.0
    for k in range(1, len(poses)):
        path += float(np.hypot(*(poses[k] - poses[k - 1])[:2]))
        if path >= 0.3 or abs(wrap_angle(float(poses[k, 2] - poses[chosen[-1], 2]))) >= 0.4:
            chosen.append(k)
            path = 0.0
    return tuple(chosen)


def match(a: int, b: int, guess: Floats) -> Match:
    found = icp(points(b), points(a), guess, pairing=PairingRule(max_distance=0.3), max_iterations=30)
    moved = transform(found.T_q_p, points(b))
    away = np.min(np.hypot(*(moved[:, None] - points(a)[None]).transpose(2, 0, 1)), axis=1)
    return Match(found.T_q_p, float(np.mean(away < NEAR)))


@cache
def steps() -> tuple[Match, ...]:
    poses = odometry()
    return tuple(match(a, b, relative(poses[a], poses[b])) for a, b in pairwise(keys()))


@cache
def chain() -> Floats:
    poses = [np.zeros(3)]
    for step in steps():
        poses.append(compose(poses[-1], step.T_a_b))
    return np.array(poses)


@cache
def closures() -> tuple[tuple[int, int, Floats], ...]:
    """The ranks of key poses that are the same place, and what was measured between them."""
    poses, scans = chain(), keys()
    signatures = np.array([np.abs(np.fft.rfft(journey().ranges[k]))[:8] / 180.0 for k in scans])
    found = []
    for j in range(len(scans)):
        for i in range(j - 19):
            alike = np.linalg.norm(signatures[i] - signatures[j]) < 0.15
            if alike and np.hypot(*(poses[i] - poses[j])[:2]) < 1.5:
                made = match(scans[i], scans[j], relative(poses[i], poses[j]))
                if made.share > 0.85:
                    found.append((i, j, made.T_a_b))
    return tuple(found)


def optimised(*, closed: bool = True) -> Floats:
    def weigh(metres: float, radians: float) -> Floats:
        return np.diag([metres**-2.0, metres**-2.0, radians**-2.0])

    poses, scans = odometry(), keys()
    edges = [(k, k + 1, step.T_a_b, weigh(0.02, 0.01)) for k, step in enumerate(steps())]
    for k, (a, b) in enumerate(pairwise(scans)):
        edges.append((k, k + 1, relative(poses[a], poses[b]), weigh(0.03, 0.05)))
    if closed:
        edges += [(i, j, z, weigh(0.03, 0.015)) for i, j, z in closures()]
    return gauss_newton(PoseGraph.from_edges(len(scans), edges), chain(), max_iterations=10).poses


def ate(poses: Floats, *, at_keys: bool = True) -> float:
    true = truth()[list(keys())] if at_keys else truth()
    return absolute_trajectory_error(true, poses).rmse
