"""What the three functions are asked by hand. A filter draws at random and may weigh as it likes: of each answer only
what no honest choice changes is looked at, in words, so that programs which make one mistake say the same of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from graders.core.code.probes import ProbeResults, Probes, measurement_rule, undo_rule
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import journeys, world
from graders.l20.mcl.answers import ESTIMATE, SEED, STEP, read_cloud, read_pose
from graders.l20.mcl.estimates import HEAVY, LIGHT, peaked, uneven
from graders.l20.mcl.labels import Label, arrivals, copied, left, nearest_arrival, repeated, summed, where, winner
from graders.l20.mcl.memory import TWINS
from graders.l20.mcl.scenes import ALWAYS, HALL, HALL_KIT, HALL_RANGE, SMALL, Step, step
from graders.l20.mcl.steps import HEADINGS_AND_MOVES

SMALL_KIT = KitSettings(world.MODULE, {"libres": SMALL, "portee_max": world.RANGE, "seed": 0})
RNG = np.random.default_rng(ALWAYS)
HEAP, SIDE = 25, 60

# -- pas_mcl ----------------------------------------------------------------------------------------------------------


def _two(one: tuple[float, ...], other: tuple[float, ...], move: tuple[float, ...] = (0.3, 0.0, 0.1)) -> Step:
    return step(RNG, [(one, 15), (other, 15)], move, in_hall=True, spread=(0.03, 0.02))


CORNER = (2.4, 3.2, 0.3)
HEAPS = [(where, step(RNG, [(pose, HEAP)], move, in_hall=True, spread=(0.0, 0.0))) for pose, move in HEADINGS_AND_MOVES]
DUELS = [
    _two(CORNER, (18.0, 6.0, 0.3)),
    _two(CORNER, (2.4, 3.2, 0.3 + np.pi / 2.0)),
    _two(CORNER, (2.4, 3.2, 0.3 - np.pi / 2.0)),
    _two(CORNER, (2.4, 3.2, 0.3 - np.pi)),
    _two(CORNER, (2.4, 9.8, -0.3)),
    _two(CORNER, (3.95, 3.66, 0.9), (1.6, 0.0, 0.6)),
]
TWO = [(TWINS[0], SIDE), (TWINS[1], SIDE)]
MILD = step(RNG, TWO, (0.4, 0.0, 0.1), in_hall=True, weights=(0.77, 0.23))
SHARP = step(RNG, [(TWINS[0], 12), (TWINS[1], 88)], (0.4, 0.0, 0.1), in_hall=True, weights=(0.8, 0.2))
FEW = step(RNG, [((18.0, 4.0, 0.0), 12), ((2.2, 4.0, 0.0), 88)], (0.3, 0.0, 0.0), in_hall=True)
# The same, where the weights that come in say it already: who draws before weighing has to copy here.
KNOWN = replace(FEW, particles=FEW.particles.copy(), weights=np.repeat([0.96 / 12, 0.04 / 88], [12, 88]))
EVEN = step(RNG, TWO, (0.4, 0.0, 0.1), in_hall=True)
LOST = replace(_two((2.2, 2.2, 0.8), (31.5, 10.6, -2.4)), scan=np.full(journeys.BEAMS, HALL_RANGE))
SCENES: list[tuple[Label, Step]] = [
    *HEAPS,
    *((winner, scene) for scene in DUELS),
    (left, MILD),
    (left, SHARP),
    (copied, FEW),
    (repeated, EVEN),
    (summed, EVEN),
    (summed, LOST),
    (copied, KNOWN),
]
#: A scene stands for its first argument: labels are found by it.
STEPS: tuple[tuple[Label, Step, Arguments], ...] = tuple(
    (label, scene, (scene.particles.copy(), scene.weights, scene.move, scene.scan)) for label, scene in SCENES
)
MOTIONS, FIGHTS = range(len(HEAPS)), range(len(HEAPS), len(HEAPS) + len(DUELS))
KEPT_MILD, KEPT_SHARP, COPIED, REPEATED, SUMMED, UNDERFLOWN, TOLD = range(FIGHTS.stop, len(STEPS))


def read_step(args: Arguments, value: Value) -> Value:
    """In words, what a step shows of the scene that it was asked of."""
    label, scene = next((label, scene) for label, scene, asked in STEPS if asked[0] is args[0])
    try:
        if not isinstance(value, tuple | list) or len(value) != 2:
            return "ni particules ni poids"
        particles, weights = read_cloud(value[0]), read_array(value[1])
    except (UnreadableError, ValueError) as error:
        return f"illisible : {error}"
    if weights.shape != (len(particles),):
        return "un autre nombre de poids"
    if not np.isfinite(weights).all() or weights.sum() <= 0.0:
        return "pas de poids"
    return label(scene, particles, weights)


def hall_lidar(poses: ArrayLike, n_rayons: int) -> Floats:
    """`lidar_lot` in the hall, an empty rectangle: mutants ask for thousands of scans."""
    x, y, heading = np.asarray(poses, dtype=np.float64).reshape(-1, 3).T[:, :, None]
    angles = heading + 2.0 * np.pi * np.arange(n_rayons) / n_rayons
    height, width = HALL.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        across, down = np.cos(angles), np.sin(angles)
        side = np.where(across > 0, (width - 1 - x) / across, (1.0 - x) / across)
        end = np.where(down > 0, (height - 1 - y) / down, (1.0 - y) / down)
    inside = (x > 1) & (x < width - 1) & (y > 1) & (y < height - 1)
    return np.where(inside, np.minimum(np.minimum(side, end), HALL_RANGE), 0.0)


def words(shown: ProbeResults, places: range) -> set[str]:
    return {shown.got[k] for k in places if isinstance(shown.got[k], str)}


NAMES = {
    "rotation oubliée": "rotation_oubliee",
    "rotation inverse": "rotation_a_l_envers",
    "échangés": "sinus_et_cosinus_echanges",
    "tourne d'abord": "tourne_avant_d_avancer",
    "milieu": "cap_du_milieu",
    "sans virage": "virage_oublie",
    "virage opposé": "virage_oppose",
    "sur place": "deplacement_oublie",
    "sans dy": "glissement_oublie",
    "dy opposé": "glissement_oppose",
    "un signe": "rotation_mal_signee",
    "à l'envers": "marche_arriere",
    "retranché": "marche_arriere",
}


#: What each mistake leads to on the heaps: not every move tells it from the others, or from none.
LED = {
    name: [
        nearest_arrival(scene.particles[0], scene.move, arrivals(scene.particles[0], scene.move)[name])[0]
        for _, scene in HEAPS
    ]
    for name in NAMES
}


@measurement_rule
def misled(shown: ProbeResults) -> str | None:
    """All the heaps went where one mistake leads."""
    answers = [shown.got[k] for k in MOTIONS]
    led = [text.split(", ")[0] for text in answers if isinstance(text, str)]
    names = {NAMES[name] for name, there in LED.items() if there == led}
    return names.pop() if len(names) == 1 else None


@measurement_rule
def noiseless(shown: ProbeResults) -> str | None:
    """The heaps went the right way, as heaps."""
    ways = {
        "bruit_oublie": "juste, sans bruit",
        "bruit_partage": "juste, même bruit",
        "cap_sans_bruit": "juste, même cap",
    }
    return next((name for name, text in ways.items() if words(shown, MOTIONS) == {text}), None)


@undo_rule
def no_weights(shown: ProbeResults) -> str | None:
    """A lost cloud, and that alone, has no weights any more."""
    return (
        "produit_qui_s_annule"
        if shown.wrong_indices() == [UNDERFLOWN] and shown.got[UNDERFLOWN] == "pas de poids"
        else None
    )


@measurement_rule
def never_drawn(shown: ProbeResults) -> str | None:
    """Moves and weighs rightly, and copies nothing, neither where it should nor elsewhere."""
    kept = all(shown.got[k] == "gardées, poids inégaux" for k in (COPIED, TOLD))
    right = not set(shown.wrong_indices()) & {*MOTIONS, *FIGHTS}
    return "jamais_reechantillonne" if kept and right and shown.got[REPEATED] == "toutes" else None


# -- initialiser and estimer ------------------------------------------------------------------------------------------


def read_seeds(args: Arguments, value: Value) -> Value:
    """In words, where the particles are and where they look."""
    try:
        cloud = read_cloud(value)
    except (UnreadableError, ValueError) as error:
        return f"illisible : {error}"
    x, y, heading = cloud.T
    places = "libres" if _free(x, y) else "échangés" if _free(y, x) else "murs"
    parts = np.mod(np.column_stack([x, y]), 1.0)
    within = "coins" if np.all(parts < 1e-9) else "centres" if np.all(np.abs(parts - 0.5) < 1e-9) else "partout"
    turns = "un seul cap" if np.ptp(heading) < 1e-9 else _turns(heading)
    return f"{places}, {within}, {turns}"


def _free(x: Floats, y: Floats) -> bool:
    """Do all these places stand on free cells of the small map?"""
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (column >= 0) & (column < SMALL.shape[1]) & (row >= 0) & (row < SMALL.shape[0])
    return bool(inside.all() and SMALL[row, column].all())


def _turns(heading: Floats) -> str:
    return "tous les caps" if abs(np.exp(1j * heading).mean()) < 0.25 else "une partie des caps"


CLOUDS: tuple[Arguments, ...] = (
    peaked(5.25, 3.4, 3.1),
    peaked(12.4, 7.7, -3.0),
    peaked(6.3, 8.2, 0.1),
    peaked(9.3, 2.4, -1.2),
    uneven(),
)
MIDDLES = (3.1, -3.0, 0.1, -1.2, float(HEAVY[2]))


def read_estimate(args: Arguments, value: Value) -> Value:
    """In words, which place and which heading are told of a cloud."""
    try:
        pose = read_pose(value)
    except (UnreadableError, ValueError) as error:
        return f"illisible : {error}"
    k = next(k for k, cloud in enumerate(CLOUDS) if cloud[0] is args[0])
    cloud, weights = CLOUDS[k]
    if k == len(CLOUDS) - 1:
        far = [float(np.hypot(*(pose[:2] - place[:2]))) for place in (HEAVY, LIGHT)]
        return (
            "au poids"
            if far[0] < 0.8
            else "une légère"
            if far[1] < 0.4
            else "au nombre"
            if far[0] + far[1] < 3.2
            else "ailleurs"
        )
    if np.hypot(*(pose[:2] - cloud[13, :2])) > 0.12:
        return "ailleurs"
    return _told_heading(float(pose[2]), MIDDLES[k], cloud[:, 2], weights)


def _told_heading(heading: float, middle: float, headings: Floats, weights: Floats) -> str:
    def is_near(angle: float) -> bool:
        return float(journeys.away(np.array([0.0, 0.0, heading]), np.array([0.0, 0.0, angle]))[1]) < 0.15

    flat = {
        "juste": middle,
        "en long": float(weights @ headings),
        "en long modulo": float(weights @ np.mod(headings, 2.0 * np.pi)),
        "en long sans poids": float(headings.mean()),
        "complément": np.pi / 2.0 - middle,
        "opposé": middle + np.pi,
    }
    if abs(heading) > 2.0 * np.pi and abs(np.radians(heading) - middle) < 0.15:
        return "degrés"
    return next((name for name, angle in flat.items() if is_near(angle)), "autre cap")


@measurement_rule
def flat_mean(shown: ProbeResults) -> str | None:
    """Wrong only where headings go round, and as their plain mean is."""
    return "moyenne_des_angles" if {shown.got[k] for k in shown.wrong_indices()} <= {
        "en long", "en long modulo", "en long sans poids"} else None  # fmt: skip


PROBES = (
    Probes(function=SEED, calls=((300,), (300,)), kit=SMALL_KIT, read=read_seeds, random=True),
    Probes(
        function=STEP,
        calls=tuple(args for _, _, args in STEPS),
        kit=HALL_KIT,
        read=read_step,
        random=True,
        given={"lidar_lot": hall_lidar},
        rules=(misled, noiseless, no_weights, never_drawn),
    ),
    Probes(function=ESTIMATE, calls=CLOUDS, kit=world.STILL, read=read_estimate, random=True, rules=(flat_mean,)),
)
