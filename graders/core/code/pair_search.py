"""All pairs of mistakes of one function: those that the verdict leaves untried are searched after it."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from graders.core.code.mutants import MAX_COMBINED_MISTAKES, MutantAnswerCache, MutantAnswers, MutantRow
from graders.core.code.mutations import Mutant
from graders.core.code.probes import Probes
from graders.core.code.reachability import all_pieces_compile

#: Mutants that are asked in one exchange, and in all: some 0.4 ms each, in the helper process.
SLICE, MAX_PAIRS = 50, 8000
#: Seconds for the pairs of one function, of which some take long: other searches follow.
MAX_SECONDS = 5.0


@dataclass(frozen=True)
class PairSearch:
    """A search of pairs, until `is_time_spent()`. A program that answers the probes as the one that is searched
    `is_confirmed` if it does so on the inputs of the checks too: of thousands, one may answer alike by chance."""

    is_time_spent: Callable[[], bool]
    is_confirmed: Callable[[Probes, str], bool]


def limit_search_time(slices: Iterator[list[MutantRow]], spent: Callable[[], bool]) -> Iterator[list[MutantRow]]:
    """Yield the slices; raise OutOfTimeError where these take too long, or no time is left."""
    deadline = time.monotonic() + MAX_SECONDS
    for rows in slices:
        if spent() or time.monotonic() > deadline:
            raise OutOfTimeError
        yield rows


class OutOfTimeError(Exception):
    """A search has spent its time."""


def slice_untried_pairs(mutants: MutantAnswerCache, index: int, blamed: Collection[str]) -> Iterator[list[MutantRow]]:
    """Return slices of the mutants with two mistakes of the probes `index` that `mutants` does not keep.

    They are made slice by slice and kept by nobody; the first mistakes of the catalogue come first.
    """
    edits = mutants.effective_edits(index)
    tried = {row.mutant.edits for row in mutants.mutants_with(index, MAX_COMBINED_MISTAKES)}
    styles = [row.mutant for row in mutants.mutants_with(index, 0)]
    places = sorted(itertools.combinations(range(len(edits)), MAX_COMBINED_MISTAKES), key=sum)
    pairs = (chosen for chosen in ((edits[i], edits[j]) for i, j in places) if chosen not in tried)
    made = (mutant for chosen in pairs for mutant in mutants.model.combine(styles, chosen))
    programs = (mutant for mutant in made if mutant.is_possible_in(blamed) and all_pieces_compile(mutant.text))
    return _slice_into_rows(itertools.islice(programs, MAX_PAIRS))


def _slice_into_rows(mutants: Iterator[Mutant]) -> Iterator[list[MutantRow]]:
    while taken := list(itertools.islice(mutants, SLICE)):
        yield [MutantRow(mutant, MutantAnswers()) for mutant in taken]
