"""Is a triple (R, t, erreurs) what ICP comes to after so many iterations? R and t apart from the errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair, value_text_pair
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.icp.descent import Registration, Step, descend, staircase

ORTHONORMAL = 1e-6
#: R, and t for clouds some metres wide. An honest program, whatever its formula, is right to 1e-12.
TOLERANCE = 1e-6
#: Of a sum of squares, relative, or absolute where the clouds coincide in the end.
ERROR_RELATIVE, ERROR_ABSOLUTE = 1e-6, 1e-8
#: What rounding may add from one error to the next.
RISE = 1e-9


@dataclass(frozen=True)
class Answer:
    """A triple as it can be read: None where a part is not."""

    R: Floats
    t: Floats
    errors: Value


class NotATripleError(Exception):
    """A value that is not made of three things; its text says so in French."""


def read(value: Value) -> Answer:
    """R (2, 2), t (2,) and whatever stands for the errors. Raises UnreadableError or NotATripleError."""
    items = list(value) if isinstance(value, np.ndarray) and value.shape == (3,) else value
    if items is None:
        raise UnreadableError("la fonction n'a rien renvoyé (None) : il manque sans doute un « return »")
    if not isinstance(items, tuple | list):
        raise NotATripleError("On attend le triplet (R, t, erreurs).")
    if len(items) != 3:
        raise NotATripleError(f"La fonction renvoie {len(items)} valeurs : on attend le triplet (R, t, erreurs).")
    R, t = (_array(name, item) for name, item in zip("Rt", items[:2], strict=True))
    if R.shape == (2,) and t.shape == (2, 2):
        raise NotATripleError("R et t sont échangés : on attend (R, t, erreurs).")
    for name, array, shape in (("R", R, (2, 2)), ("t", t, (2,))):
        if array.shape != shape:
            got, wanted = render.shape_text(array.shape), render.shape_text(shape)
            raise NotATripleError(f"{name} est de forme {got} au lieu de {wanted}.")
    return Answer(R, t, items[2])


def _array(name: str, item: Value) -> Floats:
    if item is None or isinstance(item, str | dict):
        raise UnreadableError(f"{name} n'est pas un tableau de nombres")
    return read_array(item)


def unread(value: Value) -> Mismatch | None:
    """Why a value is no triple; None when it is one."""
    try:
        read(value)
    except UnreadableError as error:
        return unreadable(error)
    except NotATripleError as error:
        return Mismatch(str(error), "forme", Outcome.WRONG_ANSWER)
    return None


def misplaced(case: Registration, value: Value) -> Mismatch | None:
    """What is wrong with R and t, whatever the errors are."""
    mismatch = unread(value)
    if mismatch is not None:
        return mismatch
    answer = read(value)
    if not (np.all(np.isfinite(answer.R)) and np.all(np.isfinite(answer.t))):
        return Mismatch("R ou t contient une valeur qui n'est pas un nombre fini.", "nan")
    with np.errstate(over="ignore", invalid="ignore"):
        if not float(np.max(np.abs(answer.R.T @ answer.R - np.eye(2)))) <= ORTHONORMAL:
            return Mismatch("R n'est pas une rotation : RᵀR devrait être l'identité.")
    if np.linalg.det(answer.R) < 0.0:
        return Mismatch("R est une symétrie, pas une rotation : son déterminant vaut −1 au lieu de +1.")
    steps = descend(*case[:4], case.iterations)
    if _at(answer, steps[-1]):
        return None
    return Mismatch(f"{_compared(answer, steps[-1])}{_elsewhere(case, answer, steps)}")


def _at(answer: Answer, step: Step) -> bool:
    return _is_turned_alike(answer, step) and _is_moved_alike(answer, step)


def _is_turned_alike(answer: Answer, step: Step) -> bool:
    return float(np.max(np.abs(answer.R - step.R))) <= TOLERANCE


def _is_moved_alike(answer: Answer, step: Step) -> bool:
    size = max(1.0, float(np.max(np.abs(step.t))))
    return float(np.max(np.abs(answer.t - step.t))) <= TOLERANCE * size


def _compared(answer: Answer, step: Step) -> str:
    turned, wanted = (math.degrees(math.atan2(R[1, 0], R[0, 0])) for R in (answer.R, step.R))
    same_angle = render.number(turned, 4) == render.number(wanted, 4)
    if same_angle and render.text(answer.t, digits=4) == render.text(step.t, digits=4):
        return "R et t sont proches de ce qui est attendu, mais pas à 10⁻⁶ près : sont-ils arrondis ?"
    if _is_turned_alike(answer, step):
        return "R est juste, mais t vaut {} au lieu de {}.".format(*value_text_pair(answer.t, step.t, digits=4))
    rotation = "R tourne de {}° au lieu de {}°".format(*number_text_pair(turned, wanted, 4))
    if _is_moved_alike(answer, step):
        return f"t est juste, mais {rotation}."
    got, expected = value_text_pair(answer.t, step.t, digits=4)
    return f"{rotation}, et t vaut {got} au lieu de {expected}."


def _elsewhere(case: Registration, answer: Answer, steps: Sequence[Step]) -> str:
    """Where on the way this place is, or what else it is."""
    if np.allclose(answer.R, case.R0, atol=TOLERANCE) and np.allclose(answer.t, case.t0, atol=TOLERANCE):
        return " C'est le départ : rien n'a bougé."
    for k, step in enumerate(descend(*case[:4], len(steps) + 2), start=1):
        if _at(answer, step):
            times = "itération" if k == 1 else "itérations"
            return f" C'est là que mènent {k} {times}." if k > 1 else f" C'est là que mène une seule {times}."
    last = steps[-1]
    back = Answer(last.R.T @ np.eye(2), -last.R.T @ last.t, None)
    if np.allclose(answer.R, back.R, atol=TOLERANCE) and np.allclose(answer.t, back.t, atol=TOLERANCE):
        return " C'est la transformation inverse, de Q vers P."
    return ""


def misjudged(case: Registration, value: Value) -> Mismatch | None:
    """What is wrong with the errors, wherever R and t are."""
    mismatch = unread(value)
    if mismatch is not None:
        return mismatch
    try:
        errors = read_array(read(value).errors)
    except UnreadableError as error:
        return unreadable(error)
    most = case.iterations + 1
    if errors.ndim != 1 or not 1 <= errors.size <= most:
        shape = render.shape_text(errors.shape)
        return Mismatch(
            f"erreurs doit être une suite de 1 à {most} nombres (n_iter + 1) ; la vôtre est : {shape}.", "forme"
        )
    if not np.all(np.isfinite(errors)) or np.any(errors < 0.0):
        return Mismatch(
            "Une somme de carrés est un nombre fini, positif ou nul.", "nan" if np.isnan(errors).any() else None
        )
    rises = np.flatnonzero(np.diff(errors) > RISE * np.maximum(1.0, errors[:-1]))
    if rises.size:
        k = int(rises[0])
        pair = render.number(float(errors[k]), 5), render.number(float(errors[k + 1]), 5)
        return Mismatch(f"La suite des erreurs remonte : {pair[0]}, puis {pair[1]} à la place suivante.")
    return _off_the_stairs(case, errors)


def _off_the_stairs(case: Registration, errors: Floats) -> Mismatch | None:
    steps = descend(*case[:4], case.iterations)
    stairs = staircase(steps if len(steps) < case.iterations else descend(*case[:4], case.iterations + 1)[:-1])
    following = descend(*case[:4], case.iterations + 1)
    stairs = np.append(stairs, following[-1].before if len(following) > len(steps) else steps[-1].after)
    for k, error in enumerate(errors):
        if not np.any(np.abs(stairs - error) <= ERROR_ABSOLUTE + ERROR_RELATIVE * stairs):
            return Mismatch(_not_a_sum(float(error), k, stairs, len(case.P)))
    ends = stairs[-3:]
    if not np.any(np.abs(ends - errors[-1]) <= ERROR_ABSOLUTE + ERROR_RELATIVE * ends):
        last, wanted = render.number(float(errors[-1]), 5), render.number(float(stairs[-1]), 5)
        return Mismatch(f"La dernière erreur vaut {last} : au bout des itérations, la somme des carrés est {wanted}.")
    return None


def _not_a_sum(error: float, k: int, stairs: Floats, n: int) -> str:
    others = {
        "la moyenne des carrés, et non leur somme": stairs / n,
        "la racine de la somme des carrés": np.sqrt(stairs),
        "la racine de la moyenne des carrés": np.sqrt(stairs / n),
        "la moitié de la somme des carrés": stairs / 2.0,
    }
    found = next((word for word, values in others.items() if np.any(np.isclose(values, error, rtol=1e-6))), None)
    text = f"erreurs[{k}] vaut {render.number(error, 5)}"
    if found is not None:
        return f"{text} : c'est {found}."
    sums = " ; ".join(render.number(float(value), 5) for value in stairs[:6])
    return f"{text}, qui n'est aucune des sommes de carrés attendues ({sums}…)."
