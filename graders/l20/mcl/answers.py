"""What the functions of a particle filter answer, read and held to their shapes; l20/defi_kidnappe uses it too."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import unreadable
from graders.core.compare.told_apart import got_instead_of_expected_text
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats, UnreadableError, Value, read_array

SEED, STEP, ESTIMATE = "initialiser", "pas_mcl", "estimer"
#: A filter may change the number of its particles, but not at will.
MOST = 5000
SUM_TOLERANCE = 1e-6


def read_cloud(value: Value) -> Floats:
    """Poses (m, 3) of finite numbers. Raises ValueError with what is wrong, in French, or UnreadableError."""
    cloud = read_array(value)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) == 0:
        raise ValueError(f"Les particules ont la forme {render.shape_text(cloud.shape)} au lieu de (n, 3).")
    if len(cloud) > MOST:
        raise ValueError(f"Le nuage compte {len(cloud)} particules : il n'en faut pas plus de {MOST}.")
    if not np.isfinite(cloud).all() or np.abs(cloud).max() > 1e9:
        raise ValueError("Une des particules contient « nan », l'infini ou un nombre immense.")
    return cloud


def read_weights(value: Value, count: int) -> Floats:
    """Weights (count,), none negative, of sum 1. Raises ValueError with what is wrong, or UnreadableError."""
    weights = read_array(value)
    if weights.shape != (count,):
        raise ValueError(
            f"Les poids ont la forme {render.shape_text(weights.shape)} : il en faut un par particule, ({count},)."
        )
    if not np.isfinite(weights).all():
        raise ValueError(
            "Les poids contiennent « nan » ou l'infini : leur somme était nulle, ou un logarithme valait −∞."
        )
    if weights.min() < -SUM_TOLERANCE:
        raise ValueError(f"Un poids est négatif : {render.number(float(weights.min()), 4)}.")
    if abs(weights.sum() - 1.0) > SUM_TOLERANCE:
        raise ValueError(f"La somme des poids vaut {got_instead_of_expected_text(1.0, float(weights.sum()))}.")
    return np.maximum(weights, 0.0)


def read_step(value: Value) -> tuple[Floats, Floats]:
    """Particles and weights. Raises as `read_cloud` does."""
    if not isinstance(value, tuple | list) or len(value) != 2:
        if value is None:
            raise UnreadableError("la fonction n'a rien renvoyé (None) : il manque sans doute un « return »")
        raise ValueError("On attend deux objets, dans cet ordre : les particules, puis les poids.")
    cloud = read_cloud(value[0])
    return cloud, read_weights(value[1], len(cloud))


def read_pose(value: Value) -> Floats:
    """A pose (3,) of finite numbers. Raises as `read_cloud` does."""
    pose = read_array(value)
    if pose.shape != (3,):
        raise ValueError(f"L'estimation a la forme {render.shape_text(pose.shape)} au lieu de (3,).")
    if not np.isfinite(pose).all() or np.abs(pose).max() > 1e9:
        raise ValueError("L'estimation contient « nan », l'infini ou un nombre immense.")
    return pose


def seeded(bench: Bench, count: int) -> Floats:
    """What `initialiser(count)` gives."""
    value = bench.call(SEED, count)
    try:
        cloud = read_cloud(value)
        if len(cloud) != count:
            raise ValueError(f"On demande {count} particules, il y en a {len(cloud)}.")
    except (UnreadableError, ValueError) as error:
        raise misread(error, SEED, {"n": count}, f"{count} poses (n, 3)", value) from error
    return cloud


def stepped(bench: Bench, args: Mapping[str, Value]) -> tuple[Floats, Floats]:
    """What `pas_mcl` gives."""
    value = bench.call(STEP, *args.values())
    try:
        return read_step(value)
    except (UnreadableError, ValueError) as error:
        raise misread(error, STEP, args, "des particules (n, 3), et leurs poids (n,) de somme 1", value) from error


def estimated(bench: Bench, particles: Floats, weights: Floats) -> Floats:
    """What `estimer` gives."""
    value = bench.call(ESTIMATE, particles, weights)
    try:
        return read_pose(value)
    except (UnreadableError, ValueError) as error:
        raise misread(error, ESTIMATE, {"particules": particles, "poids": weights}, "une pose (3,)", value) from error


def misread(error: Exception, function: str, inputs: Mapping[str, Value], expected: str, got: Value) -> Rejection:
    """What cannot be read is an invalid output; what is read and is not what was asked for, a wrong answer."""
    cause = Outcome.INVALID_OUTPUT if isinstance(error, UnreadableError) else Outcome.WRONG_ANSWER
    reason = unreadable(error).message if isinstance(error, UnreadableError) else str(error)
    slip = "nan" if "nan" in reason else "forme" if " forme " in reason else None
    return Rejection(
        f"{function} : {reason[0].lower()}{reason[1:]}",
        inputs=dict(inputs),
        expected=expected,
        got=got,
        slip=slip,
        cause=cause,
    )
