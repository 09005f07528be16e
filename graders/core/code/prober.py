"""Probes: small inputs made by hand, whose answers tell one mistake apart from the others.

They are asked only once some check has failed, and are the same whatever the seed: so is the name. The answers are
compared with those of the exercise's mutants (`mutations`), first with one mistake, then with two together, then three.
A name is given with full confidence or not at all: every probe must be answered as the mutant answers it, at least one
of them wrongly, and where mutants of several mistakes agree, only the mistakes that all of them make are named.
What no mutant reproduces is left to `rules`, which know a mistake by what several answers have in common.
"""

from __future__ import annotations

import copy
import itertools
import threading
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import CodeType
from typing import Any

import numpy as np

from graders.core.code.mutations import Edit, Model, Mutant
from graders.core.code.probes import Facet, Fault, Probes, Rule, Seen, Shown, same_seen, seen
from graders.core.code.runner import Runner
from graders.core.compare.slips import SLIPS
from graders.core.contract.local import called, kit_names
from graders.core.contract.program import KitSettings, Program, StudentFault
from graders.core.contract.values import Arguments

#: How many mistakes are sought together; one more where a facet tells two of them already.
DEEP = 2
#: Of how many programs with several mistakes, each of which is tried once in the life of a process (0.2 to 0.5 ms).
MOST_TOGETHER = 1500
#: In how many of its ways each mistake is tried beside another.
USUAL_WAYS = 2
MOST_EXTENDED = 20
#: The slips of a function that answers the same input otherwise the second time: by what it keeps, or by chance.
MEMORY, CHANCE = "memoire", "hasard"
OTHER_SEED = 1
#: Seconds that all the probes may take a program: one that is slower is not named by them.
LONGEST = 2.0


@dataclass
class _Row:
    """A mutant and its answers so far."""

    mutant: Mutant
    answers: list[Seen] = field(default_factory=list)
    rest: Iterator[Seen] | None = None


class Prober:
    """Recognises mistakes by probes; keeps what the mutants answer, which never changes.

    `whole` are programs that make one mistake in another way than by an edit of the model.
    """

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant] = ()) -> None:
        self.model = model
        self.whole = tuple(whole)
        self.probes = tuple(probes)
        self._rows: dict[tuple[int, int], list[_Row]] = {}
        self._edits: dict[int, list[Edit]] = {}
        self._lock = threading.Lock()

    @property
    def functions(self) -> frozenset[str]:
        return frozenset(probes.function for probes in self.probes)

    def recognise(
        self, runner: Runner, functions: Collection[str], alone: Collection[str]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The ids of the mistakes that the program makes in these functions, the first one first; none when unsure.

        `alone` are the functions that failed a check of their own.
        Then those of the last rules, for when nothing else finds a name.
        """
        found: list[str] = []
        last: list[str] = []
        for index, answers, unlike in self._asked(runner, functions, alone):
            if unlike is not None:
                found += [one for one in (unlike,) if one not in found]
                continue
            with self._lock:
                names = self._explained(index, answers, found, functions)
                found += [one for one in names if one not in found]
                if not names:
                    last += self._last(index, answers)
        return tuple(found), tuple(last)

    def nearest(self, index: int, answers: Sequence[Seen]) -> Sequence[Seen]:
        """What is right, in the style that is nearest to these answers to the probes of that number."""
        with self._lock:
            right = self._right(index, answers)
        return answers if right is None else right

    def _last(self, index: int, answers: Sequence[Seen]) -> Sequence[str]:
        probes = self.probes[index]
        right = self._right(index, answers)
        return () if right is None else _ruled(probes.last_rules, Shown(probes.calls, answers, right, probes.same))

    def _asked(
        self, runner: Runner, functions: Collection[str], alone: Collection[str]
    ) -> Iterator[tuple[int, list[Seen], str | None]]:
        """What a program launched afresh, which remembers nothing of the checks, answers to the probes of functions.

        Beside the answers, MEMORY or CHANCE when the first call made once more is not answered as the first time. The
        program is then launched once more, with another seed, and asked all that it was asked: what it keeps of the
        probes before is then the same, what it draws is not.
        """
        chosen = [
            (index, probes)
            for index, probes in enumerate(self.probes)
            if probes.function in functions and not probes.unless.intersection(alone)
        ]
        deadline = time.monotonic() + LONGEST
        for _, group in itertools.groupby(chosen, key=lambda pair: id(pair[1].kit)):
            indices, asked = zip(*group, strict=True)
            told = _told(runner, asked, asked[0].kit, deadline)
            unlike = [_differs(probes, answers) for probes, answers in zip(asked, told, strict=False)]
            retold: Sequence[list[Seen]] = ()
            if any(unlike):
                retold = _told(runner, asked, _reseeded(asked[0].kit), time.monotonic() + LONGEST)
            for k, answers in enumerate(told):
                if len(answers) > len(asked[k].calls):
                    again = retold[k] if retold and unlike[k] else ()
                    yield indices[k], answers[:-1], _reason(answers, again)

    def _explained(
        self, index: int, answers: list[Seen], known: Sequence[str], blamed: Collection[str]
    ) -> Sequence[str]:
        probes = self.probes[index]
        right = self._right(index, answers)
        if right is None:
            return ()
        if known and any(self._fits(index, row, answers) for row in self._with(index, known)):
            return ()  # a mistake found in another function is all that there is to this one
        shown = Shown(probes.calls, answers, right, probes.same)
        told = [k for k in shown.wrong() if probes.compared is None or k < probes.compared]
        fails = all(isinstance(answer, Fault | str | None) for answer in answers)
        for mistakes, rows in enumerate(self._candidates(index, answers) if told else (), 1):
            if fails and mistakes > 1:
                break  # exceptions and no value alone tell too little: some pair of mistakes always gives the same ones
            fits = [row for row in rows if row.mutant.speaks_of(blamed) and self._fits(index, row, answers)]
            if fits:
                return _agreed(fits) or _ruled(probes.rules, shown)
        return _ruled(probes.rules, shown)

    def _candidates(self, index: int, answers: Sequence[Seen]) -> Iterator[Iterable[_Row]]:
        """What may explain the answers, the fewest mistakes first; what costs more is made when nothing else does."""
        for mistakes in range(1, DEEP + 1):
            yield self._all(index, mistakes)
        yield self._extended(index, answers)

    def _right(self, index: int, answers: Sequence[Seen]) -> Sequence[Seen] | None:
        """What is right, in the nearest style; None when the answers are."""
        rows = self._all(index, 0)
        same = self.probes[index].same
        agreeing = [sum(same(self._answer(index, row, k), one) for k, one in enumerate(answers)) for row in rows]
        best = agreeing.index(max(agreeing))
        return None if agreeing[best] == len(answers) else rows[best].answers

    def _fits(self, index: int, row: _Row, answers: Sequence[Seen], facet: Facet | None = None) -> bool:
        """Does the mutant answer every probe so (in this facet alone)?"""
        for k, answer in enumerate(answers[: self.probes[index].compared]):
            one, other = self._answer(index, row, k), answer
            if facet is not None:
                one, other = facet(self.probes[index].calls[k], one), facet(self.probes[index].calls[k], other)
            if not self.probes[index].same(one, other):
                return False
        return True

    def _all(self, index: int, mistakes: int) -> list[_Row]:
        key = (index, mistakes)
        if key not in self._rows:
            if mistakes == 0:
                made = self.model.right()
            elif mistakes == 1:
                made = itertools.chain(self.model.mutants(self.model.edits, 1), self.whole)
            else:
                made = itertools.islice(self._together(index, mistakes), MOST_TOGETHER)
            self._rows[key] = [_Row(mutant) for mutant in made]
        return self._rows[key]

    def _together(self, index: int, mistakes: int) -> Iterator[Mutant]:
        """Programs with several mistakes, each made in its most usual ways, those of the catalogue's head first."""
        taken: Counter[str] = Counter()
        usual = []
        for edit in self._telling(index):
            taken[edit.id] += 1
            if taken[edit.id] <= USUAL_WAYS:
                usual.append(edit)
        styles = [row.mutant for row in self._all(index, 0)]
        for _, chosen in sorted(
            (
                (sum(places), [usual[k] for k in places])
                for places in itertools.combinations(range(len(usual)), mistakes)
            ),
            key=lambda pair: pair[0],
        ):
            yield from self.model.together(styles, chosen)

    def _telling(self, index: int) -> list[Edit]:
        """The edits that change an answer to these probes."""
        if index not in self._edits:
            calls = range(len(self.probes[index].calls))
            rights = [[self._answer(index, row, k) for k in calls] for row in self._all(index, 0)]
            telling = {
                row.mutant.edits
                for row in self._all(index, 1)
                if row.mutant.edits and not any(self._fits(index, row, right) for right in rights)
            }
            self._edits[index] = [edit for edit in self.model.edits if (edit,) in telling]
        return self._edits[index]

    def _with(self, index: int, ids: Sequence[str]) -> Iterator[_Row]:
        """The mutants that make just these mistakes."""
        edits = [edit for edit in self.model.edits if edit.id in ids]
        yield from (_Row(mutant) for mutant in self.model.mutants(edits, len(ids)))

    def _extended(self, index: int, answers: Sequence[Seen]) -> Iterator[_Row]:
        """The mutants of a facet that fits, with one mistake more."""
        facet = self.probes[index].facet
        if facet is None:
            return
        begun = [row for row in self._all(index, DEEP) if self._fits(index, row, answers, facet)]
        for row in begun[:MOST_EXTENDED]:
            yield from (_Row(mutant) for mutant in self.model.extended(row.mutant, self._telling(index)))

    def _answer(self, index: int, row: _Row, k: int) -> Seen:
        """What a mutant answers to probe k, having answered those before."""
        probes = self.probes[index]
        if k == 0 and not row.answers:  # of most mutants no more is asked: nothing is kept to go on with
            row.answers = list(_answers(row.mutant, probes, probes.calls[:1]))
        while len(row.answers) <= k:
            if row.rest is None:
                row.rest = itertools.islice(_answers(row.mutant, probes, probes.calls), len(row.answers), None)
            row.answers.append(next(row.rest))
        return row.answers[k]


def _ruled(rules: Sequence[Rule], shown: Shown) -> Sequence[str]:
    """What the first rule that knows says."""
    return next(([name] for rule in rules if (name := rule(shown)) is not None), [])


def _agreed(fits: Sequence[_Row]) -> Sequence[str]:
    """The mistakes that all of these make; a usual slip says less than a mistake of the exercise."""
    fits = [row for row in fits if not SLIPS.keys() & set(row.mutant.ids)] or fits
    common = set(fits[0].mutant.ids).intersection(*(row.mutant.ids for row in fits[1:]))
    return [one for one in fits[0].mutant.ids if one in common]


def _told(runner: Runner, asked: Sequence[Probes], kit: KitSettings, deadline: float) -> list[list[Seen]]:
    """What one launch of the student's program answers to all these probes in turn; nothing when it does not start."""
    try:
        with runner.other(kit) as program:
            return [list(_answered(runner, program, probes, deadline)) for probes in asked]
    except StudentFault:
        return []


def _reseeded(kit: KitSettings) -> KitSettings:
    return replace(kit, parameters={**kit.parameters, "seed": OTHER_SEED})


def _differs(probes: Probes, answers: Sequence[Seen]) -> bool:
    """Is the first call, made once more after the others, answered otherwise?"""
    return not probes.random and len(answers) > len(probes.calls) and not same_seen(answers[-1], answers[0])


def _reason(answers: Sequence[Seen], again: Sequence[Seen]) -> str | None:
    """Why the same call was answered otherwise, from what another launch answers; None when that does not tell."""
    if len(again) < len(answers):
        return None
    return MEMORY if all(same_seen(one, other) for one, other in zip(answers, again, strict=True)) else CHANCE


def _answered(runner: Runner, program: Program, probes: Probes, deadline: float) -> Iterator[Seen]:
    """What the student's program answers; cut short by a fault that stops it, or when it takes too long."""
    calls = (*probes.calls, probes.calls[0])
    answers = runner.call_many(program, probes.function, calls, faults=None)
    for args, answer in zip(calls, answers, strict=False):
        if time.monotonic() > deadline or (isinstance(answer, StudentFault) and answer.fatal):
            return
        yield seen(args, answer, probes.read)


def _answers(mutant: Mutant, probes: Probes, calls: Sequence[Arguments]) -> Iterator[Seen]:
    """What a mutant, which is our own code, answers; it shares the kit with the others."""
    names = _kit(probes) if probes.random else dict(_kit(probes))
    for piece in mutant.text.split(BETWEEN):
        exec(_compiled(piece), names)
    for args in calls:
        given = copy.deepcopy(args)
        try:
            with np.errstate(all="ignore"):
                value = called(names, probes.function, given)
        except Exception as error:
            yield Fault(type(error).__name__)
        else:
            yield probes.read(args, value)


#: Between the functions of a model.
BETWEEN = "\n\n\n"


@lru_cache(maxsize=4096)
def _compiled(piece: str) -> CodeType:
    """One function of a model, which most of its mutants share."""
    return compile(piece, "<mutant>", "exec", dont_inherit=True)


_kits: dict[int, dict[str, Any]] = {}


def _kit(probes: Probes) -> dict[str, Any]:
    """The names that the mutants find, made once for all of them unless they draw at random."""
    if probes.random or id(probes) not in _kits:
        _kits[id(probes)] = {"__name__": "mutant", **kit_names(probes.kit), **probes.given}
    return _kits[id(probes)]
