"""Finding a threshold that separates, by the student's own function alone.

What is found grows with the threshold, in any norm. So a threshold at which some scan of the same place is missing
while one of another place is found proves that none separates; otherwise one of the two says which way to go, and
the search goes there by ever longer leaps, then closes in by bisection on the logarithm of the threshold. Powers of ten
from -30 to 30 hold every distance that a signature of distances, of its powers and of its products has; from a
threshold that served another walk, a gap of a factor 2 is met in two or three steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

from graders.core.code.bench import Bench
from graders.core.contract.values import UnreadableError, Value, read_indices
from graders.l20.boucles.readings import is_mask
from graders.l20.boucles.walks import GAP, Walk

HUGE = 1e30
NARROW = 1e-4
FUNCTION = "candidats_boucle"


class Outcome(StrEnum):
    """How a search ended; the words are those that a diagnosis compares."""

    FOUND = "séparés"
    MIXED = "mélangés"
    NEVER = "jamais trouvé"
    ALWAYS = "toujours trouvé"
    REVERSED = "à l'envers"
    REMEMBERS = "se souvient"
    ORDER = "selon l'ordre"
    UNREADABLE = "illisible"


@dataclass(frozen=True)
class Search:
    """The end of a search on `walk`: at `threshold`, from scan `query`, `missed` and `wrong` are scans at fault."""

    walk: Walk
    outcome: Outcome
    threshold: float
    query: int
    found: tuple[int, ...] = ()
    missed: int | None = None
    wrong: int | None = None
    wrong_from: int | None = None
    got: Value = None
    reason: str = ""

    @property
    def found_one(self) -> bool:
        """Does this threshold separate?"""
        return self.outcome is Outcome.FOUND

    @property
    def hopeless(self) -> bool:
        """Too low and too high at once: no threshold separates."""
        return self.missed is not None and self.wrong is not None


def calibrate(bench: Bench, walk: Walk, guess: float | None = None) -> Search:
    """Look for one threshold > 0 that separates for every query of the walk. Raises StudentFault.

    With a `guess`, a threshold that separates on another walk: what was asked again there is not once more, and the
    search goes on below a threshold that finds one scan too many in the place of the right one, as a program does that
    returns the first it meets: whether it fails must not depend on how near the guess was.
    """
    search = _close_in(bench, walk, guess or 1.0, patient=guess is not None)
    if search.outcome is Outcome.FOUND:
        return search if guess else _again(bench, search)
    most = _ask(bench, walk, walk.queries[0], HUGE)
    if most.outcome is Outcome.UNREADABLE:
        return most
    if most.missed is not None:
        return _lost(bench, most)
    if search.outcome is not Outcome.MIXED:
        return search
    # A distance that other places always meet (zero, or negative) is another mistake than one too blunt.
    least = _try(bench, walk, 1.0 / HUGE)
    return search if least.wrong is None else replace(least, outcome=Outcome.ALWAYS, missed=None)


def _again(bench: Bench, search: Search) -> Search:
    """The same scans in another order separate at the same threshold, unless the function remembers other calls.

    Or unless it looks at the order: the program is then launched afresh, to tell.
    """
    turned = search.walk.turned_over()
    again = _try(bench, turned, search.threshold)
    if again.outcome is Outcome.FOUND:
        return search
    with bench.run_with_kit(bench.kit) as fresh:
        remembers = _try(fresh, turned, search.threshold).outcome is Outcome.FOUND
    return replace(again, outcome=Outcome.REMEMBERS if remembers else Outcome.ORDER)


def _lost(bench: Bench, most: Search) -> Search:
    """The largest threshold misses something: is it that the smallest one finds more?"""
    least = _ask(bench, most.walk, most.query, 1.0 / HUGE)
    reversed_ = least.wrong is not None and len(least.found) > len(most.found)
    return replace(least, outcome=Outcome.REVERSED) if reversed_ else replace(most, outcome=Outcome.NEVER)


def _close_in(bench: Bench, walk: Walk, threshold: float, *, patient: bool = False) -> Search:
    low, high, leap = 1.0 / HUGE, HUGE, 2.0
    too_low: Search | None = None
    too_high: Search | None = None
    hopeless: Search | None = None
    while math.log10(high / low) > NARROW:
        search = _try(bench, walk, threshold)
        if search.outcome is not Outcome.MIXED or (search.hopeless and not patient):
            return search
        hopeless = hopeless or (search if search.hopeless else None)
        if search.missed is not None and not search.hopeless:
            low, too_low = search.threshold, search
        else:
            high, too_high = search.threshold, search
        threshold, leap = math.sqrt(low * high), min(leap**2, HUGE)
        if too_high is None:
            threshold = min(threshold, low * leap)
        elif too_low is None:
            threshold = max(threshold, high / leap)
    return hopeless or _closed(too_low, too_high)


def _closed(too_low: Search | None, too_high: Search | None) -> Search:
    """The bisection has closed on the border between missing and too many, or on an end of the range."""
    if too_low is not None and too_high is not None:
        return _joined(too_low, too_high)
    end = too_low or too_high
    assert end is not None, "the bisection took no step"
    return replace(end, outcome=Outcome.NEVER if end is too_low else Outcome.ALWAYS)


def _try(bench: Bench, walk: Walk, threshold: float) -> Search:
    """One threshold, every query. MIXED with only `missed` is too low, with only `wrong` too high."""
    worst: Search | None = None
    for i in walk.queries:
        search = _ask(bench, walk, i, threshold)
        if search.outcome is Outcome.UNREADABLE or search.hopeless:
            return search
        if search.outcome is Outcome.FOUND:
            continue
        if worst is not None and (worst.missed is None) != (search.missed is None):
            return _joined(*((worst, search) if search.missed is None else (search, worst)))
        worst = search
    return worst or Search(walk, Outcome.FOUND, threshold, walk.queries[0])


def _joined(blind: Search, greedy: Search) -> Search:
    """Too low for one query and too high for another, or on either side of the border: no threshold separates."""
    return replace(blind, wrong=greedy.wrong, wrong_from=greedy.wrong_from)


def _ask(bench: Bench, walk: Walk, i: int, threshold: float) -> Search:
    got = bench.call(FUNCTION, walk.scans, i, threshold)
    try:
        indices = read_indices(got)
    except UnreadableError as error:
        return Search(walk, Outcome.UNREADABLE, threshold, i, got=got, reason=str(error))
    if is_mask(got):
        reason = "la fonction renvoie des booléens et non des indices"
        return Search(walk, Outcome.UNREADABLE, threshold, i, got=got, reason=reason)
    # The window of allowed indices has its own check: here only the scans well before i are judged.
    returned = {j for j in indices if 0 <= j <= i - GAP}
    wanted = set(walk.same_place(i))
    missed, extra = min(wanted - returned, default=None), returned - wanted
    wrong = min(extra & walk.alike.keys() or extra, default=None)
    outcome = Outcome.FOUND if missed is None and wrong is None else Outcome.MIXED
    return Search(walk, outcome, threshold, i, tuple(sorted(returned)), missed, wrong, i, got)
