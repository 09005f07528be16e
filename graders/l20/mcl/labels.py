"""Words for what one step of a filter shows: where its particles went, what noise they have, what their weights say."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graders.core.contract.values import Floats
from graders.l20 import journeys
from graders.l20.mcl.scenes import Step
from graders.l20.mcl.steps import has_shared_value
from reference.se2 import compose

#: From a scene, and the particles and weights after its step, to a few words.
Label = Callable[[Step, Floats, Floats], str]
#: Different poses in a small heap from which on their noise is looked at.
FEWEST_POSES = 4


def arrivals(pose: Floats, move: Floats) -> dict[str, Floats]:
    """Where the usual mistakes lead from a pose, each by its name."""
    x, y, t = pose
    dx, dy, turn = move
    c, s = np.cos(t), np.sin(t)

    def at(gx: float, gy: float, heading: float = t + turn) -> Floats:
        return np.array([x + gx, y + gy, heading])

    def led(way: float) -> Floats:
        return at(np.cos(way) * dx - np.sin(way) * dy, np.sin(way) * dx + np.cos(way) * dy)

    return {
        "juste": led(t),
        "rotation oubliée": at(dx, dy),
        "rotation inverse": led(-t),
        "échangés": at(s * dx - c * dy, c * dx + s * dy),
        "tourne d'abord": led(t + turn),
        "milieu": led(t + turn / 2.0),
        "sans virage": compose(pose, (dx, dy, 0.0)),
        "virage opposé": compose(pose, (dx, dy, -turn)),
        "sur place": np.array([x, y, t]),
        "sans dy": at(c * dx, s * dx),
        "dy opposé": at(c * dx + s * dy, s * dx - c * dy),
        "un signe": at(c * dx + s * dy, s * dx + c * dy),
        "à l'envers": at(-c * dx + s * dy, -s * dx - c * dy),
        "retranché": compose(pose, (-dx, -dy, -turn)),
    }


def where(scene: Step, particles: Floats, weights: Floats) -> str:
    """The mistake that leads nearest to the middle of the particles, and what noise they have."""
    place = np.median(particles[:, :2], axis=0)
    particles = particles[np.hypot(*(particles[:, :2] - place).T) < 2.0]  # some filters sow a few elsewhere
    if len(particles) == 0:
        return "dispersées partout"
    middle = np.array([*particles[:, :2].mean(axis=0), np.angle(np.exp(1j * particles[:, 2]).mean())])
    nearest, gap = nearest_arrival(scene.particles[0], scene.move, middle)
    return f"{nearest if gap < 0.4 else 'ailleurs'}, {noise(particles, gap)}"


def nearest_arrival(pose: Floats, move: Floats, end: Floats) -> tuple[str, float]:
    """Return the mistake that leads nearest to a pose, and the gap left, in cells and radians added."""
    gaps = {name: float(np.add(*journeys.away(end, place))) for name, place in arrivals(pose, move).items()}
    nearest = min(gaps, key=lambda name: gaps[name])
    return nearest, gaps[nearest]


def noise(particles: Floats, gap: float) -> str:
    """What noise a heap has, which stands at this gap from where a mistake leads without any."""
    if np.all(np.ptp(particles, axis=0) < 1e-9):
        return "sans bruit" if gap < 1e-9 else "même bruit"
    _, poses = np.unique(np.round(particles, 9), axis=0, return_inverse=True)
    same = [has_shared_value(particles[:, k], poses, FEWEST_POSES) for k in range(3)]
    return "même cap" if same[2] else "même place" if all(same[:2]) else "dispersées"


def winner(scene: Step, particles: Floats, weights: Floats) -> str:
    """Whether the first of two groups has the weight, the second, or neither."""
    there, other = (compose(scene.particles[k], scene.move) for k in (0, -1))
    gaps = [np.add(*journeys.away(particles, place)) for place in (there, other)]
    share = float(weights[gaps[0] < gaps[1]].sum() / weights.sum())
    return "le bon" if share > 0.8 else "l'autre" if share < 0.2 else "aucun"


def left(scene: Step, particles: Floats, weights: Floats) -> str:
    """What becomes of three quarters of the weight, when the scan tells nothing."""
    share = float(weights[particles[:, 0] < 18.5].sum() / weights.sum())
    return "doublé" if share > 0.93 else "gardé" if share > 0.63 else "oublié" if share > 0.15 else "inversé"


def copied(scene: Step, particles: Floats, weights: Floats) -> str:
    """Whether the few that explain the scan are copied, and what the copies weigh."""
    share = float(np.mean(particles[:, 0] > 9.0))
    even = float(1.0 / np.sum((weights / weights.sum()) ** 2) / len(weights)) > 0.6
    rows = len(np.unique(np.round(particles, 9), axis=0))
    ancestors = "une seule copiée" if rows <= 2 else "copiées"
    others = "gardées" if rows > 0.9 * len(particles) else "tirées"
    return f"{ancestors if share > 0.6 else others}, poids {'égaux' if even else 'inégaux'}"


def repeated(scene: Step, particles: Floats, weights: Floats) -> str:
    """Whether equally likely particles are drawn again, and how."""
    distinct = len(np.unique(np.round(particles, 9), axis=0)) / len(particles)
    return "une seule" if distinct < 0.05 else "quelques-unes" if distinct < 0.9 else "toutes"


def summed(scene: Step, particles: Floats, weights: Floats) -> str:
    """The sum of weights when no resampling hides it."""
    total = float(weights.sum())
    return "somme 1" if abs(total - 1.0) < 1e-6 else "autre somme"
