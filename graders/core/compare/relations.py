"""What an obtained array has to do with the expected one: a property that fails, or a relation that holds everywhere.

A method unlike the model's has no twin among the catalogued mistakes, and its last digits tell nothing. Each sentence
states a fact of the two values that are shown, and no cause.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from graders.core.compare.words import number
from graders.core.contract.values import Floats

#: Relative error up to which a relation holds.
EXACT = 1e-9
#: Turns up to which a difference is a whole number of them: finite differences leave a millionth.
TURN = 1e-6
#: Entries from which it is told how many of them are wrong.
MANY = 4
_FACTORS = {2.0: "le double", 0.5: "la moitié", -1.0: "l’opposé", 4.0: "le quadruple", 0.25: "le quart"}


def tell_relation(expected: Floats, got: Floats) -> str:
    """Return one French sentence on two arrays of the same shape that differ; empty where nothing is to be said.

    Nothing but whole turns is said of single numbers: simplified ones are twice or a quarter of each other by chance.
    """
    if not (np.isfinite(got).all() and np.isfinite(expected).all()):
        return ""
    if turns := next(_tell_whole_turns(expected, got), ""):
        return turns
    if np.unique(expected).size < 2:
        return ""
    with np.errstate(all="ignore"):
        return next((told for find in _RELATIONS for told in find(expected, got)), "")


def _are_equal_arrays(a: Floats, b: Floats) -> bool:
    return bool(np.allclose(a, b, rtol=EXACT, atol=EXACT * 1e-3))


def _tell_lost_matrix_property(expected: Floats, got: Floats) -> Iterator[str]:
    """A property that the expected matrix has, and the obtained one has not."""
    if got.ndim != 2 or got.shape[0] != got.shape[1] or len(got) < 2:
        return
    gap, size = np.abs(got - got.T), max(1.0, float(np.abs(got).max()))
    if _are_equal_arrays(expected, expected.T) and gap.max() > EXACT * size:
        i, j = (int(k) for k in np.unravel_index(int(np.argmax(gap)), gap.shape))
        one, other = number(float(got[i, j])), number(float(got[j, i]))
        yield f"Le tableau attendu est symétrique, le vôtre non : ({i}, {j}) vaut {one} et ({j}, {i}) {other}."
        return
    if _are_equal_arrays(expected, expected.T):
        least, right = float(np.linalg.eigvalsh(got)[0]), float(np.linalg.eigvalsh(expected)[0])
        if right >= -EXACT and least < -EXACT * size:
            yield f"Le tableau a une valeur propre négative, {number(least, 4)} ; celui qui est attendu n’en a pas."


def _tell_whole_turns(expected: Floats, got: Floats) -> Iterator[str]:
    """Whole turns, wherever the values differ: an angle that was not brought back, or brought back elsewhere."""
    turns = np.abs(got - expected) / (2.0 * np.pi)
    whole = np.round(turns)
    if whole.max(initial=0.0) < 1.0 or not np.allclose(turns, whole, rtol=0.0, atol=TURN):
        return
    if whole.max() > 1.0:
        yield f"L’écart est un multiple de 2π{', partout' * (got.size > 1)} : un nombre entier de tours."
    else:
        yield f"L’écart est de 2π, un tour entier{', partout où c’est faux' * (got.size > 1)}."


def _tell_common_factor(expected: Floats, got: Floats) -> Iterator[str]:
    """The same factor everywhere."""
    there = np.abs(expected) > 1e-12
    if there.sum() < 2 or not _are_equal_arrays(got[~there], expected[~there]):
        return
    ratios = got[there] / expected[there]
    factor = float(ratios[0])
    if not _are_equal_arrays(ratios, np.full_like(ratios, factor)):
        return
    named = next((word for k, word in _FACTORS.items() if abs(factor / k - 1.0) < EXACT), "")
    if named:
        yield f"C’est {named} de ce qui est attendu, partout."
    elif factor:
        yield f"C’est partout {number(factor, 5)} fois ce qui est attendu."


def _tell_applied_function(expected: Floats, got: Floats) -> Iterator[str]:
    """The square, the root or the inverse of what is expected."""
    if np.any(np.abs(expected) < 1e-6) or np.allclose(np.abs(expected), 1.0):
        return
    functions: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
        ("le carré", np.square), ("la racine carrée", np.sqrt), ("l’inverse", np.reciprocal),
    )  # fmt: skip
    for word, function in functions:
        if _are_equal_arrays(got, np.asarray(function(expected))):
            yield f"C’est {word} de ce qui est attendu."


def _tell_common_offset(expected: Floats, got: Floats) -> Iterator[str]:
    """The same difference everywhere."""
    if got.size < 3:
        return
    difference = got - expected
    step = float(difference.flat[0])
    if _are_equal_arrays(difference, np.full_like(difference, step)):
        yield f"L’écart est le même partout : {number(abs(step), 5)} de {'trop' if step > 0 else 'moins'}."


def _tell_permuted_values(expected: Floats, got: Floats) -> Iterator[str]:
    """The right values in other places."""
    if got.ndim != 1 or got.size < 3 or not _are_equal_arrays(np.sort(got), np.sort(expected)):
        return
    if _are_equal_arrays(got, expected[::-1]):
        yield "Ce sont les bonnes valeurs, dans l’ordre inverse."
        return
    shift = next((k for k in range(1, got.size) if _are_equal_arrays(got, np.roll(expected, k))), 0)
    where = f"décalées de {shift} rang{'s' if shift > 1 else ''}" if shift else "à d’autres places"
    yield f"Ce sont les bonnes valeurs, {where}."


def _tell_wrong_entry_count(expected: Floats, got: Floats) -> Iterator[str]:
    """How many entries are wrong, and whether they make one row or one column."""
    if got.size < MANY:
        return
    wrong = np.abs(got - expected) > EXACT * np.maximum(1.0, np.abs(expected))
    count = int(wrong.sum())
    if not 0 < count < got.size:
        return
    where = ""
    if got.ndim == 2:
        rows, columns = np.flatnonzero(wrong.any(axis=1)), np.flatnonzero(wrong.any(axis=0))
        where = _row_or_column_text("ligne", rows, len(wrong)) or _row_or_column_text(
            "colonne", columns, wrong.shape[1]
        )
    many = count > 1
    wrong_ones = f"{count} valeurs sur {got.size} sont fausses" if many else f"Une valeur sur {got.size} est fausse"
    yield f"{wrong_ones}{where if many else ''}."


def _row_or_column_text(name: str, found: np.ndarray, count: int) -> str:
    return f", toutes dans la {name} {int(found[0])}" if len(found) == 1 < count else ""


_RELATIONS: tuple[Callable[[Floats, Floats], Iterator[str]], ...] = (
    _tell_common_factor,
    _tell_applied_function,
    _tell_lost_matrix_property,
    _tell_common_offset,
    _tell_permuted_values,
    _tell_wrong_entry_count,
)
