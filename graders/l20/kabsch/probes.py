"""What `kabsch` is asked by hand: exact clouds and noisy ones, then mirrors, then poor ones."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.probes import (
    ProbeAnswer,
    ProbeResults,
    Probes,
    measurement_rule,
    same_probe_answer,
    to_finite_array,
)
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value
from graders.l20 import world
from graders.l20.kabsch.cases import AXES_IN_TURN, points
from graders.l20.kabsch.judge import NotAPairError, judge, read_pair
from reference.registration import kabsch
from reference.se2 import rotation_matrix

FLAT = points((1, 2), (4, 2), (5, 4), (2, 6), (1, 1))
SOLID = points((1, 2, 3), (5, 2, 1), (3, 6, 2), (2, 1, 0), (0, 3, 5), (4, 4, 4))
SHAKE = points((0.2, -0.1), (-0.3, 0.2), (0.1, 0.3), (-0.2, -0.1), (0.3, 0.1))
TURN = AXES_IN_TURN @ np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
FAR = points((3, -2, 1))[0]
#: Its H is diagonal, so that every LAPACK finds a determinant of exactly -1 for its mirror.
CROSS = points((2, 0), (-2, 0), (0, 1), (0, -1))
JUST = "juste"

EXACT_FLAT = (FLAT, FLAT @ rotation_matrix(0.7).T + (2.0, -1.0))
EXACT_SOLID = (SOLID, SOLID @ TURN.T + FAR)
NOISY_FLAT = (FLAT, FLAT @ rotation_matrix(-1.2).T + SHAKE + (1.0, 3.0))
NOISY_SOLID = (SOLID, SOLID @ TURN.T + np.column_stack([SHAKE[[0, 1, 2, 3, 4, 0]], SHAKE[[4, 3, 2, 1, 0, 2], 0]]) - FAR)
MIRROR_FLAT = (FLAT, (FLAT * (-1.0, 1.0)) @ rotation_matrix(0.4).T + SHAKE + (1.0, 3.0))
MIRROR_SOLID = (SOLID, (SOLID * (1.0, 1.0, -1.0)) @ TURN.T + FAR)
OTHER_MIRRORS = (
    (FLAT + SHAKE, (FLAT * (1.0, -1.0)) @ rotation_matrix(2.1).T - SHAKE),
    (SOLID, (SOLID * (-1.0, 1.0, 1.0)) @ TURN @ TURN + FAR / 2.0),
    (FLAT - 2.0 * SHAKE, (FLAT * (-1.0, 1.0)) @ rotation_matrix(-1.0).T + (5.0, 1.0)),
    (SOLID + FAR, -SOLID @ TURN.T),
    (CROSS, CROSS * (1.0, -1.0) + (3.0, 1.0)),
)
BEYOND_FLAT = (FLAT, FLAT @ rotation_matrix(2.4).T + (1.0, 2.0))
BEYOND_NOISY = (FLAT, FLAT @ rotation_matrix(-2.0).T + SHAKE - (2.0, 0.5))
POOR: tuple[tuple[Floats, Floats], ...] = (
    (points((2, 1)), points((4, -3))),
    (points((1, 2), (1, 2), (1, 2)), points((3, 1), (3, 1), (3, 1))),
    (points((0, 0, 0), (2, 0, 0)), points((1, 1, 1), (1, 3, 1))),
    (points((0, 0, 0), (3, 0, 0), (0, 2, 0), (1, 1, 0)), points((1, 0, 1), (1, 3, 1), (-1, 0, 1), (0, 1, 1))),
    (points((0, 0), (1, 1), (3, 3)), points((2, 1), (3, 0), (5, -2))),
)

CALLS: tuple[Arguments, ...] = (
    NOISY_SOLID, EXACT_FLAT, NOISY_FLAT, EXACT_SOLID, MIRROR_FLAT, MIRROR_SOLID,
    *OTHER_MIRRORS, BEYOND_FLAT, BEYOND_NOISY, *POOR,
)  # fmt: skip
TELLING = 13
NEAR = 1e-2
EXACT, NOISY, MIRRORS = (1, 3), (0, 2), (4, 5, 6, 7, 8, 9, 10)
PLANE, SPACE = (1, 2, 4, 6, 8, 10, 11, 12), (0, 3, 5, 7, 9)


def read(args: Arguments, value: Value) -> Value:
    """R and t in one row; a word where they are no pair; where the rotation is not unique, whether it is a best one."""
    P, Q = args
    try:
        R, t = read_pair(value)
    except (UnreadableError, NotAPairError) as error:
        return str(error)
    d = P.shape[1]
    if R.shape != (d, d) or t.shape != (d,):
        return f"R {R.shape}, t {t.shape}"
    if any(P is poor for poor, _ in POOR) or len(P) < d + 1:
        return JUST if judge(P, Q, kabsch(P, Q), value).mismatch is None else "faux"
    return np.concatenate([R.ravel(), t])


def _parts(shown: ProbeResults, k: int) -> tuple[Floats, Floats] | None:
    """R and t of probe k, when they are finite and of the right shapes."""
    d = shown.calls[k][0].shape[1]
    row = to_finite_array(shown.got[k], (d * d + d,))
    return None if row is None else (row[: d * d].reshape(d, d), row[d * d :])


def _right_rotation(shown: ProbeResults, k: int) -> bool:
    mine = _parts(shown, k)
    d = shown.calls[k][0].shape[1]
    return mine is not None and bool(np.allclose(mine[0].ravel(), shown.right[k][: d * d], atol=1e-6))


def rotation_part(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    """R alone."""
    d = args[0].shape[1]
    return shown[: d * d] if isinstance(shown, np.ndarray) else shown


@measurement_rule
def only_t(shown: ProbeResults) -> str | None:
    """Every R is right, and every t is wrong where it can be."""
    telling = range(TELLING)
    wrong = set(shown.wrong_indices()) & set(telling)
    return "t_fausse" if len(wrong) >= 4 and all(_right_rotation(shown, k) for k in telling) else None


@measurement_rule
def no_rotation(shown: ProbeResults) -> str | None:
    """Some R, of clouds that are no mirrors, is not orthogonal."""
    parts = [_parts(shown, k) for k in (*EXACT, *NOISY)]
    found = [p for p in parts if p is not None]
    odd = [p for p in found if float(np.max(np.abs(p[0].T @ p[0] - np.eye(len(p[0]))))) > 1e-4]
    if odd and len(odd) == len(found) and all(_stretches(R) for R, _ in odd):
        return "echelle"
    return "r_pas_rotation" if len(odd) >= 2 else None


def _stretches(R: Floats) -> bool:
    """Is it a rotation times a number?"""
    gram = R.T @ R
    size = float(np.trace(gram)) / len(R)
    return size > 0 and bool(np.allclose(gram, size * np.eye(len(R)), atol=1e-6 * size))


@measurement_rule
def mirrors_only(shown: ProbeResults) -> str | None:
    """All is right but the mirrors."""
    wrong = {k for k in shown.wrong_indices() if k < TELLING}
    if not wrong or not wrong <= set(MIRRORS):
        return None
    signs = [math.copysign(1.0, float(np.linalg.det(p[0]))) for k in wrong if (p := _parts(shown, k)) is not None]
    if len(signs) < len(wrong):
        return None
    if all(sign < 0 for sign in signs):
        return "sans_correction" if wrong == set(MIRRORS) else "symetrie_manquee"
    return "correction_fausse" if all(_turns_a_direction(shown, k) for k in wrong) else None


def _turns_a_direction(shown: ProbeResults, k: int) -> bool:
    """Is R the best orthogonal matrix but for the signs of its singular directions?"""
    parts = _parts(shown, k)
    P, Q = shown.calls[k]
    U, _, Vt = np.linalg.svd((P - P.mean(axis=0)).T @ (Q - Q.mean(axis=0)))
    signs = Vt @ parts[0] @ U if parts is not None else np.zeros_like(U)
    return bool(np.allclose(np.abs(signs), np.eye(len(U)), atol=1e-6))


@measurement_rule
def half_a_turn(shown: ProbeResults) -> str | None:
    """In the plane, right up to a quarter of a turn, and beyond it half a turn away."""
    for k in PLANE:
        parts, right = _parts(shown, k), np.asarray(shown.right[k][:4]).reshape(2, 2)
        side = 1.0 if right[0, 0] > 0.0 else -1.0
        if parts is None or not np.allclose(parts[0], side * right, atol=1e-6):
            return None
    return "angle_modulo_pi"


@measurement_rule
def exact_only(shown: ProbeResults) -> str | None:
    """Right for clouds that coincide, wrong in both dimensions for those that do not."""
    wrong = set(shown.wrong_indices())
    if wrong & set(EXACT) or any(_parts(shown, k) is None for k in NOISY):
        return None
    # An honest minimiser stops near the best: what is next to it is no mistake.
    far = all(not same_probe_answer(shown.got[k], shown.right[k], NEAR) for k in NOISY)
    return "juste_sans_bruit" if far else None


@measurement_rule
def plane_only(shown: ProbeResults) -> str | None:
    """Right in the plane, mirror included, and never in space."""
    wrong = set(shown.wrong_indices())
    return "plan_seulement" if not wrong & set(PLANE) and set(SPACE) <= wrong else None


@measurement_rule
def poor_only(shown: ProbeResults) -> str | None:
    """All is right but clouds too poor to fix a rotation, or flat."""
    wrong = shown.wrong_indices()
    return "nuages_pauvres" if wrong and min(wrong) >= TELLING else None


@measurement_rule
def never_turns(shown: ProbeResults) -> str | None:
    """R is always the identity."""
    parts = [_parts(shown, k) for k in range(TELLING)]
    return "rotation_identite" if all(p is not None and np.allclose(p[0], np.eye(len(p[0]))) for p in parts) else None


PROBES = (
    Probes(
        function="kabsch",
        calls=CALLS,
        kit=world.STILL,
        read=read,
        rules=(half_a_turn, only_t, never_turns, no_rotation, plane_only, mirrors_only, exact_only, poor_only),
        facet=rotation_part,
        compared=TELLING,
    ),
)
