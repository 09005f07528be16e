"""Is a pair (R, t) the best rigid transformation between two clouds? By its cost, so that any of the best is right."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair, value_text_pair
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from reference.registration import RigidAlignment, squared_residual

ORTHONORMAL = 1e-8
"""How far R^T R may be from the identity: exact formulas reach 1e-15, an R in single precision or rounded does not."""

COST_RELATIVE = 1e-7
COST_OF_SPREAD = 1e-13
"""A cost is minimal within 1e-7 of itself, or 1e-13 of the clouds' own spread. Where the fit is exact, R and t are thus
known within about 3e-7. Where it is not, an honest iterative minimiser, stopped by its usual tolerances, leaves up to
4e-8 (2e-14 of the spread when exact), while the least wrong formula, on the graded clouds, costs some percents more."""

LOOKS_THE_SAME = 1e-5


@dataclass(frozen=True)
class Assessment:
    """What is wrong, if anything; what is written down for the diagnosis; R and t when they are of the right shape.

    `aspect` is what was looked at last: the "form", the numbers being "finite", the "rotation", or the "cost".
    """

    aspect: str
    mismatch: Mismatch | None
    observed: Value
    R: Floats | None = None
    t: Floats | None = None


class Part(StrEnum):
    """What a check judges: the rotation, with the translation that fits it; the translation, for the rotation that is
    returned; or the pair as it is."""

    ROTATION = "R"
    TRANSLATION = "t"
    PAIR = "(R, t)"


def judge(P: Floats, Q: Floats, best: RigidAlignment, value: Value, part: Part = Part.PAIR) -> Assessment:
    """Judge what `kabsch(P, Q)` returned, or a part of it, against the best alignment.

    Never raises for a student's value.
    """
    d = P.shape[1]
    try:
        R, t = read_pair(value)
    except UnreadableError as error:
        return Assessment("form", unreadable(error), "illisible")
    except NotAPairError as error:
        return Assessment("form", Mismatch(str(error), "forme"), str(error))
    wrong_shapes = _wrong_shapes(R, t, d, part)
    if wrong_shapes is not None:
        return Assessment("form", wrong_shapes, f"R {R.shape}, t {t.shape}")
    not_finite = _not_finite(R, t, part)
    if not_finite is not None:
        return Assessment("finite", not_finite, (R, t))
    with np.errstate(over="ignore", invalid="ignore"):
        return _judge_numbers(P, Q, best, R, t, part)


def _judge_numbers(P: Floats, Q: Floats, best: RigidAlignment, R: Floats, t: Floats, part: Part) -> Assessment:
    if part is Part.TRANSLATION:
        return Assessment("cost", _not_fitting(P, Q, best, R, t), (R, t), R, t)
    improper = _not_a_rotation(R)
    if improper is not None:
        return Assessment("rotation", improper, (R, t), R, t)
    judged_t = _own_t(P, Q, R) if part is Part.ROTATION else t
    return Assessment("cost", _not_minimal(P, Q, best, R, judged_t, part), (R, t), R, t)


class NotAPairError(Exception):
    """A value that is not made of two things; its text says so in French."""


def read_pair(value: Value) -> tuple[Floats, Floats]:
    """Read a tuple, a list or any other sequence of two items as two float arrays, whatever their shapes.

    Raises UnreadableError for what holds no real numbers, NotAPairError for numbers that are not a pair.
    """
    items = list(value) if isinstance(value, np.ndarray) and value.shape == (2,) else value
    if not isinstance(items, tuple | list):
        shape = render.shape_text(read_array(items).shape)
        raise NotAPairError(f"La fonction renvoie {_single(shape)} : on attend la paire (R, t).")
    if len(items) != 2:
        raise NotAPairError(f"La fonction renvoie une suite de longueur {len(items)} : on attend la paire (R, t).")
    return _read_item("R", items[0]), _read_item("t", items[1])


def _single(shape: str) -> str:
    return f"un tableau de forme {shape}" if shape.startswith("(") else shape


def _read_item(name: str, item: Value) -> Floats:
    if item is None:
        raise UnreadableError(f"{name} vaut None au lieu d'un tableau de nombres")
    if isinstance(item, str | dict):
        raise UnreadableError(f"{name} n'est pas un tableau de nombres")
    return read_array(item)


def _wrong_shapes(R: Floats, t: Floats, d: int, part: Part) -> Mismatch | None:
    if R.shape == (d,) and t.shape == (d, d):
        return Mismatch("La paire est dans l'ordre (t, R) : on attend (R, t).", "forme")
    shapes = {"R": (R.shape, (d, d)), "t": (t.shape, (d,))}
    wrong = [
        f"{name} est de forme {render.shape_text(got)} au lieu de {render.shape_text(right)}"
        for name, (got, right) in shapes.items()
        if got != right and not (name == "t" and part is Part.ROTATION)
    ]
    return Mismatch(f"En dimension {d}, " + " et ".join(wrong) + ".", "forme") if wrong else None


def _not_finite(R: Floats, t: Floats, part: Part) -> Mismatch | None:
    judged = {"R": R} if part is Part.ROTATION else {"R": R, "t": t}
    if not (which := " et ".join(name for name, array in judged.items() if not np.all(np.isfinite(array)))):
        return None
    slip = "nan" if any(np.any(np.isnan(array)) for array in judged.values()) else None
    verb = "contiennent" if " et " in which else "contient"
    return Mismatch(f"{which} {verb} une valeur qui n'est pas un nombre fini.", slip)


def _not_a_rotation(R: Floats) -> Mismatch | None:
    d = len(R)
    gram = R.T @ R
    gap = float(np.max(np.abs(gram - np.eye(d))))
    if not gap <= ORTHONORMAL:
        return Mismatch(_not_orthogonal(gram, gap))
    if np.linalg.det(R) < 0:
        return Mismatch("R est une symétrie, pas une rotation : son déterminant vaut −1 au lieu de +1.")
    return None


def _not_orthogonal(gram: Floats, gap: float) -> str:
    if gap < LOOKS_THE_SAME:
        return f"R n'est une rotation qu'à {render.number(gap, 2)} près : est-elle arrondie, ou en simple précision ?"
    square = float(np.trace(gram)) / len(gram)
    if square > 0 and float(np.max(np.abs(gram - square * np.eye(len(gram))))) <= ORTHONORMAL * square:
        factor = render.number(math.sqrt(square), 4)
        return f"R n'est pas une rotation : elle multiplie les longueurs par {factor}, alors qu'une rotation les garde."
    return f"R n'est pas une rotation : RᵀR devrait être l'identité, et s'en écarte de {render.number(gap, 3)}."


def _not_minimal(P: Floats, Q: Floats, best: RigidAlignment, R: Floats, t: Floats, part: Part) -> Mismatch | None:
    cost = squared_residual(R, t, P, Q)
    if cost <= best.residual + _tolerance(P, Q, best.residual):
        return None
    using = "votre (R, t)" if part is Part.PAIR else "votre R et le t qui lui convient"
    total = f"Avec {using}, la somme des carrés vaut {{}} ; le minimum est {{}}."
    minimum = 0.0 if best.residual < _tolerance(P, Q, 0.0) else best.residual
    return Mismatch(f"{total.format(*number_text_pair(cost, minimum, 5))} {_culprit(P, Q, best, R, t, part)}".strip())


def _not_fitting(P: Floats, Q: Floats, best: RigidAlignment, R: Floats, t: Floats) -> Mismatch | None:
    """Return the mismatch of a t that is the best one neither for the R beside it nor for the best rotation."""
    own_t = _own_t(P, Q, R)
    if len(P) * float(np.sum((t - own_t) ** 2)) <= _tolerance(P, Q, squared_residual(R, own_t, P, Q)):
        return None  # by as much as that, the cost is above that of the best t
    if best.unique and squared_residual(best.R_q_p, t, P, Q) <= best.residual + _tolerance(P, Q, best.residual):
        return None
    best_t, your_t = value_text_pair(own_t, t, digits=5)
    is_right = best.unique and np.allclose(R, best.R_q_p, atol=LOOKS_THE_SAME)
    which = "R est juste ;" if is_right else "Avec votre R,"
    return Mismatch(f"{which} le meilleur t est {best_t}, le vôtre est {your_t}.")


def _own_t(P: Floats, Q: Floats, R: Floats) -> Floats:
    """Return the best translation (d,) for this matrix."""
    return np.asarray(Q.mean(axis=0) - R @ P.mean(axis=0))


def _tolerance(P: Floats, Q: Floats, minimum: float) -> float:
    """How much above the minimum a cost may be. With no spread at all, what is left is t's own 1e-9 of its size."""
    spread = float(np.sum((P - P.mean(axis=0)) ** 2) + np.sum((Q - Q.mean(axis=0)) ** 2))
    size = max(1.0, float(np.max(np.abs(P))), float(np.max(np.abs(Q))))
    return COST_RELATIVE * minimum + COST_OF_SPREAD * spread + P.size * (1e-9 * size) ** 2


def _culprit(P: Floats, Q: Floats, best: RigidAlignment, R: Floats, t: Floats, part: Part) -> str:
    """Which of R and t is to blame, in one French sentence."""
    if part is Part.ROTATION:
        return f"R n'est pas la bonne rotation{_angles(R, best.R_q_p)}." if best.unique else ""
    own_t = _own_t(P, Q, R)
    t_fits = bool(np.all(np.abs(t - own_t) <= LOOKS_THE_SAME * np.maximum(1.0, np.abs(own_t))))
    best_t, your_t = value_text_pair(own_t, t, digits=5)
    right_t = f"le meilleur t est {best_t}, le vôtre est {your_t}."
    if np.allclose(R, best.R_q_p, atol=LOOKS_THE_SAME):
        return f"R est juste ; {right_t}"
    if not best.unique:
        return "" if t_fits else f"Avec votre R, {right_t}"
    which = "Votre t convient à votre R, mais R n'est pas la bonne" if t_fits else "R n'est pas la bonne"
    return f"{which} rotation{_angles(R, best.R_q_p)}."


def _angles(R: Floats, best: Floats) -> str:
    if len(R) != 2:
        return ""
    turned, wanted = (math.degrees(math.atan2(M[1, 0], M[0, 0])) % 360.0 for M in (R, best))
    turned, wanted = (angle - 360.0 * (angle > 180.0 + 1e-9) for angle in (turned, wanted))
    turned_text, wanted_text = number_text_pair(turned, wanted, 4)
    return f" : elle tourne de {turned_text}° au lieu de {wanted_text}°"
