"""Experiments on a failed program for which nothing was found: what its answers have in common, in all calls tried.

A method unlike the model's, or a mistake that no catalogue holds, still shows itself: in a relation between its answers
and the right ones, as one argument read for another, in what they should feel and do not. Each is tried on the probes,
in which the exercise's solution answers beside the program, then held against the calls of the checks, those that
failed first, and told with one call as it came out. The words state what was seen, never a cause.
"""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from types import MappingProxyType

import numpy as np

from graders.core.code.checks import Cases
from graders.core.code.contrasts import find_contrast
from graders.core.code.example_calls import convert_to_call_types
from graders.core.code.grading import CodeGrader
from graders.core.code.seen_facts import (
    FELT,
    NOT_FELT,
    FunctionTrial,
    ReturnedValue,
    SeenFact,
    VariedAnswers,
    VariedCall,
    are_right_answers_whole,
    find_relation,
    has_wrong_influence,
    influence_fact,
    iter_columns,
    replaced_argument_fact,
    sentence_subject,
)
from graders.core.compare.changed_arguments import ArgumentChange, iter_argument_replacements, iter_argument_variations
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import ArrayForm
from graders.core.compare.series import MANY_CALLS, MIN_WRONG, Series, is_constant, same
from graders.core.contract.program import KitSettings, PlannedCalls, Programs, Reply, StudentFault, flatten_blocks
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array

#: Calls of a function; calls in one launch; facts that are told of a function.
MAX_CALLS, SLICE, MAX_FACTS = 12, 120, 2
#: Further calls that bear a fact out, of each check and in all.
MAX_DRAWN, MAX_FURTHER = 16, 60
#: A varied call, the answer of the program, and that of the solution.
_VariedCallAnswers = tuple[VariedCall, list[Floats] | None, list[Floats] | None]
_NO_EXAMPLES: Mapping[str, Sequence[Arguments]] = MappingProxyType({})


class Experimenter:
    """Tries a program and the solution of its exercise on the same calls, until the time is `spent`.

    `examples` are the calls that the verdict's failed checks show, by function.
    """

    def __init__(
        self, grader: CodeGrader, programs: Programs, seed: int, spent: Callable[[], bool],
        examples: Mapping[str, Sequence[Arguments]] = _NO_EXAMPLES,
    ) -> None:  # fmt: skip
        self._grader, self._programs, self._seed, self._spent = grader, programs, seed, spent
        self._examples = examples

    def find_facts(self, source: str, functions: Sequence[str]) -> list[SeenFact]:
        """Return facts on the answers of these functions, the most telling first; [] where nothing is established."""
        facts = []
        for function in functions:
            trial = None if self._spent() else self._try_on_probes(source, function)
            trial = trial if trial is None or trial.wrong_views() else self._add_check_calls(source, trial)
            if trial is not None and trial.wrong_views():
                facts += self._find_facts_of_trial(source, trial)[:MAX_FACTS]
        return facts

    def _find_facts_of_trial(self, source: str, trial: FunctionTrial) -> list[SeenFact]:
        """Return the facts of a function; `trial` are its calls to the probes, against which all others are held."""
        views, wider = trial.wrong_views(), self._add_check_calls(source, trial)
        if wider is None:
            return []
        related = [fact for view in views for fact in self._relation_facts(wider, view)]
        if len(wider.calls) < MANY_CALLS:
            return related
        # Many changes give the same counts and verdicts, or leave them as they are.
        rich = [view for view in views if not _are_whole_numbers(trial.make_series(view))]
        varied = [view for view in rich if not is_constant(wider.make_series(view))]
        replaced = list(self._iter_replaced_argument_facts(trial, wider, varied))
        if not trial.unique:
            return [*replaced, *related]
        strong = [fact for fact in related if fact.says_answers]
        # Among several right answers, the solution's own choice may feel an argument that others need not.
        pairs = zip(trial.got, trial.unrounded or trial.got, strict=True)
        is_free = any(not same(mine, its) for row, own in pairs for mine, its in zip(row, own, strict=True))
        felt = [] if strong or replaced or is_free else list(self._iter_influence_facts(source, trial, wider, rich))
        flaws = [fact for fact in related if not fact.says_answers]
        told = [*strong, *replaced, *felt]
        run, solve = partial(self._answers_of, source, trial), partial(self._solution_answers, trial)
        left = [view for view in views if not any(sentence_subject(view.words) in fact.title for fact in told)]
        contrast = find_contrast(wider, left, run, solve) if len(told) < MAX_FACTS else None
        return [*told, *(fact for fact in (contrast,) if fact is not None), *flaws]

    def _relation_facts(self, trial: FunctionTrial, view: ReturnedValue) -> list[SeenFact]:
        """The first relation of a value with the right one; of its columns, where these tell more."""
        whole = find_relation(trial, view)
        if whole is not None and whole.says_answers:
            return [whole]
        columns = [fact for column in iter_columns(trial, view) if (fact := find_relation(trial, column)) is not None]
        return [fact for fact in columns if fact.says_answers] or ([whole] if whole is not None else columns)

    def _iter_replaced_argument_facts(
        self, trial: FunctionTrial, wider: FunctionTrial, views: Sequence[ReturnedValue]
    ) -> Iterator[SeenFact]:
        """An argument for which the program reads another value: the solution answers likewise when given that one."""
        if not views:
            return
        pivot = trial.plainest_call_number(k for k, wrong in enumerate(trial.make_series(views[0]).wrong) if wrong)
        changes = list(iter_argument_replacements(trial.names, trial.calls[pivot]))
        asked = [change.apply(trial.calls[pivot]) for change in changes]
        answers = iter(self._solution_answers(trial, [call for call in asked if call is not None]))
        seen = [None if call is None else next(answers, None) for call in asked]
        for view in views:
            series = trial.make_series(view)
            for change, call, answer in zip(changes, asked, seen, strict=True):
                if call is None or answer is None or len(answer) != len(trial.got[pivot]) or not series.wrong[pivot]:
                    continue
                if not same(view.read(answer), series.got[pivot]) or not self._explains_all(trial, view, change):
                    continue
                if self._is_unchanged_by_repeated_change(trial, view, change, call, answer):
                    continue
                if not self._explains_all(wider, view, change):
                    continue
                yield replaced_argument_fact(wider, view, pivot, change, call)
                break

    def _is_unchanged_by_repeated_change(
        self, trial: FunctionTrial, view: ReturnedValue, change: ArgumentChange, call: Arguments, seen: Sequence[Floats]
    ) -> bool:
        """Whether the same change made once more gives the same answer: then any value so far off would do as well."""
        further = change.apply(call)
        again = next(iter(self._solution_answers(trial, [further])), None) if further is not None else None
        return again is not None and len(again) == len(seen) and same(view.read(again), view.read(seen))

    def _explains_all(self, trial: FunctionTrial, view: ReturnedValue, change: ArgumentChange) -> bool:
        asked = [change.apply(call) or call for call in trial.calls]
        answers = self._solution_answers(trial, asked)
        return len(answers) == len(asked) and all(
            answer is not None and len(answer) == len(got) and same(view.read(answer), view.read(got))
            for answer, got in zip(answers, trial.got, strict=True)
        )

    def _iter_influence_facts(
        self, source: str, trial: FunctionTrial, wider: FunctionTrial, views: Sequence[ReturnedValue]
    ) -> Iterator[SeenFact]:
        """An argument that a result must feel and does not, or must not feel and does."""
        if not views:
            return
        changes = list(iter_argument_variations(trial.names, trial.calls[0]))
        answers = self._answer_varied_calls(source, trial, changes)
        for view in views:
            told: set[int] = set()
            for index, change in changes:
                if index in told:
                    continue
                rows = _compare_varied_answers(trial, view, change, answers)
                feels = has_wrong_influence(rows)
                if feels is None:
                    continue
                more_answers = self._answer_varied_calls(source, wider, [(index, change)])
                further = _compare_varied_answers(wider, view, change, more_answers)
                is_borne_out = len(further) >= len(rows) and has_wrong_influence(further) is feels
                if not is_borne_out or (feels and are_right_answers_whole(further)):
                    continue
                told.add(index)
                chosen = [not same(row.mine, row.got) if feels else not same(row.wanted, row.right) for row in rows]
                row, question = _plainest_row(trial, rows, chosen), NOT_FELT if feels else FELT
                yield influence_fact(trial, view, row, further, question)
                if feels:
                    break

    def _answer_varied_calls(
        self, source: str, trial: FunctionTrial, changes: Sequence[tuple[int, ArgumentChange]]
    ) -> list[_VariedCallAnswers]:
        """Return the answers of the program and of the solution to varied calls; [] where some are missing."""
        asked = [
            VariedCall(index, change, k, call)
            for index, change in changes
            for k, old in enumerate(trial.calls)
            if (call := change.apply(old)) is not None
        ]
        calls = [variation.call for variation in asked]
        answers, wanted = self._answers_of(source, trial, calls), self._solution_answers(trial, calls)
        if len(answers) < len(calls) or len(wanted) < len(calls):
            return []
        return list(zip(asked, answers, wanted, strict=True))

    def _try_on_probes(self, source: str, function: str) -> FunctionTrial | None:
        """Return a function's answers beside the right ones, as numbers; None where they are not comparable."""
        kit, calls = self._calls_to_try(function)
        if not calls:
            return None
        names = self._parameter_names(function, calls[0])
        bare = FunctionTrial(function, names, (), kit, calls, (), ())
        right = self._solution_answers(bare, calls)
        got = self._answers_of(source, bare, (*calls, calls[0]))
        if len(got) != len(calls) + 1 or len(right) != len(calls) or not _are_same_arrays(got[0], got[-1]):
            return None
        return self._make_comparable_trial(bare, calls, got[:-1], right)

    def _add_check_calls(self, source: str, trial: FunctionTrial) -> FunctionTrial | None:
        """Return a trial with further calls: those that failed checks show, and what the checks draw."""
        drawn = [
            tuple(itertools.islice(check.cases(stream(self._seed, check.id)), MAX_DRAWN))
            for check in self._grader.checks
            if isinstance(check, Cases) and check.functions == (trial.function,)
        ]
        shown = [convert_to_call_types(trial.calls[0], call) for call in self._examples.get(trial.function, ())]
        further = [*(call for call in shown if call is not None), *_interleave_calls(drawn)]
        known = {pickle.dumps(call) for call in trial.calls}
        calls = [call for call in further if pickle.dumps(call) not in known][:MAX_FURTHER]
        right, got = self._solution_answers(trial, calls), self._answers_of(source, trial, calls)
        if len(right) < len(calls) or len(got) < len(calls):
            return None
        own, wanted = (list(map(list, answers)) for answers in (trial.unrounded, trial.right))
        return self._make_comparable_trial(trial, (*trial.calls, *calls), [*own, *got], [*wanted, *right])

    def _make_comparable_trial(
        self, trial: FunctionTrial, calls: Sequence[Arguments], got: Sequence[list[Floats] | None],
        right: Sequence[list[Floats] | None],
    ) -> FunctionTrial | None:  # fmt: skip
        """Return a trial of these calls with their answers; None where they are not comparable."""
        function, names, kit = trial.function, trial.names, trial.kit
        pairs = zip(calls, got, right, strict=True)
        both = [(call, g, r) for call, g, r in pairs if g is not None and r is not None]
        sizes = {len(values) for _, g, r in both for values in (g, r)}
        if len(both) <= MIN_WRONG or len(sizes) != 1:
            return None
        size, parts = sizes.pop(), self._returned_part_names(function)
        parts = parts if len(parts) == size else tuple(f"valeur {k + 1}" for k in range(size))
        mine = [r if self._is_accepted(function, call, g, r) else g for call, g, r in both]
        calls, right_ones = [call for call, _, _ in both], [r for _, _, r in both]
        own = [g for _, g, _ in both]
        parts, unique = parts if size > 1 else (), self._has_unique_answers(function)
        return FunctionTrial(function, names, parts, kit, calls, mine, right_ones, own, unique)

    def _is_accepted(self, function: str, call: Arguments, got: Sequence[Floats], right: Sequence[Floats]) -> bool:
        """Whether an answer is a right one, though another than the solution's."""
        for probes in self._grader.prober.probes if self._grader.prober else ():
            if probes.function == function:
                mine, its = (tuple(values) if len(values) > 1 else values[0] for values in (got, right))
                return probes.same(probes.read(call, mine), probes.read(call, its))
        return False

    def _has_unique_answers(self, function: str) -> bool:
        """Whether the solution's answers are the only right ones."""
        prober = self._grader.prober
        return all(probes.unique for probes in (prober.probes if prober else ()) if probes.function == function)

    def _calls_to_try(self, function: str) -> tuple[KitSettings, Sequence[Arguments]]:
        """Return the calls of the probes of a function, of those that its failed checks draw where it has none."""
        prober = self._grader.prober
        for probes in prober.probes if prober else ():
            if probes.function == function:
                return probes.kit, () if probes.random else probes.calls[: probes.compared][:MAX_CALLS]
        kit = self._grader.kit(stream(self._seed, "kit"))
        for check in self._grader.checks:
            if isinstance(check, Cases) and check.functions == (function,):
                return kit, tuple(check.cases(stream(self._seed, check.id)))[:MAX_CALLS]
        return kit, ()

    def _parameter_names(self, function: str, call: Arguments) -> tuple[str, ...]:
        for contract in self._grader.contracts:
            if contract.function == function:
                return tuple(contract.takes)
        for check in self._grader.checks:
            if isinstance(check, Cases) and check.functions == (function,):
                return check.names
        return tuple(f"argument {k + 1}" for k in range(len(call)))

    def _returned_part_names(self, function: str) -> tuple[str, ...]:
        forms = [contract.returns for contract in self._grader.contracts if contract.function == function]
        if forms and isinstance(forms[0], ArrayForm):
            return forms[0].names
        return tuple(forms[0].parts) if forms and isinstance(forms[0], TupleForm) else ()

    def _solution_answers(self, trial: FunctionTrial, calls: Sequence[Arguments]) -> list[list[Floats] | None]:
        return self._answers_of(self._grader.solution, trial, calls)

    def _answers_of(self, source: str, trial: FunctionTrial, calls: Sequence[Arguments]) -> list[list[Floats] | None]:
        """Return the numbers of each answer, None for a fault or other values; fewer where the program died."""
        answers: list[list[Floats] | None] = []
        for begin in range(0, len(calls), SLICE):
            if self._spent():
                break
            try:
                program = self._programs.open(source.encode(), trial.kit)
            except StudentFault:
                break
            try:
                batch = PlannedCalls(trial.function, tuple(calls[begin : begin + SLICE]))
                for _, answer in flatten_blocks(program.call_batches([batch])):
                    answers.append(_read_arrays(answer.value) if isinstance(answer, Reply) else None)
            finally:
                program.close()
        return answers


def _are_whole_numbers(series: Series) -> bool:
    """Whether each right answer is one whole number, or a verdict."""
    return all(right.ndim == 0 and bool(right == np.round(right)) for right in series.right)


def _interleave_calls(drawn: Sequence[Sequence[Arguments]]) -> list[Arguments]:
    """Return the calls of several checks, the first of each before the second ones."""
    return [call for turn in itertools.zip_longest(*drawn) for call in turn if call is not None]


def _compare_varied_answers(
    trial: FunctionTrial, view: ReturnedValue, change: ArgumentChange, answers: Sequence[_VariedCallAnswers]
) -> list[VariedAnswers]:
    """Return a value of each answer to one change, beside the one before; without those that are no numbers."""
    return [
        VariedAnswers(variation, view.read(trial.got[k]), view.read(mine), view.read(trial.right[k]), view.read(its))
        for variation, mine, its in answers
        if variation.change is change and mine is not None and its is not None
        if len(mine) == len(its) == len(trial.got[k := variation.number])
    ]


def _plainest_row(trial: FunctionTrial, rows: Sequence[VariedAnswers], chosen: Sequence[bool]) -> VariedAnswers:
    by_number = {row.variation.number: row for row, is_chosen in zip(rows, chosen, strict=True) if is_chosen}
    return by_number[trial.plainest_call_number(by_number)]


def _read_arrays(value: Value) -> list[Floats] | None:
    """Return the arrays of an answer: one, or each of a tuple's; None where something else is among them."""
    try:
        if isinstance(value, tuple):
            return [read_array(part) for part in value]
        return [read_array(value)]
    except UnreadableError:
        return None


def _are_same_arrays(first: list[Floats] | None, second: list[Floats] | None) -> bool:
    if first is None or second is None:
        return first is second
    return len(first) == len(second) and all(map(same, first, second))
