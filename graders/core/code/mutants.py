"""What the mutants of an exercise answer to its probes: kept, since it never changes."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graders.core.code.answer_arrays import AnswerColumn, AnswerSequence
from graders.core.code.mutations import Edit, Model, Mutant
from graders.core.code.probes import Facet, ProbeAnswer, ProbeFault, Probes, same_probe_answer
from graders.core.code.reachability import PIECE_SEPARATOR, CodePiece, reachable_pieces
from graders.core.contract.copies import copy_value
from graders.core.contract.local import call_function, kit_names
from graders.core.contract.values import Arguments

#: How many mistakes are sought together; one more where a facet tells two of them already.
MAX_COMBINED_MISTAKES = 2
#: Of how many programs with several mistakes, each of which is tried once in the life of a process (0.2 to 0.5 ms).
MAX_COMBINED_MUTANTS = 1500
#: In how many of its ways each mistake is tried beside another.
MAX_WAYS_COMBINED = 2
MAX_EXTENDED_MUTANTS = 20


@dataclass(eq=False)
class MutantAnswers:
    """What mutants in which a function reaches the same text have answered so far."""

    answers: list[ProbeAnswer] = field(default_factory=list)
    rest: Iterator[ProbeAnswer] | None = None
    #: As far as they are there, read.
    packed: AnswerSequence = field(default_factory=AnswerSequence)


@dataclass(frozen=True)
class MutantRow:
    """A mutant, and what it answers."""

    mutant: Mutant
    told: MutantAnswers


class MutantAnswerCache:
    """The programs with some mistakes of a `model`, and those of `whole`, as far as they have been asked the probes."""

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant]) -> None:
        self.model, self.whole, self.probes = model, tuple(whole), tuple(probes)
        self._rows: dict[tuple[int, int], list[MutantRow]] = {}
        self._firsts: dict[tuple[int, int], AnswerColumn] = {}
        self._made: dict[tuple[int, tuple[str, ...]], list[MutantRow]] = {}
        self._edits: dict[int, list[Edit]] = {}
        self._kits: dict[int, dict[str, Any]] = {}
        self._told: dict[tuple[int, bytes], MutantAnswers] = {}

    def count_agreements(self, index: int, row: MutantRow, packed: AnswerSequence) -> int:
        """To how many probes a mutant answers so."""
        probes, count = self.probes[index], len(packed.answers)
        if probes.same is not same_probe_answer or count < len(probes.calls):
            return sum(probes.same(self._answer(index, row, k), one) for k, one in enumerate(packed.answers))
        return sum(self._read(index, row, count).agreement(packed))

    def _read(self, index: int, row: MutantRow, count: int) -> AnswerSequence:
        """So many of its answers at least, where it has so many to give."""
        for k in range(len(row.told.packed.answers), count):
            row.told.packed.add(self._answer(index, row, k))
        return row.told.packed

    def matching_first_answer(self, index: int, mistakes: int, answer: ProbeAnswer) -> Sequence[MutantRow]:
        """The mutants with so many mistakes, but for those that do not answer the first probe so."""
        rows, probes, key = self.mutants_with(index, mistakes), self.probes[index], (index, mistakes)
        if probes.same is not same_probe_answer or probes.compared == 0:
            return rows
        if key not in self._firsts:
            self._firsts[key] = AnswerColumn([self._answer(index, row, 0) for row in rows])
        return [rows[place] for place in self._firsts[key].indices_of(answer)]

    def matches(self, index: int, row: MutantRow, packed: AnswerSequence) -> bool:
        """Does the mutant answer every probe so?"""
        probes, answers = self.probes[index], packed.answers[: self.probes[index].compared]
        if probes.same is not same_probe_answer:
            return all(probes.same(self._answer(index, row, k), answer) for k, answer in enumerate(answers))
        if answers and len(row.told.packed.answers) >= len(answers) == len(packed.answers):
            return all(row.told.packed.agreement(packed))
        return all(self._read(index, row, k + 1).agrees_at(packed, k) for k in range(len(answers)))

    def _fits_in(self, facet: Facet, index: int, row: MutantRow, answers: Sequence[ProbeAnswer]) -> bool:
        """Does the mutant answer every probe so, in this facet?"""
        probes = self.probes[index]
        return all(
            probes.same(facet(probes.calls[k], self._answer(index, row, k)), facet(probes.calls[k], answer))
            for k, answer in enumerate(answers[: probes.compared])
        )

    def mutants_with(self, index: int, mistakes: int) -> list[MutantRow]:
        key = (index, mistakes)
        if key not in self._rows:
            if mistakes == 0:
                made = self.model.correct_versions()
            elif mistakes == 1:
                made = itertools.chain(self.model.mutants(self.model.edits, 1), self.whole)
            else:
                made = itertools.islice(self._together(index, mistakes), MAX_COMBINED_MUTANTS)
            self._rows[key] = [self._row(index, mutant) for mutant in made]
        return self._rows[key]

    def _row(self, index: int, mutant: Mutant) -> MutantRow:
        """Another row's answers, where the function of the probes reaches the same text in both."""
        key = index, _digest(reachable_pieces(mutant.text, self.probes[index].function))
        return MutantRow(mutant, self._told.setdefault(key, MutantAnswers()))

    def _together(self, index: int, mistakes: int) -> Iterator[Mutant]:
        """Programs with several mistakes, each made in its most usual ways, those of the catalogue's head first."""
        taken: Counter[str] = Counter()
        usual = []
        for edit in self._telling(index):
            taken[edit.id] += 1
            if taken[edit.id] <= MAX_WAYS_COMBINED:
                usual.append(edit)
        styles = [row.mutant for row in self.mutants_with(index, 0)]
        for _, chosen in sorted(
            (
                (sum(places), [usual[k] for k in places])
                for places in itertools.combinations(range(len(usual)), mistakes)
            ),
            key=lambda pair: pair[0],
        ):
            yield from self.model.combine(styles, chosen)

    def _telling(self, index: int) -> list[Edit]:
        """The edits that change an answer to these probes."""
        if index not in self._edits:
            calls = range(len(self.probes[index].calls))
            rights = {
                row.told: AnswerSequence([self._answer(index, row, k) for k in calls])
                for row in self.mutants_with(index, 0)
            }
            edited = {
                row.told: row for row in self.mutants_with(index, 1) if row.mutant.edits and row.told not in rights
            }
            telling = {
                told
                for told, row in edited.items()
                if not any(self.matches(index, row, right) for right in rights.values())
            }
            edits = {row.mutant.edits for row in self.mutants_with(index, 1) if row.told in telling}
            self._edits[index] = [edit for edit in self.model.edits if (edit,) in edits]
        return self._edits[index]

    def mutants_making(self, index: int, ids: Sequence[str]) -> Sequence[MutantRow]:
        """The mutants that make just these mistakes."""
        key = index, tuple(ids)
        if key not in self._made:
            edits = [edit for edit in self.model.edits if edit.id in ids]
            self._made[key] = [self._row(index, mutant) for mutant in self.model.mutants(edits, len(ids))]
        return self._made[key]

    def extended_mutants(self, index: int, answers: Sequence[ProbeAnswer]) -> Iterator[MutantRow]:
        """The mutants of a facet that fits, with one mistake more."""
        facet = self.probes[index].facet
        if facet is None:
            return
        begun = [
            row for row in self.mutants_with(index, MAX_COMBINED_MISTAKES) if self._fits_in(facet, index, row, answers)
        ]
        for row in begun[:MAX_EXTENDED_MUTANTS]:
            yield from (
                MutantRow(mutant, MutantAnswers())
                for mutant in self.model.with_one_more(row.mutant, self._telling(index))
            )

    def _answer(self, index: int, row: MutantRow, k: int) -> ProbeAnswer:
        """What a mutant answers to probe k, having answered those before."""
        probes, told = self.probes[index], row.told
        if k == 0 and not told.answers:  # of most mutants no more is asked: nothing is kept to go on with
            told.answers = list(self._asked(index, row, probes.calls[:1]))
        while len(told.answers) <= k:
            if told.rest is None:
                told.rest = itertools.islice(self._asked(index, row, probes.calls), len(told.answers), None)
            told.answers.append(next(told.rest))
        return told.answers[k]

    def _asked(self, index: int, row: MutantRow, calls: Sequence[Arguments]) -> Iterator[ProbeAnswer]:
        probes = self.probes[index]
        return _answers(reachable_pieces(row.mutant.text, probes.function), probes, self._names(index), calls)

    def _names(self, index: int) -> dict[str, Any]:
        """The names that a mutant finds: the kit's, made once for all of them unless they draw at random."""
        probes = self.probes[index]
        if probes.random or index not in self._kits:
            self._kits[index] = {"__name__": "mutant", **kit_names(probes.kit), **probes.given}
        return dict(self._kits[index])


def _answers(
    pieces: Sequence[CodePiece], probes: Probes, names: dict[str, Any], calls: Sequence[Arguments]
) -> Iterator[ProbeAnswer]:
    """What these pieces of a mutant, which is our own code, answer with `names`, where they leave their own."""
    for piece in pieces:
        exec(piece.code, names)
    for args in calls:
        given = copy_value(args)
        try:
            with np.errstate(all="ignore"):
                value = call_function(names, probes.function, given)
        except Exception as error:
            yield ProbeFault(type(error).__name__)
        else:
            yield probes.read(args, value)


def _digest(pieces: Sequence[CodePiece]) -> bytes:
    """Kept for each text that is asked, where the texts themselves would take megabytes."""
    return hashlib.blake2b(PIECE_SEPARATOR.join(piece.text for piece in pieces).encode(), digest_size=16).digest()
