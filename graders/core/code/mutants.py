"""Cache of the answers of an exercise's mutants to its probes, which never change."""

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

#: Mistakes that are combined in one mutant; one more where a facet already matches two of them.
MAX_COMBINED_MISTAKES = 2
#: Mutants with several mistakes; each is run once in the life of a process (0.2 to 0.5 ms).
MAX_COMBINED_MUTANTS = 1500
#: Edits of one mistake that are combined with other mistakes.
MAX_WAYS_COMBINED = 2
MAX_EXTENDED_MUTANTS = 20


@dataclass(eq=False)
class MutantAnswers:
    """Answers so far, shared by the mutants in which the probed function reaches the same text."""

    answers: list[ProbeAnswer] = field(default_factory=list)
    pending: Iterator[ProbeAnswer] | None = None
    #: The first of `answers` as arrays; filled on demand.
    sequence: AnswerSequence = field(default_factory=AnswerSequence)


@dataclass(frozen=True)
class MutantRow:
    """A mutant and its answers."""

    mutant: Mutant
    stored: MutantAnswers


class MutantAnswerCache:
    """The mutants of a `model` and the programs `whole`, with their answers to the probes, computed on demand."""

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant]) -> None:
        self.model, self.whole, self.probes = model, tuple(whole), tuple(probes)
        self._rows: dict[tuple[int, int], list[MutantRow]] = {}
        self._first_answers: dict[tuple[int, int], AnswerColumn] = {}
        self._rows_by_ids: dict[tuple[int, tuple[str, ...]], list[MutantRow]] = {}
        self._edits: dict[int, list[Edit]] = {}
        self._kits: dict[int, dict[str, Any]] = {}
        self._answers_by_text: dict[tuple[int, bytes], MutantAnswers] = {}

    def count_agreements(self, index: int, row: MutantRow, sequence: AnswerSequence) -> int:
        """Return how many probes a mutant answers alike."""
        probes, count = self.probes[index], len(sequence.answers)
        if probes.same is not same_probe_answer or count < len(probes.calls):
            return sum(probes.same(self._answer_at(index, row, k), answer) for k, answer in enumerate(sequence.answers))
        return sum(self._fill(index, row, count).agreement(sequence))

    def _fill(self, index: int, row: MutantRow, count: int) -> AnswerSequence:
        """Return a mutant's answers, at least `count` of them as arrays."""
        for k in range(len(row.stored.sequence.answers), count):
            row.stored.sequence.add(self._answer_at(index, row, k))
        return row.stored.sequence

    def matching_first_answer(self, index: int, mistakes: int, answer: ProbeAnswer) -> Sequence[MutantRow]:
        """Return the mutants with that number of mistakes that may answer the first probe alike."""
        rows, probes, key = self.mutants_with(index, mistakes), self.probes[index], (index, mistakes)
        if probes.same is not same_probe_answer or probes.compared == 0:
            return rows
        if key not in self._first_answers:
            self._first_answers[key] = AnswerColumn([self._answer_at(index, row, 0) for row in rows])
        return [rows[position] for position in self._first_answers[key].indices_of(answer)]

    def matches(self, index: int, row: MutantRow, sequence: AnswerSequence) -> bool:
        """Whether the mutant answers every compared probe alike."""
        probes, answers = self.probes[index], sequence.answers[: self.probes[index].compared]
        if probes.same is not same_probe_answer:
            return all(probes.same(self._answer_at(index, row, k), answer) for k, answer in enumerate(answers))
        if answers and len(row.stored.sequence.answers) >= len(answers) == len(sequence.answers):
            return all(row.stored.sequence.agreement(sequence))
        return all(self._fill(index, row, k + 1).agrees_at(sequence, k) for k in range(len(answers)))

    def _matches_facet(self, facet: Facet, index: int, row: MutantRow, answers: Sequence[ProbeAnswer]) -> bool:
        """Whether the mutant answers every compared probe alike in this facet."""
        probes = self.probes[index]
        return all(
            probes.same(facet(probes.calls[k], self._answer_at(index, row, k)), facet(probes.calls[k], answer))
            for k, answer in enumerate(answers[: probes.compared])
        )

    def mutants_with(self, index: int, mistakes: int) -> list[MutantRow]:
        key = (index, mistakes)
        if key not in self._rows:
            if mistakes == 0:
                mutants = self.model.correct_versions()
            elif mistakes == 1:
                mutants = itertools.chain(self.model.mutants(self.model.edits, 1), self.whole)
            else:
                mutants = itertools.islice(self._combined(index, mistakes), MAX_COMBINED_MUTANTS)
            self._rows[key] = [self._row(index, mutant) for mutant in mutants]
        return self._rows[key]

    def _row(self, index: int, mutant: Mutant) -> MutantRow:
        """Return the row of a mutant; mutants in which the function reaches the same text share their answers."""
        key = index, _digest(reachable_pieces(mutant.text, self.probes[index].function))
        return MutantRow(mutant, self._answers_by_text.setdefault(key, MutantAnswers()))

    def _combined(self, index: int, mistakes: int) -> Iterator[Mutant]:
        """Yield mutants with several mistakes, by the first edits of each, in the catalogue's order."""
        taken: Counter[str] = Counter()
        usual = []
        for edit in self._effective_edits(index):
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

    def _effective_edits(self, index: int) -> list[Edit]:
        """Return the edits that change some answer to these probes."""
        if index not in self._edits:
            calls = range(len(self.probes[index].calls))
            rights = {
                row.stored: AnswerSequence([self._answer_at(index, row, k) for k in calls])
                for row in self.mutants_with(index, 0)
            }
            edited = {
                row.stored: row for row in self.mutants_with(index, 1) if row.mutant.edits and row.stored not in rights
            }
            effective = {
                mutant_answers
                for mutant_answers, row in edited.items()
                if not any(self.matches(index, row, right) for right in rights.values())
            }
            edits = {row.mutant.edits for row in self.mutants_with(index, 1) if row.stored in effective}
            self._edits[index] = [edit for edit in self.model.edits if (edit,) in edits]
        return self._edits[index]

    def mutants_making(self, index: int, ids: Sequence[str]) -> Sequence[MutantRow]:
        """Return the mutants that make exactly these mistakes."""
        key = index, tuple(ids)
        if key not in self._rows_by_ids:
            edits = [edit for edit in self.model.edits if edit.id in ids]
            self._rows_by_ids[key] = [self._row(index, mutant) for mutant in self.model.mutants(edits, len(ids))]
        return self._rows_by_ids[key]

    def extended_mutants(self, index: int, answers: Sequence[ProbeAnswer]) -> Iterator[MutantRow]:
        """Yield, for the mutants that match in the facet, those with one mistake more."""
        facet = self.probes[index].facet
        if facet is None:
            return
        begun = [
            row
            for row in self.mutants_with(index, MAX_COMBINED_MISTAKES)
            if self._matches_facet(facet, index, row, answers)
        ]
        for row in begun[:MAX_EXTENDED_MUTANTS]:
            yield from (
                MutantRow(mutant, MutantAnswers())
                for mutant in self.model.with_one_more(row.mutant, self._effective_edits(index))
            )

    def _answer_at(self, index: int, row: MutantRow, k: int) -> ProbeAnswer:
        """Return a mutant's answer to probe k, after all the probes before it."""
        probes, stored = self.probes[index], row.stored
        if k == 0 and not stored.answers:  # of most mutants no more is asked: nothing is kept to go on with
            stored.answers = list(self._run_mutant(index, row, probes.calls[:1]))
        while len(stored.answers) <= k:
            if stored.pending is None:
                stored.pending = itertools.islice(self._run_mutant(index, row, probes.calls), len(stored.answers), None)
            stored.answers.append(next(stored.pending))
        return stored.answers[k]

    def _run_mutant(self, index: int, row: MutantRow, calls: Sequence[Arguments]) -> Iterator[ProbeAnswer]:
        probes = self.probes[index]
        return _answers(reachable_pieces(row.mutant.text, probes.function), probes, self._names(index), calls)

    def _names(self, index: int) -> dict[str, Any]:
        """Return the global names of a mutant: the kit's, built once unless the function draws at random."""
        probes = self.probes[index]
        if probes.random or index not in self._kits:
            self._kits[index] = {"__name__": "mutant", **kit_names(probes.kit), **probes.given}
        return dict(self._kits[index])


def _answers(
    pieces: Sequence[CodePiece], probes: Probes, names: dict[str, Any], calls: Sequence[Arguments]
) -> Iterator[ProbeAnswer]:
    """Yield the answers of a mutant, which is trusted code; its pieces are executed in `names`."""
    for piece in pieces:
        exec(piece.code, names)
    for args in calls:
        arguments = copy_value(args)
        try:
            with np.errstate(all="ignore"):
                value = call_function(names, probes.function, arguments)
        except Exception as error:
            yield ProbeFault(type(error).__name__)
        else:
            yield probes.read(args, value)


def _digest(pieces: Sequence[CodePiece]) -> bytes:
    """Return a key for the text of these pieces: the texts themselves would take megabytes."""
    return hashlib.blake2b(PIECE_SEPARATOR.join(piece.text for piece in pieces).encode(), digest_size=16).digest()
