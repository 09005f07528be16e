"""What is asked by hand: as in l20/mcl, and the scans of a robot carried away, the same cloud being given each time."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import ProbeResults, Probes, measurement_rule
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20.mcl.answers import STEP, read_cloud
from graders.l20.mcl.probes import CORNER, hall_lidar
from graders.l20.mcl.probes import PROBES as OF_MCL
from graders.l20.mcl.scenes import ALWAYS, HALL_KIT, HALL_RANGE, hall, scan_of, step

RNG = np.random.default_rng(ALWAYS)
NOBODY, WEIGHTLESS = "personne ailleurs", "ailleurs, sans poids"
HERE, COUNT, FAR = (20.0, 5.0, 0.3), 60, 4.0
CALM = step(RNG, [(HERE, COUNT)], (0.0, 0.0, 0.0), in_hall=True)
STRANGE = [scan_of(hall(), np.array(CORNER), HALL_RANGE, RNG) for _ in range(8)]
CALLS: tuple[Arguments, ...] = (
    CALM.args,
    CALM.args,
    *((CALM.particles, CALM.weights, CALM.move, scan) for scan in STRANGE),
)


def read(args: Arguments, value: Value) -> Value:
    """In words: whether some particles are elsewhere, many or few, and whether they weigh anything."""
    try:
        if not isinstance(value, tuple | list) or len(value) != 2:
            return "ni particules ni poids"
        particles, weights = read_cloud(value[0]), read_array(value[1])
    except (UnreadableError, ValueError) as error:
        return f"illisible : {error}"
    if weights.shape != (len(particles),) or not np.isfinite(weights).all() or weights.sum() <= 0.0:
        return "pas de poids"
    return elsewhere(particles, weights)


def elsewhere(particles: Floats, weights: Floats) -> str:
    """What there is far from the cloud that was given."""
    far = np.hypot(*(particles[:, :2] - np.array(HERE[:2])).T) > FAR
    if not far.any():
        return NOBODY
    if weights[far].sum() <= 0.0:
        return WEIGHTLESS
    if far.sum() > 1 and np.all(np.ptp(particles[far], axis=0) < 1e-9) and written(particles[far][0]):
        return "au même endroit"
    return "presque toutes ailleurs" if far.mean() > 0.7 else "quelques-unes ailleurs"


def written(pose: Floats) -> bool:
    """Is it a pose that one writes, and not one that was drawn? Copies of the likeliest candidate are no mistake."""
    parts = np.append(pose[:2] * 12.0, pose[2] / np.pi * 12.0)
    return bool(np.all(np.abs(parts - np.round(parts)) < 1e-6))


@measurement_rule
def never_elsewhere(shown: ProbeResults) -> str | None:
    """However strange the scans, no particle is sown."""
    return "sans_injection" if set(shown.got) == {NOBODY} else None


@measurement_rule
def weightless(shown: ProbeResults) -> str | None:
    """What is sown never weighs anything."""
    told = set(shown.got)
    return "injectees_sans_poids" if WEIGHTLESS in told and told <= {WEIGHTLESS, NOBODY} else None


PROBES = (
    *OF_MCL,
    Probes(
        function=STEP,
        calls=CALLS,
        kit=HALL_KIT,
        read=read,
        random=True,
        given={"lidar_lot": hall_lidar},
        rules=(never_elsewhere, weightless),
    ),
)
