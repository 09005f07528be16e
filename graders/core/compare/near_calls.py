"""Calls that differ from one in a single number, or in one row less, the smallest change first.

A wrong answer beside the right one to a near call shows what the mistake depends on, and claims nothing of others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graders.core.compare.changed_arguments import are_probabilities
from graders.core.contract.values import Arguments, Floats, Value
from graders.typography import elided

#: Numbers of an array of which one is changed, since among many one is right by chance; near calls in all.
MAX_ENTRIES, MAX_NEAR = 4, 60


@dataclass(frozen=True)
class NearCall:
    """The arguments of a call, and in French what they have of their own: « avec r = 1 », « sans la
    dernière valeur de z »."""

    words: str
    call: Arguments


def iter_near_calls(names: tuple[str, ...], call: Arguments) -> Iterator[NearCall]:
    """Yield calls like this one in all but one number, then in all but one row of an array, or those off a diagonal.

    Symmetric arrays stay so, their diagonals stay positive, and shares of 1 are left alone.
    """
    changes = [
        (size, NearCall(words, (*call[:index], value, *call[index + 1 :])))
        for index, (name, old) in enumerate(zip(names, call, strict=False))
        for size, words, value in _iter_argument_changes(name, old)
    ]
    changes.sort(key=lambda change: change[0])
    yield from (near for _, near in changes[:MAX_NEAR])


def _iter_argument_changes(name: str, old: Value) -> Iterator[tuple[int, str, Value]]:
    """Yield other values of an argument, each with a rank of how much it changes, and its words."""
    if isinstance(old, bool):
        return
    if isinstance(old, int | float):
        for new in _simpler_numbers(old):
            yield 0, f"avec {name} = {_french_number(new)}", new
    elif isinstance(old, np.ndarray) and old.dtype.kind == "f" and np.isfinite(old).all() and old.ndim in (1, 2):
        yield from _iter_array_changes(name, old)


def _simpler_numbers(old: float) -> list[float]:
    """Return simpler numbers of the same type: 1, 0, those next to it, the opposite."""
    numbers = (1, 0, old + 1, old - 1) if isinstance(old, int) else (1.0, 0.0, float(round(old)), -old)
    return [new for new in dict.fromkeys(numbers) if new != old]


def _iter_array_changes(name: str, old: Floats) -> Iterator[tuple[int, str, Floats]]:
    is_square = old.ndim == 2 and old.shape[0] == old.shape[1] > 1
    is_symmetric = is_square and np.array_equal(old, old.T)
    is_share = old.ndim == 1 and are_probabilities(old)
    if old.size <= MAX_ENTRIES and not is_share:
        for place in np.ndindex(old.shape):
            if is_symmetric and place[0] > place[1]:
                continue
            for new in (1.0,) if is_symmetric and place[0] == place[1] else (0.0, 1.0):
                if old[place] == new or (is_symmetric and new and place[0] != place[1]):
                    continue
                places = sorted({place, place[::-1]}) if is_symmetric else [place]
                changed = old.copy()
                for each in places:
                    changed[each] = new
                entries = [f"{name}[{', '.join(map(str, each))}]" for each in places]
                yield 1, f"avec {' = '.join(entries)} = {_french_number(new)}", changed
    if is_square:
        if is_symmetric and not np.array_equal(old, np.diag(np.diag(old))):
            yield 2, f"avec {name} réduit à sa diagonale", np.diag(np.diag(old))
    elif len(old) > 1 and not is_share:
        noun = "ligne" if old.ndim == 2 else "valeur"
        of_name = elided("de", name)
        yield 3, f"sans la dernière {noun} {of_name}", old[:-1]
        if len(old) > 2:
            yield 4, f"sans la première {noun} {of_name}", old[1:]
            yield 5, f"avec la première {noun} {of_name} seule", old[:1]


def _french_number(number: float) -> str:
    return f"{number:g}".replace(".", ",").replace("-", "−")
