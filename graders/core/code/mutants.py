"""Cache of the answers of an exercise's mutants to its probes, which never change.

Mutants run in a helper process (`confined`); one that takes too much has no answer, and matches nothing.
"""

from __future__ import annotations

import hashlib
import itertools
import marshal
import pickle
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from types import CodeType
from typing import Any, NamedTuple

import numpy as np

from graders.core.code.answer_arrays import AnswerColumn, AnswerSequence
from graders.core.code.confined import HelperProcessWork, UnfinishedAnswer
from graders.core.code.evidence import shows_mistake
from graders.core.code.mutations import Edit, Model, Mutant
from graders.core.code.probes import Facet, ProbeAnswer, ProbeFault, ProbeResults, Probes, same_probe_answer
from graders.core.code.reachability import PIECE_SEPARATOR, CodePiece, all_pieces_compile, reachable_code_pieces
from graders.core.code.reporting import report_call
from graders.core.compare.slips import SLIPS
from graders.core.contract.copies import copy_value
from graders.core.contract.local import call_function, initial_globals

#: Mistakes that are combined in one mutant; one more where a facet already matches two of them.
MAX_COMBINED_MISTAKES = 2
#: Mutants with several mistakes; each is run once in the life of a process (0.2 to 0.5 ms).
MAX_COMBINED_MUTANTS = 1500
#: Edits of one mistake that are combined with other mistakes.
MAX_WAYS_COMBINED = 2
MAX_EXTENDED_MUTANTS = 20
#: Stands for each answer of a mutant that takes too much, and for one that no program could give.
NO_ANSWER = ProbeFault("sans réponse")


@dataclass(eq=False)
class MutantAnswers:
    """Answers so far, shared by the mutants in which the probed function reaches the same text."""

    answers: list[ProbeAnswer] = field(default_factory=list)
    is_unfinished: bool = False
    number: int = field(default_factory=itertools.count().__next__)
    #: The first of `answers` as arrays; filled on demand.
    sequence: AnswerSequence = field(default_factory=AnswerSequence)


class _Question(NamedTuple):
    """A mutant, by the number of its answers and its marshalled code, and the first probe to answer."""

    number: int
    codes: Sequence[bytes]
    start: int


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
        self._begun: dict[int, tuple[Iterator[ProbeAnswer], int]] = {}
        self._work = HelperProcessWork(self._answer_mutants)

    def count_agreements(self, index: int, row: MutantRow, sequence: AnswerSequence) -> int:
        """Return how many probes a mutant answers alike."""
        probes, count = self.probes[index], len(sequence.answers)
        if probes.same is not same_probe_answer or count < len(probes.calls):
            return sum(probes.same(self._answer_at(index, row, k), answer) for k, answer in enumerate(sequence.answers))
        return sum(self._ensure_answers(index, row, count).compare_answers(sequence))

    def _ensure_answers(self, index: int, row: MutantRow, count: int) -> AnswerSequence:
        """Return a mutant's answers, at least `count` of them as arrays."""
        for k in range(len(row.stored.sequence.answers), count):
            row.stored.sequence.add(self._answer_at(index, row, k))
        return row.stored.sequence

    def mutants_matching_first_answer(self, index: int, mistakes: int, answer: ProbeAnswer) -> Sequence[MutantRow]:
        """Return the mutants with that number of mistakes that may answer the first probe alike."""
        rows, probes, key = self.mutants_with(index, mistakes), self.probes[index], (index, mistakes)
        self._compute_answers(index, rows, 1)
        if probes.same is not same_probe_answer or probes.compared == 0:
            return rows
        if key not in self._first_answers:
            self._first_answers[key] = AnswerColumn([self._answer_at(index, row, 0) for row in rows])
        return [rows[position] for position in self._first_answers[key].indices_of(answer)]

    def right_answers_by_style(self, index: int) -> list[list[ProbeAnswer]]:
        """Return the answers of the model to all probes, in each style."""
        calls = range(len(self.probes[index].calls))
        return [[self._answer_at(index, row, k) for k in calls] for row in self.mutants_with(index, 0)]

    def answers_alike(self, index: int, row: MutantRow, sequence: AnswerSequence) -> bool:
        """Whether the mutant answers every compared probe alike."""
        probes, answers = self.probes[index], sequence.answers[: self.probes[index].compared]
        if probes.same is not same_probe_answer:
            return all(probes.same(self._answer_at(index, row, k), answer) for k, answer in enumerate(answers))
        if answers and len(row.stored.sequence.answers) >= len(answers) == len(sequence.answers):
            return all(row.stored.sequence.compare_answers(sequence))
        return all(self._ensure_answers(index, row, k + 1).agrees_at(sequence, k) for k in range(len(answers)))

    def filter_matching(self, index: int, rows: Iterable[MutantRow], sequence: AnswerSequence) -> list[MutantRow]:
        """Return the mutants that answer every compared probe alike."""
        compared = sequence.answers[: self.probes[index].compared]
        agreeing = self._filter_by_first_answers(index, rows, compared, self.probes[index].same)
        return [row for row in agreeing if self.answers_alike(index, row, sequence)]

    def _filter_by_first_answers(
        self,
        index: int,
        rows: Iterable[MutantRow],
        answers: Sequence[ProbeAnswer],
        same: Callable[[ProbeAnswer, ProbeAnswer], bool],
    ) -> list[MutantRow]:
        """Return the mutants that give these first answers; twice as many are asked in each exchange."""
        left, begin, end = list(rows), 0, 1
        while left and begin < len(answers):
            self._compute_answers(index, left, min(end, len(answers)))
            left = [row for row in left if all(map(same, row.stored.answers[begin:end], answers[begin:end]))]
            begin, end = end, 2 * end
        return left

    def mutants_with(self, index: int, mistakes: int) -> list[MutantRow]:
        key = (index, mistakes)
        if key not in self._rows:
            if mistakes == 0:
                mutants = self.model.correct_versions()
            elif mistakes == 1:
                mutants = itertools.chain(self.model.mutants(self.model.edits, 1), self.whole)
            else:
                combined = filter(_compiles, self._combine_edits(index, mistakes))
                mutants = itertools.islice(combined, MAX_COMBINED_MUTANTS)
            self._rows[key] = [self._make_row(index, mutant) for mutant in mutants]
        return self._rows[key]

    def single_mutant_rows(self, index: int, blamed: Collection[str]) -> list[tuple[MutantRow, Sequence[ProbeAnswer]]]:
        """Return the mutants with one mistake that these functions can have, and their answers to all probes."""
        rows = [row for row in self.mutants_with(index, 1) if row.mutant.is_possible_in(blamed)]
        self._compute_answers(index, rows, len(self.probes[index].calls))
        return [(row, row.stored.answers) for row in rows]

    def shows_mistakes(self, index: int, names: Sequence[str], shown: ProbeResults, blamed: Collection[str]) -> bool:
        """Whether a program shows each of several mistakes, and not only what they give together."""
        if len(names) < 2:
            return True
        single = self.single_mutant_rows(index, blamed)
        by_name = {name: [answers for row, answers in single if row.mutant.ids == (name,)] for name in names}
        return all(shows_mistake(shown, answers) for answers in by_name.values())

    def _make_row(self, index: int, mutant: Mutant) -> MutantRow:
        """Return the row of a mutant; mutants in which the function reaches the same text share their answers."""
        key = index, _digest_pieces(reachable_code_pieces(mutant.text, self.probes[index].function))
        return MutantRow(mutant, self._answers_by_text.setdefault(key, MutantAnswers()))

    def _combine_edits(self, index: int, mistakes: int) -> Iterator[Mutant]:
        """Yield mutants with several mistakes, by the first edits of each, in the catalogue's order."""
        taken: Counter[str] = Counter()
        usual = []
        for edit in self.effective_edits(index):
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

    def effective_edits(self, index: int) -> list[Edit]:
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
            matching = (row for right in rights.values() for row in self.filter_matching(index, edited.values(), right))
            effective = edited.keys() - {row.stored for row in matching}
            edits = {row.mutant.edits for row in self.mutants_with(index, 1) if row.stored in effective}
            self._edits[index] = [edit for edit in self.model.edits if (edit,) in edits]
        return self._edits[index]

    def mutants_making(self, index: int, ids: Sequence[str]) -> Sequence[MutantRow]:
        """Return the mutants that make exactly these mistakes."""
        key = index, tuple(ids)
        if key not in self._rows_by_ids:
            edits = [edit for edit in self.model.edits if edit.id in ids]
            mutants = filter(_compiles, self.model.mutants(edits, len(ids)))
            self._rows_by_ids[key] = [self._make_row(index, mutant) for mutant in mutants]
        return self._rows_by_ids[key]

    def necessary_mistakes(self, index: int, names: Sequence[str], sequence: AnswerSequence) -> Sequence[str]:
        """Return three names without the first one that mutants need not to answer alike: they are found before all
        pairs are tried, and one may change nothing here."""
        for name in names if len(names) > MAX_COMBINED_MISTAKES else ():
            others = [other for other in names if other != name]
            if self.filter_matching(index, self.mutants_making(index, others), sequence):
                return others
        return names

    def extended_mutants(self, index: int, answers: Sequence[ProbeAnswer]) -> Sequence[MutantRow]:
        """Return, for the mutants that match in the facet, those with one mistake more."""
        facet = self.probes[index].facet
        if facet is None:
            return ()
        return self.add_one_mistake(index, self._matching_facet(facet, index, answers))

    def add_one_mistake(self, index: int, begun: Sequence[MutantRow]) -> Sequence[MutantRow]:
        """Return the first of these mutants with one mistake more, of those that change some answer."""
        extended = [
            MutantRow(mutant, MutantAnswers())
            for row in begun[:MAX_EXTENDED_MUTANTS]
            for mutant in self.model.add_one_mistake(row.mutant, self.effective_edits(index))
            if _compiles(mutant)
        ]
        self._compute_answers(index, extended, 1)
        return extended

    def _matching_facet(self, facet: Facet, index: int, answers: Sequence[ProbeAnswer]) -> list[MutantRow]:
        """Return the mutants that answer every compared probe alike in this facet."""
        probes, left = self.probes[index], self.mutants_with(index, MAX_COMBINED_MISTAKES)
        for k, answer in enumerate(answers[: probes.compared]):
            self._compute_answers(index, left, k + 1)
            part = facet(probes.calls[k], answer)
            left = [row for row in left if probes.same(facet(probes.calls[k], row.stored.answers[k]), part)]
        return left

    def iter_unfinished_mutants(self, index: int) -> Iterator[tuple[Mutant, UnfinishedAnswer]]:
        """Yield the mutants with one mistake that take too much to answer the compared probes, and where."""
        probes, rows = self.probes[index], self.mutants_with(index, 1)
        count = len(probes.calls) if probes.compared is None else probes.compared
        self._compute_answers(index, rows, count)
        for row in {id(row.stored): row for row in rows if row.stored.is_unfinished}.values():
            yield from (
                (row.mutant, answer)
                for answer in self._work.answer_each([self._make_question(index, row, 0)], (index, count), telling=True)
                if isinstance(answer, UnfinishedAnswer)
            )

    def _make_question(self, index: int, row: MutantRow, start: int) -> _Question:
        pieces = reachable_code_pieces(row.mutant.text, self.probes[index].function)
        return _Question(row.stored.number, [piece.marshalled_code for piece in pieces], start)

    def _answer_at(self, index: int, row: MutantRow, k: int) -> ProbeAnswer:
        """Return a mutant's answer to probe k, after all the probes before it."""
        probes, stored = self.probes[index], row.stored
        if k >= len(stored.answers):  # of most mutants no more is asked than the first one
            compared = probes.compared if probes.compared is not None and k < probes.compared else len(probes.calls)
            self._compute_answers(index, [row], min(max(k + 1, 2 * len(stored.answers)), compared))
        return stored.answers[k]

    def _compute_answers(self, index: int, rows: Sequence[MutantRow], count: int) -> None:
        """Have at least `count` answers of each of these mutants, all in one exchange."""
        probes = self.probes[index]
        missing = {id(row.stored): row for row in rows if len(row.stored.answers) < count}.values()
        items = [self._make_question(index, row, len(row.stored.answers)) for row in missing]
        for row, answers in zip(missing, self._work.answer_each(items, (index, count)), strict=True):
            if isinstance(answers, UnfinishedAnswer):
                row.stored.is_unfinished = True
                row.stored.answers += [NO_ANSWER] * (len(probes.calls) - len(row.stored.answers))
            else:
                row.stored.answers += answers

    def _answer_mutants(self, questions: Sequence[_Question], context: tuple[int, int]) -> Iterator[list[ProbeAnswer]]:
        """Yield, in the helper process, the answers of each mutant from one probe up to another."""
        index, end = context
        for number, codes, start in questions:
            running, position = self._begun.pop(number, (None, 0))
            if running is None or position != start:
                answers = _run_on_probes(map(marshal.loads, codes), self.probes[index], self._global_names(index))
                running = itertools.islice(answers, start, None)
            yield [_to_picklable(answer) for answer in itertools.islice(running, end - start)]
            if start:  # of most mutants no more is asked: nothing is kept to go on with
                self._begun[number] = running, end

    def _global_names(self, index: int) -> dict[str, Any]:
        """Return the global names of a mutant: the kit's, built once unless the function draws at random."""
        probes = self.probes[index]
        if probes.random or index not in self._kits:
            self._kits[index] = {"__name__": "mutant", **initial_globals(probes.kit), **probes.given}
        return dict(self._kits[index])


def _compiles(mutant: Mutant) -> bool:
    return all_pieces_compile(mutant.text)


def _run_on_probes(codes: Iterable[CodeType], probes: Probes, names: dict[str, Any]) -> Iterator[ProbeAnswer]:
    """Yield the answers of a mutant, which is trusted code; its pieces are executed in `names`."""
    for code in codes:
        exec(code, names)
    for args in probes.calls:
        report_call(probes.function, args)
        arguments = copy_value(args)
        try:
            with np.errstate(all="ignore"):
                value = call_function(names, probes.function, arguments)
        except MemoryError:
            raise
        except Exception as error:
            fault = ProbeFault(type(error).__name__)
            yield probes.faults.get(fault.name, fault)
        else:
            yield probes.read(args, value)


def _to_picklable(answer: ProbeAnswer) -> ProbeAnswer:
    """Return an answer that another process can read: a mutant may return anything, as a generator."""
    try:
        pickle.dumps(answer)
    except Exception:  # objects raise whatever they like
        return NO_ANSWER
    return answer


def _digest_pieces(pieces: Sequence[CodePiece]) -> bytes:
    """Return a key for the text of these pieces: the texts themselves would take megabytes."""
    return hashlib.blake2b(PIECE_SEPARATOR.join(piece.text for piece in pieces).encode(), digest_size=16).digest()


def common_mistakes(fits: Sequence[MutantRow]) -> Sequence[str]:
    """Return the common mistakes of these mutants; those with mistakes of the exercise go before slips."""
    fits = [row for row in fits if not SLIPS.keys() & set(row.mutant.ids)] or fits
    common = set(fits[0].mutant.ids).intersection(*(row.mutant.ids for row in fits[1:]))
    return [mistake for mistake in fits[0].mutant.ids if mistake in common]
