"""What the mutants of an exercise answer to its probes: kept, since it never changes."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.code.mutations import Edit, Model, Mutant
from graders.core.code.packed import Column, Packed
from graders.core.code.probes import Facet, Fault, Probes, Seen, same_seen
from graders.core.code.reached import BETWEEN, Piece, reached
from graders.core.contract.copies import copied
from graders.core.contract.local import called, kit_names
from graders.core.contract.values import Arguments

#: How many mistakes are sought together; one more where a facet tells two of them already.
DEEP = 2
#: Of how many programs with several mistakes, each of which is tried once in the life of a process (0.2 to 0.5 ms).
MOST_TOGETHER = 1500
#: In how many of its ways each mistake is tried beside another.
USUAL_WAYS = 2
MOST_EXTENDED = 20


@dataclass(eq=False)
class Told:
    """What mutants in which a function reaches the same text have answered so far."""

    answers: list[Seen] = field(default_factory=list)
    rest: Iterator[Seen] | None = None
    #: As far as they are there, read.
    packed: Packed = field(default_factory=Packed)


@dataclass(frozen=True)
class Row:
    """A mutant, and what it answers."""

    mutant: Mutant
    told: Told


class Mutants:
    """The programs with some mistakes of a `model`, and those of `whole`, as far as they have been asked the probes."""

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant]) -> None:
        self.model, self.whole, self.probes = model, tuple(whole), tuple(probes)
        self._rows: dict[tuple[int, int], list[Row]] = {}
        self._firsts: dict[tuple[int, int], Column] = {}
        self._made: dict[tuple[int, tuple[str, ...]], list[Row]] = {}
        self._edits: dict[int, list[Edit]] = {}
        self._kits: dict[int, dict[str, Any]] = {}
        self._told: dict[tuple[int, bytes], Told] = {}

    def agreeing(self, index: int, row: Row, packed: Packed) -> int:
        """To how many probes a mutant answers so."""
        probes, count = self.probes[index], len(packed.answers)
        if probes.same is not same_seen or count < len(probes.calls):
            return sum(probes.same(self._answer(index, row, k), one) for k, one in enumerate(packed.answers))
        return sum(self._read(index, row, count).agreeing(packed))

    def _read(self, index: int, row: Row, count: int) -> Packed:
        """So many of its answers at least, where it has so many to give."""
        for k in range(len(row.told.packed.answers), count):
            row.told.packed.add(self._answer(index, row, k))
        return row.told.packed

    def beginning(self, index: int, mistakes: int, answer: Seen) -> Sequence[Row]:
        """The mutants with so many mistakes, but for those that do not answer the first probe so."""
        rows, probes, key = self.all(index, mistakes), self.probes[index], (index, mistakes)
        if probes.same is not same_seen or probes.compared == 0:
            return rows
        if key not in self._firsts:
            self._firsts[key] = Column([self._answer(index, row, 0) for row in rows])
        return [rows[place] for place in self._firsts[key].same_as(answer)]

    def fits(self, index: int, row: Row, packed: Packed) -> bool:
        """Does the mutant answer every probe so?"""
        probes, answers = self.probes[index], packed.answers[: self.probes[index].compared]
        if probes.same is not same_seen:
            return all(probes.same(self._answer(index, row, k), answer) for k, answer in enumerate(answers))
        if answers and len(row.told.packed.answers) >= len(answers) == len(packed.answers):
            return all(row.told.packed.agreeing(packed))
        return all(self._read(index, row, k + 1).same(packed, k) for k in range(len(answers)))

    def _fits_in(self, facet: Facet, index: int, row: Row, answers: Sequence[Seen]) -> bool:
        """Does the mutant answer every probe so, in this facet?"""
        probes = self.probes[index]
        return all(
            probes.same(facet(probes.calls[k], self._answer(index, row, k)), facet(probes.calls[k], answer))
            for k, answer in enumerate(answers[: probes.compared])
        )

    def all(self, index: int, mistakes: int) -> list[Row]:
        key = (index, mistakes)
        if key not in self._rows:
            if mistakes == 0:
                made = self.model.right()
            elif mistakes == 1:
                made = itertools.chain(self.model.mutants(self.model.edits, 1), self.whole)
            else:
                made = itertools.islice(self._together(index, mistakes), MOST_TOGETHER)
            self._rows[key] = [self._row(index, mutant) for mutant in made]
        return self._rows[key]

    def _row(self, index: int, mutant: Mutant) -> Row:
        """Another row's answers, where the function of the probes reaches the same text in both."""
        key = index, _digest(reached(mutant.text, self.probes[index].function))
        return Row(mutant, self._told.setdefault(key, Told()))

    def _together(self, index: int, mistakes: int) -> Iterator[Mutant]:
        """Programs with several mistakes, each made in its most usual ways, those of the catalogue's head first."""
        taken: Counter[str] = Counter()
        usual = []
        for edit in self._telling(index):
            taken[edit.id] += 1
            if taken[edit.id] <= USUAL_WAYS:
                usual.append(edit)
        styles = [row.mutant for row in self.all(index, 0)]
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
            rights = {row.told: Packed([self._answer(index, row, k) for k in calls]) for row in self.all(index, 0)}
            edited = {row.told: row for row in self.all(index, 1) if row.mutant.edits and row.told not in rights}
            telling = {
                told
                for told, row in edited.items()
                if not any(self.fits(index, row, right) for right in rights.values())
            }
            edits = {row.mutant.edits for row in self.all(index, 1) if row.told in telling}
            self._edits[index] = [edit for edit in self.model.edits if (edit,) in edits]
        return self._edits[index]

    def making(self, index: int, ids: Sequence[str]) -> Sequence[Row]:
        """The mutants that make just these mistakes."""
        key = index, tuple(ids)
        if key not in self._made:
            edits = [edit for edit in self.model.edits if edit.id in ids]
            self._made[key] = [self._row(index, mutant) for mutant in self.model.mutants(edits, len(ids))]
        return self._made[key]

    def extended(self, index: int, answers: Sequence[Seen]) -> Iterator[Row]:
        """The mutants of a facet that fits, with one mistake more."""
        facet = self.probes[index].facet
        if facet is None:
            return
        begun = [row for row in self.all(index, DEEP) if self._fits_in(facet, index, row, answers)]
        for row in begun[:MOST_EXTENDED]:
            yield from (Row(mutant, Told()) for mutant in self.model.extended(row.mutant, self._telling(index)))

    def _answer(self, index: int, row: Row, k: int) -> Seen:
        """What a mutant answers to probe k, having answered those before."""
        probes, told = self.probes[index], row.told
        if k == 0 and not told.answers:  # of most mutants no more is asked: nothing is kept to go on with
            told.answers = list(self._asked(index, row, probes.calls[:1]))
        while len(told.answers) <= k:
            if told.rest is None:
                told.rest = itertools.islice(self._asked(index, row, probes.calls), len(told.answers), None)
            told.answers.append(next(told.rest))
        return told.answers[k]

    def _asked(self, index: int, row: Row, calls: Sequence[Arguments]) -> Iterator[Seen]:
        probes = self.probes[index]
        return _answers(reached(row.mutant.text, probes.function), probes, self._names(index), calls)

    def _names(self, index: int) -> dict[str, Any]:
        """The names that a mutant finds: the kit's, made once for all of them unless they draw at random."""
        probes = self.probes[index]
        if probes.random or index not in self._kits:
            self._kits[index] = {"__name__": "mutant", **kit_names(probes.kit), **probes.given}
        return dict(self._kits[index])


def _answers(
    pieces: Sequence[Piece], probes: Probes, names: dict[str, Any], calls: Sequence[Arguments]
) -> Iterator[Seen]:
    """What these pieces of a mutant, which is our own code, answer with `names`, where they leave their own."""
    for piece in pieces:
        exec(piece.code, names)
    for args in calls:
        given = copied(args)
        try:
            with np.errstate(all="ignore"):
                value = called(names, probes.function, given)
        except Exception as error:
            yield Fault(type(error).__name__)
        else:
            yield probes.read(args, value)


def _digest(pieces: Sequence[Piece]) -> bytes:
    """Kept for each text that is asked, where the texts themselves would take megabytes."""
    return hashlib.blake2b(BETWEEN.join(piece.text for piece in pieces).encode(), digest_size=16).digest()
