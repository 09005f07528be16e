"""Properties that all right answers of a function have and its wrong ones have not, and sizes that are off on one side.

A method unlike the solution's is told by them what is wrong with its answers: that a covariance is not symmetric, that
weights do not add up to 1, that a variance is too small in each of the calls in which it is wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from graders.core.contract.values import Floats

#: Right answers that have a property; wrong ones that are all without it; wrong ones that are all on one side.
MIN_ANSWERS, MIN_WITHOUT, MIN_SIZES = 4, 4, 8
SLACK = 1e-6


class Invariant(NamedTuple):
    """A property of an answer: the words of one without it, whether it is one that can have it, and how far it is."""

    words: str
    applies: Callable[[Floats], bool]
    gap: Callable[[Floats], float]


def _is_square(x: Floats) -> bool:
    return x.ndim == 2 and x.shape[0] == x.shape[1] > 1


def _asymmetry(x: Floats) -> float:
    return float(np.abs(x - x.T).max())


def _negative_eigenvalue(x: Floats) -> float:
    return max(0.0, -float(np.linalg.eigvalsh((x + x.T) / 2.0).min()))


def _distance_to_rotations(x: Floats) -> float:
    return float(np.abs(x @ x.T - np.eye(len(x))).max() + abs(np.linalg.det(x) - 1.0))


def _is_row(x: Floats) -> bool:
    return x.ndim == 1 and x.size > 1


def _largest_decrease(x: Floats) -> float:
    return max(0.0, -float(np.diff(x).min()))


def _is_table_of_directions(x: Floats) -> bool:
    return x.ndim == 2 and x.shape[0] > 0 and x.shape[1] in (2, 3)


#: The most particular first.
INVARIANTS = (
    Invariant("n’est pas une rotation", _is_square, _distance_to_rotations),
    Invariant("n’est pas symétrique", _is_square, _asymmetry),
    Invariant("a une valeur propre négative", _is_square, _negative_eigenvalue),
    Invariant("a des lignes qui ne sont pas de longueur 1", _is_table_of_directions,
              lambda x: float(np.abs(np.linalg.norm(x, axis=1) - 1.0).max())),
    Invariant("n’a pas pour somme 1", _is_row, lambda x: abs(float(x.sum()) - 1.0)),
    Invariant("n’est pas rangé dans l’ordre croissant", _is_row, _largest_decrease),
    Invariant("est négatif", lambda x: x.ndim == 0, lambda x: max(0.0, -float(x))),
    Invariant("contient un nombre négatif", lambda x: x.ndim > 0 and x.size > 0, lambda x: max(0.0, -float(x.min()))),
    Invariant("dépasse 1", lambda x: x.ndim == 0, lambda x: max(0.0, float(x) - 1.0)),
)  # fmt: skip


def tell_invariants(got: Sequence[Floats], right: Sequence[Floats], wrong: Sequence[bool]) -> Iterator[str]:
    """Yield a French predicate: « n’est pas symétrique dans les 12 essais où il est faux »."""
    bad = [mine for mine, is_wrong in zip(got, wrong, strict=True) if is_wrong]
    if len(right) < MIN_ANSWERS or len(bad) < MIN_WITHOUT:
        return
    if all(not np.isfinite(mine).all() for mine in bad) and all(np.isfinite(its).all() for its in right):
        yield f"contient nan ou inf {_tries_text(bad)}"
        return
    if not all(np.isfinite(array).all() for array in (*got, *right)):
        return
    for invariant in INVARIANTS:
        if all(map(invariant.applies, (*bad, *right))):
            worst = max(map(invariant.gap, right))
            if worst < SLACK and min(map(invariant.gap, bad)) > 1e-3:
                yield f"{invariant.words} {_tries_text(bad)}, contrairement à ce qui est attendu"
                return


def tell_sizes(got: Sequence[Floats], right: Sequence[Floats], wrong: Sequence[bool]) -> Iterator[str]:
    """Yield a French predicate of numbers, or of diagonals, that are always on one side of the right ones."""
    pairs = [(mine, its) for mine, its, is_wrong in zip(got, right, wrong, strict=True) if is_wrong]
    if len(pairs) < MIN_SIZES or not all(np.isfinite(array).all() for pair in pairs for array in pair):
        return
    if all(_is_square(mine) for mine, _ in pairs):
        pairs = [(np.diag(mine), np.diag(its)) for mine, its in pairs]
        subject = "a une diagonale"
    else:
        subject = "est"
        if any(mine.ndim for mine, _ in pairs):
            return
    if all(np.isin(its, (-1.0, 0.0, 1.0)).all() for its in right):
        return  # a verdict is wrong, not too large
    gaps = [mine - its for mine, its in pairs]
    for sign, words in ((1.0, "trop grand"), (-1.0, "trop petit")):
        if all((sign * gap >= -SLACK).all() and (sign * gap).max() > SLACK for gap in gaps):
            yield f"{subject} {words}{'e' if 'diagonale' in subject else ''} {_tries_text(gaps)}"
            return


def _tries_text(answers: Sequence[Floats]) -> str:
    """The calls in which a property was seen: nothing is said of others."""
    return f"dans les {len(answers)} essais où il est faux"
