"""The trials of `estimer`: clouds on which the mean and the heaviest particle agree."""

from __future__ import annotations

from functools import cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Arguments, Floats
from graders.l20 import journeys
from graders.l20.mcl.answers import ESTIMATE, estimated
from graders.l20.mcl.scenes import ALWAYS, SPREAD
from graders.l20.mcl.telling import number, observed, pose_text

#: Offsets of a symmetrical cloud and their weights, greatest in the middle: its mean is its heaviest particle.
_OFFSETS = np.array([(dx, dy, dt) for dx in (-0.2, 0.0, 0.2) for dy in (-0.1, 0.0, 0.1) for dt in (-0.3, 0.0, 0.3)])
_PEAKED = np.exp(-np.sum((_OFFSETS / (0.2, 0.1, 0.3)) ** 2, axis=1))


def peaked(x: float, y: float, heading: float) -> Arguments:
    """A cloud (27, 3) around a pose, with its weights, headings in ]-pi, pi]."""
    cloud = _OFFSETS + np.array([x, y, heading])
    cloud[:, 2] = np.pi - (np.pi - cloud[:, 2]) % (2.0 * np.pi)
    return cloud, _PEAKED / _PEAKED.sum()


AROUND_PI = ((5.25, 3.4, 3.1), (12.4, 7.7, -3.0), (2.6, 12.3, np.pi), (9.3, 2.4, -1.2), (17.6, 4.3, 0.1))


@observed(ESTIMATE)
def averaged(bench: Bench) -> None:
    """The middle of a symmetrical cloud, whose headings may lie on both sides of half a turn."""
    for pose in AROUND_PI:
        require_estimate_near(bench, peaked(*pose), np.array(pose), 0.15, 0.15, "le milieu du nuage")


HEAVY, LIGHT = np.array([4.4, 2.6, 0.9]), np.array([6.4, 4.6, 0.1])


@cache
def uneven() -> Arguments:
    """Forty particles that weigh nine tenths, beside 160 light ones."""
    return heavy_beside_light(LIGHT, 160)


def heavy_beside_light(light: Floats, count: int) -> Arguments:
    """Forty particles that weigh nine tenths, HEAVY in their middle the heaviest, beside `count` around a `light` pose.

    The cloud (40 + count, 3) and its weights; the heavy ones stand in the middle of the list.
    """
    rng = np.random.default_rng(ALWAYS)
    cloud = np.vstack([HEAVY, journeys.around(HEAVY, 39, SPREAD, rng), journeys.around(light, count, SPREAD, rng)])
    weights = np.concatenate([[0.06], np.full(39, 0.84 / 39), np.full(count, 0.1 / count)])
    return np.roll(cloud, count // 2, axis=0), np.roll(weights, count // 2)


@observed(ESTIMATE)
def weighed(bench: Bench) -> None:
    """Nine tenths of the weight are on a fifth of the particles."""
    require_estimate_near_weight(bench, uneven())


def require_estimate_near_weight(bench: Bench, cloud: Arguments) -> None:
    """Refuse an estimate away from HEAVY, around which the weight is. Raises Rejection."""
    require_estimate_near(bench, cloud, HEAVY, 0.55, 0.35, "un endroit proche des particules qui ont le poids")


def require_estimate_near(bench: Bench, cloud: Arguments, pose: Floats, near: float, turned: float, words: str) -> None:
    """Refuse an estimate further from a pose than `near` cells or `turned` radians.

    `words` call the place in French. Raises Rejection.
    """
    estimate = estimated(bench, *cloud)
    gap, turn = journeys.away(estimate, pose)
    if gap <= near and turn <= turned:
        return
    part = (
        f"elle est à {number(float(gap))} case de là" if gap > near else f"son cap en est à {number(float(turn))} rad"
    )
    raise Rejection(
        f"{len(cloud[0])} particules autour de {pose_text(pose)} : {ESTIMATE} renvoie {pose_text(estimate)}, et "
        f"{part}.",
        inputs={"particules": cloud[0], "poids": cloud[1]},
        expected=f"{words}, près de {pose_text(pose)}",
        got=estimate,
        slip="degres" if _in_degrees(estimate[2], pose[2], turned) else None,
        figure={
            "kind": "cloud", "free": journeys.module_map().free, "after": cloud[0], "weights": cloud[1],
            "truth": pose, "estimate": estimate, "title": "Le nuage donné, et votre estimation",
        },
    )  # fmt: skip


def _in_degrees(heading: float, expected: float, turned: float) -> bool:
    return bool(abs(heading) > 2.0 * np.pi and abs(np.radians(heading) - expected) <= turned)
