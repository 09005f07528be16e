"""Probes: small inputs made by hand, whose answers tell one mistake apart from the others.

They are called only once a check has failed, and do not depend on the seed; nor does the name. The answers are compared
with those of the exercise's mutants (`mutations`), with one mistake, then two, then three. A name is given with full
confidence or not at all: the mutant must give the same answer to every probe, at least one of them wrong, and where
mutants of several mistakes agree, only their common mistakes are named. `rules` recognise by common features of the
answers those mistakes that no mutant reproduces.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from functools import cached_property, partial
from typing import Any

from graders.core.code import evidence
from graders.core.code.answer_arrays import AnswerSequence
from graders.core.code.confined import UnfinishedAnswer
from graders.core.code.mutants import MAX_COMBINED_MISTAKES, MutantAnswerCache, MutantRow, common_mistakes
from graders.core.code.mutations import Model, Mutant
from graders.core.code.pair_search import OutOfTimeError, PairSearch, limit_search_time, slice_untried_pairs
from graders.core.code.part_matching import match_wrong_parts
from graders.core.code.piggyback import HANG_SECONDS
from graders.core.code.probe_runs import (
    changes_returned_results,
    find_state_slip,
    probe_side_program,
    read_piggybacked,
    repeat_differs,
    with_other_seed,
)
from graders.core.code.probes import ProbeAnswer, ProbeResults, Probes, same_probe_answer
from graders.core.code.recognised import RecognisedMistakes, RuleName, WeakName, apply_rules, iter_rule_names
from graders.core.code.refuting import NameRefuter
from graders.core.code.runner import Runner
from graders.core.code.shared_results import SHARED
from graders.core.code.stateless import is_stateless, may_keep_state
from graders.core.contract.local import initial_globals
from graders.core.contract.program import KitSettings, PlannedCalls
from graders.core.contract.rows import as_rows

#: Seconds for all the probes of a program; a slower one is not named by them.
MAX_PROBING_SECONDS = HANG_SECONDS


class Prober:
    """Recognises mistakes by probes, with a cache of the mutants' answers.

    `whole` are programs with one mistake that is no edit of the model.
    """

    def __init__(self, model: Model, probes: Sequence[Probes], whole: Sequence[Mutant] = ()) -> None:
        self.model = model
        self.probes = tuple(probes)
        self._mutants = MutantAnswerCache(model, self.probes, whole)
        self._lock = threading.Lock()
        self._planned = [PlannedCalls(probe.function, as_rows((*probe.calls, probe.calls[0]))) for probe in self.probes]

    def may_probe_without_relaunch(self, source: bytes, kit: KitSettings) -> bool:
        """Whether, by its source, a running program with this kit answers the probes as a fresh launch would.

        Nothing is run; False in doubt.
        """
        same = all((probe.kit.module, probe.kit.without) == (kit.module, kit.without) for probe in self.probes)
        return same and is_stateless(source, self._kit_names)

    @cached_property
    def _kit_names(self) -> Mapping[str, Any]:
        """The global names of a program that answers the probes."""
        kits = {id(probe.kit): probe.kit for probe in self.probes}
        return {name: value for kit in kits.values() for name, value in initial_globals(kit).items()}

    def planned_calls(self, functions: Collection[str], alone: Collection[str]) -> Sequence[PlannedCalls]:
        """Return the calls that `recognise` makes of a program that is stateless and deterministic."""
        return [self._planned[index] for index, _ in self._select_probes(functions, alone)]

    @property
    def probed_functions(self) -> frozenset[str]:
        return frozenset(probes.function for probes in self.probes)

    def recognise(
        self, runner: Runner, functions: Collection[str], alone: Collection[str], search: PairSearch | None = None
    ) -> RecognisedMistakes:
        """Return the mistakes of the program in these functions; none when unsure.

        `alone` are the functions that failed a check of their own. Every pair of mistakes is tried by a `search`.
        """
        mistakes: list[str] = []
        fallback, consequences = list[str](), list[str]()
        refuter = NameRefuter(self._mutants)
        silent, ruled, alike = list[WeakName](), list[RuleName](), dict[str, frozenset[str]]()
        probed = {probes.function for _, probes in self._select_probes(functions, alone)}
        certain = probed >= self.probed_functions.intersection(functions)
        for index, answers, slip in self._iter_probe_results(runner, functions, alone):
            if slip is not None:
                mistakes += [mistake for mistake in (slip,) if mistake not in mistakes]
                certain = False
                continue
            with self._lock:
                sequence = AnswerSequence(answers)
                if mistakes and self._follows_from_mistakes(index, sequence, mistakes):
                    consequences.append(self.probes[index].function)
                    fallback += (last := self._fallback_names(index, sequence))
                    ruled += self._names_given_by_rules(index, sequence, last)
                    continue
                names, is_certain = self._name_mistakes_not_disproved(index, sequence, functions, refuter)
                is_triple = len(names) > MAX_COMBINED_MISTAKES  # found before all pairs are tried
                is_certain = is_certain and not is_triple
            pair = [] if search is None or is_certain else self._find_mistake_pair(index, sequence, functions, search)
            if pair:
                names, is_certain = refuter.unrefuted(index, pair), True
            with self._lock:
                refuter.note(index, names, is_certain)
                certain = certain and is_certain
                for name in names if is_certain else ():
                    alike[name] = alike.get(name, frozenset()).union({self.probes[index].function})
                silent += self._weak_names(index, sequence, [name for name in names if name not in mistakes])
                both: Sequence[MutantRow] = ()
                if len(names) > 1 and is_certain and not pair:  # together they may answer as a third, not known
                    both = self._mutants.mutants_matching_first_answer(index, MAX_COMBINED_MISTAKES, answers[0])
                if (is_triple and not pair) or self._mutants.filter_matching(index, both, sequence):
                    silent += [WeakName(name, index, "", ()) for name in names]
                mistakes += [mistake for mistake in names if mistake not in mistakes]
                fallback += (last := () if names else self._fallback_names(index, sequence))
                ruled += self._names_given_by_rules(index, sequence, names or last)
            probes = self.probes[index]
            if not names and may_keep_state(runner.source) and changes_returned_results(runner, probes):
                mistakes += [SHARED] if SHARED not in mistakes else []
                certain = False
        certain = certain and bool(mistakes)
        found = RecognisedMistakes(tuple(mistakes), tuple(fallback), tuple(consequences), certain, tuple(silent))
        return found._replace(ruled=tuple(ruled), alike=alike)

    def _name_mistakes_not_disproved(
        self, index: int, sequence: AnswerSequence, blamed: Collection[str], refuter: NameRefuter
    ) -> tuple[Sequence[str], bool]:
        """Return `_name_mistakes`, but those that answers to other probes refute; then without these."""
        names, is_certain = self._name_mistakes(index, sequence, blamed)
        left = refuter.unrefuted(index, names)
        if len(left) == len(names):
            return names, is_certain
        others, is_certain = self._name_mistakes(index, sequence, blamed, frozenset(names).difference(left))
        return (others, is_certain) if refuter.unrefuted(index, others) == others != [] else (left, False)

    def unfinished_mutants(self) -> Iterator[tuple[Mutant, UnfinishedAnswer]]:
        """Yield the mutants with one mistake that take too much to answer the probes, each with the call that does."""
        for index in range(len(self.probes)):
            with self._lock:
                yield from list(self._mutants.iter_unfinished_mutants(index))

    def _find_mistake_pair(
        self, index: int, sequence: AnswerSequence, blamed: Collection[str], search: PairSearch
    ) -> Sequence[str]:
        """Return two mistakes with which a mutant that the verdict leaves untried answers as the program does.

        None where other pairs do too, or some mutant that the verdict tries. The lock is free between two slices.
        """
        probes, answers = self.probes[index], sequence.answers
        with self._lock:
            right = self._nearest_right_answers_if_wrong(index, sequence)
            shown = None if right is None else ProbeResults(probes.calls, answers, right, probes.same)
            if shown is None or not evidence.has_informative_wrong_answer(shown):
                return []
            for rows in itertools.islice(self._iter_candidate_mutants(index, answers), MAX_COMBINED_MISTAKES):
                known = (row for row in rows if row.mutant.is_possible_in(blamed))
                if self._mutants.filter_matching(index, known, sequence):
                    return []
            slices = slice_untried_pairs(self._mutants, index, blamed)
        fits: list[MutantRow] = []
        try:
            for rows in limit_search_time(slices, search.is_time_spent):
                with self._lock:
                    fits += self._mutants.filter_matching(index, rows, sequence)
        except OutOfTimeError:
            return []
        common = common_mistakes(fits) if fits else []
        is_pair = len(common) == MAX_COMBINED_MISTAKES
        is_held = is_pair and search.is_confirmed(probes, fits[0].mutant.text)
        with self._lock:
            return common if is_held and self._mutants.shows_mistakes(index, common, shown, blamed) else []

    def _follows_from_mistakes(self, index: int, sequence: AnswerSequence, mistakes: Sequence[str]) -> bool:
        """Whether the mistakes found in other functions explain all wrong answers of this one."""
        if self._nearest_right_answers_if_wrong(index, sequence) is None:
            return False
        return bool(self._mutants.filter_matching(index, self._mutants.mutants_making(index, mistakes), sequence))

    def nearest_right_answers(self, index: int, answers: Sequence[ProbeAnswer]) -> Sequence[ProbeAnswer]:
        """Return the right answers to the probes `index`, in the style nearest to these answers."""
        with self._lock:
            right = self._nearest_right_answers_if_wrong(index, AnswerSequence(answers))
        return answers if right is None else right

    def right_answers_by_style(self, index: int) -> list[list[ProbeAnswer]]:
        """Return the right answers to the probes `index`, in each style of the model."""
        with self._lock:
            return self._mutants.right_answers_by_style(index)

    def _weak_names(self, index: int, sequence: AnswerSequence, names: Sequence[str]) -> Iterator[WeakName]:
        """Yield those of the names that are of mutants, where the answers tell little: nothing, or opinions."""
        probes, right = self.probes[index], self._nearest_right_answers_if_wrong(index, sequence) if names else None
        shown = ProbeResults(probes.calls, sequence.answers, right or (), probes.same)
        is_nothing = right is not None and evidence.are_all_uninformative(shown)
        if right is None or not (is_nothing or evidence.differ_in_single_flag(shown)):
            return
        ruled = tuple(apply_rules(probes.rules, shown))
        for name in names:
            alike = self._mutants.filter_matching(index, self._mutants.mutants_making(index, [name]), sequence)
            if alike and name not in ruled:
                of_opinions = ("", ()) if is_nothing else (alike[0].mutant.text, ruled)
                yield WeakName(name, index, *of_opinions)

    def _names_given_by_rules(self, index: int, sequence: AnswerSequence, names: Sequence[str]) -> Iterator[RuleName]:
        """Yield those of the names that no mutant with this mistake alone bears out, but a rule gives."""
        probes, right = self.probes[index], self._nearest_right_answers_if_wrong(index, sequence) if names else None
        if right is not None:
            shown = ProbeResults(probes.calls, sequence.answers, right, probes.same)
            for each in iter_rule_names(probes, index, shown, names):
                mutants = self._mutants.mutants_making(index, [each.mistake])
                if probes.compared == 0 or not self._mutants.filter_matching(index, mutants, sequence):
                    yield each

    def _fallback_names(self, index: int, sequence: AnswerSequence) -> Sequence[str]:
        probes = self.probes[index]
        right = self._nearest_right_answers_if_wrong(index, sequence)
        if right is None:
            return ()
        shown = ProbeResults(probes.calls, sequence.answers, right, probes.same)
        return () if evidence.are_self_explanatory(shown) else apply_rules(probes.last_rules, shown)

    def _iter_probe_results(
        self, runner: Runner, functions: Collection[str], alone: Collection[str]
    ) -> Iterator[tuple[int, list[ProbeAnswer], str | None]]:
        """Yield the index of the probes, the answers to them of a fresh launch, and a slip.

        The slip is MEMORY or CHANCE where the first call, repeated last, gets another answer, or answers are stale. The
        program then gets the same calls with another seed: kept state makes the same answers, random numbers do not.
        """
        deadline = runner.clock() + MAX_PROBING_SECONDS
        chosen = self._select_probes(functions, alone)
        for _, group in itertools.groupby(chosen, key=lambda pair: id(pair[1].kit)):
            indices, probes_of_kit = zip(*group, strict=True)
            batches = [self._planned[index] for index in indices]
            piggybacked = read_piggybacked(runner, probes_of_kit, batches)
            results = piggybacked or probe_side_program(runner, probes_of_kit, batches, probes_of_kit[0].kit, deadline)
            differs = [repeat_differs(probes, answers) for probes, answers in zip(probes_of_kit, results, strict=False)]
            # Only a program that is known to keep nothing is piggybacked.
            if not any(differs) and not piggybacked and may_keep_state(runner.source):
                differs = self._differ_in_reverse(runner, indices, results, deadline)
            differs = [d or p.function in runner.stale for d, p in zip(differs, probes_of_kit, strict=False)]
            repeated: Sequence[list[ProbeAnswer]] = ()
            if any(differs):
                other, until = with_other_seed(probes_of_kit[0].kit), runner.clock() + MAX_PROBING_SECONDS
                repeated = probe_side_program(runner, probes_of_kit, batches, other, until)
            for k, answers in enumerate(results):
                if len(answers) > len(probes_of_kit[k].calls):
                    again = repeated[k] if repeated and differs[k] else ()
                    yield indices[k], answers[:-1], find_state_slip(answers, again)

    def _differ_in_reverse(
        self, runner: Runner, indices: Sequence[int], results: Sequence[Sequence[ProbeAnswer]], deadline: float
    ) -> list[bool]:
        """Whether a fresh launch that is asked the same in reverse order answers otherwise, for each probed function.

        A memory that the repeated first call does not show, as one with an incomplete key, depends on the order.
        """
        probed = [self.probes[index] for index in indices]
        batches = [PlannedCalls(probes.function, tuple(reversed(probes.calls))) for probes in probed]
        backwards = probe_side_program(runner, probed, batches, probed[0].kit, deadline)
        return [
            not probes.random
            and len(answers) > len(probes.calls) == len(again)
            and not all(map(same_probe_answer, answers, reversed(again)))
            for probes, answers, again in zip(probed, results, backwards, strict=False)
        ]

    def _select_probes(self, functions: Collection[str], alone: Collection[str]) -> Sequence[tuple[int, Probes]]:
        return [
            (index, probes)
            for index, probes in enumerate(self.probes)
            if probes.function in functions and not probes.unless.intersection(alone)
        ]

    def _name_mistakes(
        self, index: int, sequence: AnswerSequence, blamed: Collection[str], disproved: AbstractSet[str] = frozenset()
    ) -> tuple[Sequence[str], bool]:
        """Return the mistakes of a function, none `disproved`, and whether it answers as a mutant with these alone."""
        probes, answers = self.probes[index], sequence.answers
        right = self._nearest_right_answers_if_wrong(index, sequence)
        if right is None:
            return (), True
        shown = ProbeResults(probes.calls, answers, right, probes.same)
        wrong = [k for k in shown.wrong_indices() if probes.compared is None or k < probes.compared]
        if evidence.are_self_explanatory(shown):
            return (), False
        is_poor = evidence.are_too_poor_for_two_mistakes(shown)
        for mistakes, rows in enumerate(self._iter_candidate_mutants(index, answers) if wrong else (), 1):
            if is_poor and mistakes > 1:
                break
            fitting = (r for r in rows if r.mutant.is_possible_in(blamed) and disproved.isdisjoint(r.mutant.ids))
            fits = self._mutants.filter_matching(index, fitting, sequence)
            common = common_mistakes(fits) if fits else []
            if common and self._mutants.shows_mistakes(index, common, shown, blamed):
                needed = self._mutants.necessary_mistakes(index, common, sequence)
                return needed, needed != common or any(set(row.mutant.ids) == set(common) for row in fits)
            if fits:
                break
        parts, certain = self._name_mistakes_by_part(index, shown, sequence, blamed)
        return (parts, certain) if parts else (apply_rules(probes.rules, shown), False)

    def _name_mistakes_by_part(
        self, index: int, shown: ProbeResults, sequence: AnswerSequence, blamed: Collection[str]
    ) -> tuple[Sequence[str], bool]:
        """Return the mistakes of parts of the answers, where each part is as a mutant with one mistake makes it.

        Where one mistake more makes the whole answers, these are the mistakes for certain.
        """
        if self.probes[index].same is not same_probe_answer or self.probes[index].compared is not None:
            return (), False
        rows = partial(self._mutants.single_mutant_rows, index, blamed)
        fits_of_parts = list(match_wrong_parts(shown.got, shown.right, rows))
        begun = [row for fits in fits_of_parts for row in fits]
        if whole := self._mutants.filter_matching(index, self._mutants.add_one_mistake(index, begun), sequence):
            return self._mutants.necessary_mistakes(index, common_mistakes(whole), sequence), True
        return list(dict.fromkeys(name for fits in fits_of_parts for name in common_mistakes(fits))), False

    def _iter_candidate_mutants(self, index: int, answers: Sequence[ProbeAnswer]) -> Iterator[Iterable[MutantRow]]:
        """Yield the mutants that may explain the answers, by increasing number of mistakes and cost."""
        for mistakes in range(1, MAX_COMBINED_MISTAKES + 1):
            yield self._mutants.mutants_matching_first_answer(index, mistakes, answers[0])
        yield self._mutants.extended_mutants(index, answers)

    def _nearest_right_answers_if_wrong(self, index: int, sequence: AnswerSequence) -> Sequence[ProbeAnswer] | None:
        """Return the right answers in the nearest style; None when the program's answers are right."""
        rows = self._mutants.mutants_with(index, 0)
        agreeing = [self._mutants.count_agreements(index, row, sequence) for row in rows]
        best = agreeing.index(max(agreeing))
        return None if agreeing[best] == len(sequence.answers) else rows[best].stored.answers
