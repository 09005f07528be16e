"""What the answers of a program have to do with the right ones in all calls: a factor, a shift, where they are wrong.

Each sentence states what holds in every call that was made, and no cause.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from graders.core.compare.forms import join_with_and
from graders.core.compare.invariants import tell_invariants, tell_sizes
from graders.core.compare.words import number
from graders.core.contract.values import Arguments, Floats
from graders.typography import elided

#: Relative and absolute error up to which two numbers are the same: finite differences leave a millionth.
EXACT = 1e-5
#: Relative error below which answers are nearly right everywhere; wrong calls that establish a fact.
NEARLY, MIN_WRONG = 0.05, 2
#: Answers of which a common step says something; calls after which « chaque fois » may be said.
MANY, MANY_CALLS = 4, 8


@dataclass(frozen=True)
class Series:
    """The answers of a program to some calls, the right ones beside them, and which are wrong."""

    names: tuple[str, ...]
    calls: Sequence[Arguments]
    got: Sequence[Floats]
    right: Sequence[Floats]
    wrong: Sequence[bool]
    #: The answers as they came back, where some in `got` are replaced by the right ones that they come near to.
    unrounded: Sequence[Floats] = ()


def same(a: Floats, b: Floats) -> bool:
    return a.shape == b.shape and bool(np.allclose(a, b, rtol=EXACT, atol=EXACT))


class Relation(NamedTuple):
    """A French predicate of an answer: « est partout le double de ce qui est attendu ». `says_what`: it says what the
    answers are, and not only where, or in what, they are wrong."""

    words: str
    says_what: bool = True


def tell_relations(series: Series) -> Iterator[Relation]:
    """Yield what holds of the answers to all calls."""
    shapes = [(got.shape, right.shape) for got, right in zip(series.got, series.right, strict=True)]
    if sum(series.wrong) < MIN_WRONG or any(mine != its for mine, its in shapes):
        return
    with np.errstate(all="ignore"):
        # One answer to everything is many things of the right ones, such as the whole part of small numbers.
        for find in (_tell_returned_arguments, *_RELATIONS) if is_constant(series) else _RELATIONS:
            yield from map(Relation, find(series))
        for find in _FLAWS:
            yield from (Relation(words, says_what=False) for words in find(series))


def tell_own_relations(series: Series) -> Iterator[Relation]:
    """Yield what holds of a program's own answers, whatever the right ones are."""
    if sum(series.wrong) >= MIN_WRONG:
        yield from map(Relation, _tell_returned_arguments(series))


def is_constant(series: Series) -> bool:
    """Whether all answers are the same."""
    first = series.got[0]
    return all(got.shape == first.shape and same(got, first) for got in series.got)


def _tell_invariants(series: Series) -> Iterator[str]:
    yield from tell_invariants(series.got, series.right, series.wrong)


def _tell_sizes(series: Series) -> Iterator[str]:
    yield from tell_sizes(series.got, series.right, series.wrong)


def _maps_right_to_got(series: Series, function: Callable[[Floats], Floats]) -> bool:
    """Whether each answer is this function of the right one."""
    return all(same(got, np.asarray(function(right))) for got, right in zip(series.got, series.right, strict=True))


def _tell_scalar_functions(series: Series) -> Iterator[str]:
    found: tuple[tuple[str, Callable[[Floats], Floats]], ...] = (
        ("l’opposé de", np.negative), ("le double de", lambda x: 2.0 * x), ("la moitié de", lambda x: x / 2.0),
        ("le carré de", np.square), ("la racine carrée de", np.sqrt), ("l’inverse de", np.reciprocal),
        ("la valeur absolue de", np.abs), ("le logarithme de", np.log), ("l’exponentielle de", np.exp),
        ("le complément à 1 de", lambda x: 1.0 - x), ("la partie entière de", np.floor),
    )  # fmt: skip
    for words, function in found:
        if _maps_right_to_got(series, function):
            yield f"est partout {words} ce qui est attendu"
            return
    if _maps_right_to_got(series, np.degrees):
        yield "est ce qui est attendu, converti en degrés"
    if all(right.ndim == 2 for right in series.right) and _maps_right_to_got(series, np.transpose):
        yield "est partout la transposée de ce qui est attendu"


def _tell_array_functions(series: Series) -> Iterator[str]:
    """The right arrays summed up, normalised or inverted as matrices."""
    dimensions = {right.ndim for right in series.right}
    if dimensions not in ({1}, {2}) or any(right.shape[-1] < 2 for right in series.right):
        return
    sums = "les sommes cumulées de ce qui est attendu"
    found: dict[str, Callable[[Floats], Floats]] = {
        "est ce qui est attendu, divisé par sa somme": lambda x: x / x.sum(),
        "est ce qui est attendu, divisé par sa plus grande valeur": lambda x: x / x.max(),
        "est ce qui est attendu, divisé par sa norme": lambda x: x / np.linalg.norm(x),
        f"a {sums}": lambda x: x.cumsum() if x.ndim == 1 else np.full_like(x, np.nan),
        f"a, dans chaque ligne, {sums}": lambda x: x.cumsum(axis=-1),
        f"a, dans chaque colonne, {sums}": lambda x: x.cumsum(axis=0),
    }
    if all(right.ndim == 2 and len(right) == right.shape[1] and np.linalg.det(right) for right in series.right):
        found["est la matrice inverse de ce qui est attendu"] = lambda x: np.asarray(np.linalg.inv(x), dtype=np.float64)
    yield from [words for words, function in found.items() if _maps_right_to_got(series, function)][:1]


def _constant_ratio(got: Floats, right: Floats) -> float | None:
    """Return the one factor between two arrays; None where there is none."""
    there = np.abs(right) > 1e-12
    if not there.any() or not same(got[~there], right[~there]):
        return None
    ratios = got[there] / right[there]
    return float(ratios[0]) if np.allclose(ratios, ratios[0], rtol=EXACT) else None


def _tell_factors(series: Series) -> Iterator[str]:
    """The same factor in all calls, or one that an argument gives."""
    if not any(np.abs(right).max(initial=0.0) > 1e-12 for right in series.right):
        return
    ratios = [_constant_ratio(got, right) for got, right in zip(series.got, series.right, strict=True)]
    known = [k for k, right in enumerate(series.right) if np.abs(right).max(initial=0.0) > 1e-12]
    if any(ratios[k] is None or not ratios[k] for k in known) or any(
        not same(series.got[k], series.right[k]) for k in range(len(ratios)) if k not in known
    ):
        return
    factors = np.array([ratios[k] for k in known], dtype=float)
    if np.allclose(factors, factors[0], rtol=EXACT):
        if abs(factors[0] - 1.0) > EXACT and not np.isclose(abs(np.log2(abs(factors[0]))), 1.0):
            yield f"est partout {number(float(factors[0]), 5)} fois ce qui est attendu"
        return
    for words, values in _iter_argument_quantities(series, known):
        for told, factor in ((f"multiplié par {words}", values), (f"divisé par {words}", 1.0 / values)):
            if np.allclose(factors, factor, rtol=EXACT):
                yield f"est partout ce qui est attendu, {told}"
                return


def _iter_argument_quantities(series: Series, known: Sequence[int]) -> Iterator[tuple[str, Floats]]:
    """Yield numbers that the arguments of these calls give, with their words."""
    for index, name in enumerate(series.names):
        values = [series.calls[k][index] for k in known if index < len(series.calls[k])]
        if len(values) < len(known):
            continue
        if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
            numbers = np.array(values, dtype=float)
            yield name, numbers
            yield f"le carré {elided('de', name)}", numbers**2
            yield f"la racine {elided('de', name)}", np.sqrt(numbers)
        elif all(isinstance(value, np.ndarray) and value.ndim and value.size for value in values):
            noun = "lignes" if values[0].ndim == 2 else "valeurs"
            count = np.array([len(value) for value in values], dtype=float)
            yield f"le nombre de {noun} {elided('de', name)}", count
            yield f"la racine du nombre de {noun} {elided('de', name)}", np.sqrt(count)
            yield f"la somme {elided('de', name)}", np.array([value.sum() for value in values], dtype=float)


def _tell_whole_turns(series: Series) -> Iterator[str]:
    """Whole turns too much."""
    gaps = [(got - right).ravel() for got, right in zip(series.got, series.right, strict=True)]
    turns = np.concatenate(gaps) / (2.0 * np.pi)
    if turns.size and np.abs(turns).max() > 0.5 and np.allclose(turns, np.round(turns), atol=EXACT):
        yield "est juste à un nombre entier de tours près"


def _tell_offsets(series: Series) -> Iterator[str]:
    """The same number too much in all calls, or an argument."""
    gaps = [got - right for got, right in zip(series.got, series.right, strict=True)]
    flat = np.concatenate([gap.ravel() for gap in gaps])
    if flat.size and np.ptp(flat) < EXACT and abs(flat[0]) > EXACT and len(gaps) > MIN_WRONG:
        yield f"a partout {number(float(abs(flat[0])), 5)} de {'trop' if flat[0] > 0 else 'moins'}"
        return
    for index, name in enumerate(series.names):
        values = [call[index] if index < len(call) else None for call in series.calls]
        if not all(isinstance(value, int | float | np.ndarray) and not isinstance(value, bool) for value in values):
            continue
        arrays = [np.asarray(value, dtype=float) for value in values]
        if any(array.shape not in ((), gap.shape) for array, gap in zip(arrays, gaps, strict=True)):
            continue
        for sign, words in ((1.0, f"a partout {name} de trop"), (-1.0, f"a partout {name} de moins")):
            pairs = zip(gaps, arrays, strict=True)
            if all(same(gap, sign * np.broadcast_to(array, gap.shape)) for gap, array in pairs):
                yield words
                return


def _tell_permutations(series: Series) -> Iterator[str]:
    """The right numbers at other places."""
    if any(right.ndim == 0 or right.shape[0] < 2 for right in series.right):
        return
    if _maps_right_to_got(series, lambda x: x[::-1]):
        yield "a les bonnes valeurs, dans l’ordre inverse"
        return
    pairs = list(zip(series.got, series.right, strict=True))
    # In two rows an exchange is no evidence: enough longer ones must show it, and all bear it out.
    if sum(bad and len(got) > 2 for bad, (got, _) in zip(series.wrong, pairs, strict=True)) < MIN_WRONG:
        return
    if all(same(np.sort(got, axis=0), np.sort(right, axis=0)) for got, right in pairs):
        yield "a les bonnes valeurs, dans un autre ordre"
    elif all(same(got[1:], right[:-1]) for got, right in pairs):
        yield "a les bonnes valeurs, décalées d’un rang : la première est de trop"
    elif all(same(got[:-1], right[1:]) for got, right in pairs):
        yield "a les bonnes valeurs, décalées d’un rang : la première manque"


def _tell_returned_arguments(series: Series) -> Iterator[str]:
    """An argument, as it was given, or the same answer to everything."""
    if is_constant(series):
        if len(series.calls) < MANY_CALLS:
            yield f"est la même valeur{_tries_text(series)}"
            return
        varied = all(_does_argument_vary(series, index) for index in range(len(series.names)))
        yield f"{'ne dépend d’aucun argument : c’est' if varied else 'est'} chaque fois la même valeur"
        return
    for index, name in enumerate(series.names):
        if all(
            index < len(call)
            and isinstance(call[index], int | float | np.ndarray)
            and same(got, np.asarray(call[index], dtype=float))
            for call, got in zip(series.calls, series.got, strict=True)
        ):
            few = len(series.calls) < MANY_CALLS
            yield f"est {'' if few else 'toujours '}{name}, tel que donné{_tries_text(series) if few else ''}"
            return


def _tries_text(series: Series) -> str:
    return f" dans les {len(series.calls)} essais"


def _does_argument_vary(series: Series, index: int) -> bool:
    """Whether an argument is not the same in all calls, so that the answers could feel it."""
    values = [repr(call[index]) if index < len(call) else "" for call in series.calls]
    return len(set(values)) > 1


def _tell_multiples_of_step(series: Series) -> Iterator[str]:
    """Numbers that are all multiples of a step, where the right ones are not."""
    if any(right.ndim for right in series.right) or len(series.got) < MANY:
        return
    got = np.array(series.unrounded or series.got, dtype=float)
    right = np.array(series.right, dtype=float)
    for step in (1.0, 0.5, 0.25, 0.2, 0.1, 0.05, 0.01):
        off, right_off = (np.abs(values / step - np.round(values / step)) for values in (got, right))
        if off.max() < EXACT and (right_off > 0.01).sum() >= MANY and len(np.unique(got)) >= MANY:
            if any(_is_argument_multiple_of(series, index, step) for index in range(len(series.names))):
                return
            yield f"est toujours un multiple de {number(step)}, ce que n’est pas ce qui est attendu"
            return


def _is_argument_multiple_of(series: Series, index: int, step: float) -> bool:
    """Whether an argument, which is no whole number in all calls, is a multiple of this step in each."""
    values = [call[index] for call in series.calls if index < len(call) and isinstance(call[index], float)]
    given = np.array(values)
    is_multiple = bool(np.all(np.abs(given / step - np.round(given / step)) < EXACT))
    return given.size > 0 and is_multiple and not np.array_equal(given, np.round(given))


def _tell_wrong_rows_or_columns(series: Series) -> Iterator[str]:
    """The first rows are right and all that follow are not, or one row, or one column alone is wrong."""
    pairs = [
        (got, right) for got, right, bad in zip(series.got, series.right, series.wrong, strict=True) if bad and got.ndim
    ]
    if len(pairs) < max(MIN_WRONG, sum(series.wrong)):
        return
    seen = f"dans les {len(pairs)} essais où il est faux"
    wrong_rows = [np.flatnonzero(_differing_rows(got, right)) for got, right in pairs]
    lengths = [len(got) for got, _ in pairs]
    noun = "ligne" if pairs[0][0].ndim == 2 else "valeur"
    if all(length > 1 for length in lengths):
        begins = {int(rows[0]) for rows in wrong_rows if len(rows)}
        if begins == {1} and all(len(rows) == length - 1 for rows, length in zip(wrong_rows, lengths, strict=True)):
            yield f"commence bien : sa première {noun} est juste, et plus aucune ensuite, {seen}"
            return
        if all(list(rows) == [length - 1] for rows, length in zip(wrong_rows, lengths, strict=True)):
            yield f"n’est faux qu’à sa dernière {noun} {seen}"
            return
        if all(list(rows) == [0] for rows in wrong_rows):
            yield f"n’est faux qu’à sa première {noun} {seen}"
            return
    if all(got.ndim == 2 for got, _ in pairs):
        columns = {tuple(np.flatnonzero(_differing_rows(got.T, right.T)).tolist()) for got, right in pairs}
        if len(columns) == 1 and 0 < len(only := columns.pop()) < pairs[0][0].shape[1]:
            told = join_with_and([*map(str, only)])
            yield f"n’est faux que dans {'la colonne' if len(only) == 1 else 'les colonnes'} {told} {seen}"
    elif len(set(lengths)) == 1 and 1 < lengths[0] <= 6:
        places = {tuple(rows.tolist()) for rows in wrong_rows}
        if len(places) == 1 and 0 < len(only := places.pop()) < lengths[0]:
            told = join_with_and([*map(str, only)])
            yield f"n’est faux qu’{'à l’indice' if len(only) == 1 else 'aux indices'} {told} {seen}"


def _differing_rows(got: Floats, right: Floats) -> np.ndarray:
    """Return which rows differ."""
    off = ~np.isclose(got, right, rtol=EXACT, atol=EXACT)
    return np.asarray(off.reshape(len(off), -1).any(axis=1))


def _tell_near_values(series: Series) -> Iterator[str]:
    """Answers that are nearly right in all calls."""
    errors = [
        float(np.abs(got - right).max(initial=0.0) / max(float(np.abs(right).max(initial=0.0)), 1e-3))
        for got, right in zip(series.got, series.right, strict=True)
    ]
    worst = max(errors)
    if np.isfinite(worst) and 0.0 < worst < NEARLY and len(errors) > MIN_WRONG:
        percent = number(float(f"{100.0 * worst:.1g}"))
        yield f"n’est juste qu’à peu près : dans ces appels, à {percent} % de la plus grande valeur attendue"


#: The relations, the most telling first.
_RELATIONS = (
    _tell_whole_turns, _tell_scalar_functions, _tell_array_functions, _tell_factors, _tell_offsets, _tell_permutations,
    _tell_returned_arguments, _tell_multiples_of_step, _tell_near_values,
)  # fmt: skip
#: What says no more than where the answers are wrong, or which property they have not.
_FLAWS = (_tell_invariants, _tell_wrong_rows_or_columns, _tell_sizes)
