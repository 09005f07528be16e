"""Grading of code: from a file and a seed to a verdict, the same for the same seed."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path

from graders.core.code.bench import Bench
from graders.core.code.call_graph import find_callers
from graders.core.code.checks import Check
from graders.core.code.confined import UnfinishedAnswer
from graders.core.code.contracts import FunctionContract
from graders.core.code.decimal_commas import decimal_comma_diagnosis
from graders.core.code.diagnosis import add_unexplained_checks, choose_explanation, combine_diagnoses, diagnose_slip
from graders.core.code.explaining import KitMaker, MistakeExplainer
from graders.core.code.facts import IMPRECISIONS, Fact, find_facts
from graders.core.code.finding_messages import add_signatures_to_messages, shorten_repeated_reasons
from graders.core.code.folder import Misconception, Specimen, read_specimens
from graders.core.code.pair_search import PairSearch
from graders.core.code.prober import Prober
from graders.core.code.probes import is_message_self_explanatory
from graders.core.code.recognised import NamingGround, RecognisedMistakes
from graders.core.code.reenacting import Reenactor
from graders.core.code.rounded_constants import rounded_constant_diagnosis
from graders.core.code.runner import DEFAULT_BUDGET, Runner
from graders.core.code.running import run_check, run_checks
from graders.core.code.stale_answers import fail_checks_with_stale_answers
from graders.core.code.undoing import verify_rule_names, verify_weak_names
from graders.core.compare.shrinking import Budget
from graders.core.compare.slips import SLIPS
from graders.core.contract.films import film_to_json
from graders.core.contract.findings import Finding, Judgement, make_verdict
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Programs, StudentFault
from graders.core.contract.protocol import KnownSubmission, WhileNaming, no_early_verdict
from graders.core.contract.streams import stream
from graders.core.contract.verdict import Diagnosis

JUDGED = (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT)
#: Outcomes that a misconception may explain: the program runs, though it may raise on some inputs.
DIAGNOSED = (*JUDGED, Outcome.RUNTIME_ERROR)
FRESH_REENACTOR = Reenactor()
#: Budget of a counterexample that is not shown.
NO_SHRINKING = Budget(calls=0)


@dataclass(frozen=True)
class NamedMistakes:
    """The mistakes named in a program: ids of the catalogue, facts, and for each the checks that it explains.

    `certain` is as in `Diagnosis`; `failed` are ids of checks. `hidden` are the titles of the mistakes and facts that
    the program shows only with right functions for others, `answering` the functions that answer as with a mistake.
    """

    ids: tuple[str, ...] = ()
    facts: tuple[Fact, ...] = ()
    explains: tuple[tuple[str, ...], ...] = ()
    certain: bool = False
    failed: frozenset[str] = frozenset()
    hidden: frozenset[str] = frozenset()
    grounds: Mapping[str, NamingGround] = field(default_factory=dict)
    answering: Mapping[str, frozenset[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class CodeGrader:
    """Grades submissions that define the `functions` of one exercise; `folder` is its grader's folder.

    `reenactor` re-enacts its misconceptions; `budget` bounds the shrinking of one counterexample; `long`, `heavy`
    and `contracts` are as in `code`.
    """

    exercise: str
    folder: Path
    functions: tuple[str, ...]
    checks: tuple[Check, ...]
    kit: KitMaker
    misconceptions: tuple[Misconception, ...]
    solution: str
    reenactor: Reenactor = FRESH_REENACTOR
    budget: Budget = DEFAULT_BUDGET
    prober: Prober | None = None
    long: bool = False
    heavy: bool = False
    contracts: tuple[FunctionContract, ...] = ()
    _explainer: MistakeExplainer = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        explainer = MistakeExplainer(self.misconceptions, self.checks, self.kit, self.reenactor)
        object.__setattr__(self, "_explainer", explainer)

    def grade(
        self,
        source: bytes,
        programs: Programs,
        *,
        seed: int,
        version: str,
        while_naming: WhileNaming = no_early_verdict,
    ) -> Judgement:
        """Return the judgement of a file: every check runs on the program that `programs` starts from it.

        Every fault of the student's program ends in the verdict; an exception raised here is our own fault.
        """
        started = time.perf_counter()
        kit = self.kit(stream(seed, "kit"))
        runner = Runner(programs, source, kit, budget=self.budget)
        try:
            findings = self._run_checks(runner, kit, seed, source, self.checks)
            checked = time.perf_counter()
            told = shorten_repeated_reasons(add_signatures_to_messages(findings, self.solution))
            if all(finding.cause not in DIAGNOSED for finding in findings):
                diagnosis = self._diagnose(findings, runner, kit, seed, source)
            else:
                early = make_verdict(self.exercise, version, seed, told, None, stdout=runner.stdout, timings={})
                with while_naming(Judgement(early)):
                    diagnosis = self._diagnose(findings, runner, kit, seed, source)
        finally:
            runner.close()
        findings = told
        ended = time.perf_counter()
        timings = {"checks_ms": (started, checked), "diagnosis_ms": (checked, ended), "total_ms": (started, ended)}
        verdict = make_verdict(
            self.exercise,
            version,
            seed,
            findings,
            diagnosis,
            stdout=runner.stdout,
            timings={name: round(1000.0 * (end - start), 3) for name, (start, end) in timings.items()},
        )
        figures = {f.result.id: f.figure for f in findings if f.figure is not None}
        films = {check: film for check, data in runner.films.items() if (film := film_to_json(data)) is not None}
        return Judgement(verdict, figures, films)

    def _run_checks(
        self, runner: Runner, kit: KitSettings, seed: int, source: bytes, checks: Sequence[Check]
    ) -> Sequence[Finding]:
        """Run the checks. Probes go to the same process, of a stateless program, else to one announced at a failure."""
        prober = self.prober
        if prober is None:
            return run_checks(checks, runner, kit, seed)
        steady = cache(lambda: prober.may_probe_without_relaunch(source, kit))
        findings = run_checks(
            checks, runner, kit, seed,
            launches_if_failed=lambda: 0 if steady() else 1,
            calls_if_failed=lambda failed: prober.planned_calls(*self._functions_to_probe(failed)) if steady() else (),
        )  # fmt: skip
        return fail_checks_with_stale_answers(checks, findings, runner, prober.probes, self.contracts)

    def first_failed_check(
        self, source: bytes, programs: Programs, *, seed: int, checks: Sequence[Check] | None = None
    ) -> str | None:
        """Return the id of the first of these checks (all by default) that a file fails; None. It is not simplified."""
        kit, chosen = self.kit(stream(seed, "kit")), self.checks if checks is None else checks
        runner = Runner(programs, source, kit, budget=NO_SHRINKING)
        try:
            _ = runner.program
            findings = (run_check(check, Bench(check.id, runner, stream(seed, check.id), kit)) for check in chosen)
            return next((finding.result.id for finding in findings if not finding.passed), None)
        except StudentFault:
            return chosen[0].id
        finally:
            runner.close()

    def _diagnose(
        self, findings: Sequence[Finding], runner: Runner, kit: KitSettings, seed: int, source: bytes
    ) -> Diagnosis | None:
        """Name the mistake: by the probes, else by re-enactment for functions without probes, else as a slip."""
        pairs = self._explainable_failures(findings)
        if not pairs:
            return None
        if (comma := decimal_comma_diagnosis(source)) is not None:
            return comma
        named = self._name_in_failures(pairs, runner, seed, source)
        if not named.ids and all(fact.slip.id in IMPRECISIONS for fact in named.facts):
            rounded = rounded_constant_diagnosis(source) if all(f.cause in JUDGED for _, f in pairs) else None
            if rounded is not None:
                return rounded
        if named.ids or named.facts:
            at_fault = [check for check, finding in pairs if not finding.result.neutral]
            doubtful = self._checks_of_affected_callers(source, at_fault, named.explains)
            diagnosis = self.describe_mistakes(replace(named, failed=named.failed - doubtful))
            return add_unexplained_checks(diagnosis, [finding.result for finding in findings], doubtful)
        return diagnose_slip([(c.functions, f.slip) for c, f in pairs if f.cause in JUDGED and f.result.counterexample])

    def name_mistakes(
        self, source: str, programs: Programs, seed: int, is_time_spent: Callable[[], bool] | None = None,
        check_ids: Collection[str] | None = None,
    ) -> NamedMistakes:  # fmt: skip
        """Return the checks (of `check_ids`) that a program fails and the mistakes named in it, without simplifying.

        Every pair of mistakes of a function is tried until `is_time_spent()`, if given.
        """
        checks = self.checks if check_ids is None else [check for check in self.checks if check.id in check_ids]
        kit = self.kit(stream(seed, "kit"))
        runner = Runner(programs, source.encode(), kit, budget=NO_SHRINKING)
        try:
            findings = self._run_checks(runner, kit, seed, source.encode(), checks)
            pairs = self._explainable_failures(findings)
            judge = partial(self._explainer.is_judged_alike, runner, seed)
            search = None if is_time_spent is None else PairSearch(is_time_spent, judge)
            named = self._name_in_failures(pairs, runner, seed, source.encode(), search) if pairs else NamedMistakes()
        finally:
            runner.close()
        return replace(named, failed=frozenset(it.result.id for it in findings if not (it.passed or it.result.neutral)))

    def describe_mistakes(self, named: NamedMistakes) -> Diagnosis:
        """Return the diagnosis of named mistakes, without what it leaves unexplained."""
        facts, explains_all = [fact.slip for fact in named.facts], named.failed <= set().union(*named.explains)
        diagnosis = combine_diagnoses(
            named.ids, self.misconceptions, facts, hidden=named.hidden, grounds=named.grounds,
            answering=named.answering if len(self.functions) > 1 else {}, explains_all=explains_all,
        )  # fmt: skip
        return replace(diagnosis, explains=named.explains, certain=named.certain)

    def _explainable_failures(self, findings: Sequence[Finding]) -> list[tuple[Check, Finding]]:
        """Return the failed checks with their findings; none where none has a cause that a mistake may explain."""
        checks = {check.id: check for check in self.checks}
        pairs = [(checks[finding.result.id], finding) for finding in findings if not finding.passed]
        return [] if all(finding.cause not in DIAGNOSED for _, finding in pairs) else pairs

    def _name_in_failures(
        self, pairs: Sequence[tuple[Check, Finding]], runner: Runner, seed: int, source: bytes,
        search: PairSearch | None = None,
    ) -> NamedMistakes:  # fmt: skip
        failed = [check for check, _ in pairs]
        blamed, (functions, alone) = _blamed_functions(failed), self._functions_to_probe(failed)
        found = self.prober.recognise(runner, functions, alone, search) if self.prober else RecognisedMistakes()
        found = verify_weak_names(found, self.prober, runner, partial(self._explainer.is_judged_alike, runner, seed))
        found = verify_rule_names(found, self.prober, runner, alone)
        told = [check for check, finding in pairs if is_message_self_explanatory(finding.result.message)]
        others = {name for check in failed if check not in told for name in check.functions}
        left = ((alone if found.mistakes else blamed) - set(found.consequences)) & others
        reenacted = self._reenact(found.mistakes, left, runner, seed)
        ids = self._without_contradicted_names((*found.mistakes, *reenacted) or found.fallback, failed)
        facts = find_facts(pairs, source, self.solution, [self.mistake_title(mistake) for mistake in ids])
        at_fault = [check for check, finding in pairs if not finding.result.neutral]
        following = set(found.consequences) if ids == found.mistakes else set()
        explained = (self._explained_checks(name, at_fault, following) for name in ids)
        explains = (*explained, *(fact.checks for fact in facts))
        certain = found.certain and not reenacted and ids == found.mistakes
        failed_ids, hidden = frozenset(check.id for check in at_fault), frozenset[str]()
        return NamedMistakes(ids, tuple(facts), explains, certain, failed_ids, hidden, found.grounds, found.alike)

    def _without_contradicted_names(self, ids: Sequence[str], failed: Sequence[Check]) -> tuple[str, ...]:
        """Return the ids whose words the failed checks do not contradict: nothing fails that they say to be right."""
        failed_ids = {check.id for check in failed}
        right = {mistake.id: mistake.right for mistake in self.misconceptions}
        return tuple(mistake for mistake in ids if failed_ids.isdisjoint(right.get(mistake, ())))

    def _checks_of_affected_callers(
        self, source: bytes, failed: Sequence[Check], explains: Sequence[Sequence[str]]
    ) -> frozenset[str]:
        """Return the ids of the failed checks of functions that call one with an explained check."""
        explained = {check for ids in explains for check in ids}
        if all(check.id in explained for check in failed):
            return frozenset()
        names = {name for check in failed if check.id in explained for name in check.functions}
        callers = find_callers(source, names)
        return frozenset(check.id for check in failed if callers.intersection(check.functions))

    def _explained_checks(self, mistake: str, failed: Sequence[Check], following: Collection[str]) -> tuple[str, ...]:
        """Return the ids of the failed checks of a mistake's functions, and of those in which it is known to show.

        Those of all functions for a slip.
        """
        functions = {function for each in self.misconceptions if each.id == mistake for function in each.functions}
        functions.update(following if functions else ())
        return tuple(check.id for check in failed if not functions or functions.intersection(check.functions))

    def mistake_title(self, mistake: str) -> str:
        """Return the title of a mistake of the catalogue, or of a slip."""
        titles = {each.id: each.title for each in self.misconceptions}
        return titles.get(mistake) or SLIPS[mistake].title

    def _functions_to_probe(self, failed: Sequence[Check]) -> tuple[Sequence[str], set[str]]:
        """Return the functions to probe, and those that failed a check of their own."""
        blamed = _blamed_functions(failed)
        functions = [function for function in self.functions if function in blamed]
        return functions, {check.functions[0] for check in failed if len(check.functions) == 1}

    def _reenact(self, named_ids: Sequence[str], blamed: Collection[str], runner: Runner, seed: int) -> Sequence[str]:
        """Name, from the observations, the mistake of blamed functions without one, if it is no edit of the model."""
        explained = {function for m in self.misconceptions if m.id in named_ids for function in m.functions}
        left = set() if set(named_ids) & SLIPS.keys() else set(blamed) - explained
        others = [k for k in self._explainer.reenactable_indices() if left & set(self.misconceptions[k].functions)]
        if not others:
            return []
        observations = runner.observations
        failing = {observation.function for observation in observations if not observation.ok}
        candidates = [k for k in others if failing & set(self.misconceptions[k].functions)]
        named = choose_explanation(list(self._explainer.explain_each(observations, seed, candidates)))
        return [named.id] if named else []

    def unfinished_mistakes(self, seed: int) -> Iterator[tuple[Misconception, UnfinishedAnswer]]:
        """Yield the misconceptions that take too much time or memory, each with the call that does.

        They are re-enacted on the inputs of this seed, and on the probes. Gradings leave them out.
        """
        yield from self._explainer.iter_unfinished_misconceptions(seed)
        by_id = {mistake.id: mistake for mistake in self.misconceptions}
        for mutant, unfinished in self.prober.unfinished_mutants() if self.prober else ():
            yield from ((by_id[name], unfinished) for name in mutant.ids if name in by_id)

    def warm_up(self) -> None:
        """Warm up: grade the solution and a mistake in this process, so that imports and compilations are done.

        The misconceptions that take too much are found meanwhile, before a submission waits for them. A `long` exercise
        is skipped, where warming up saves a negligible part.
        """
        if self.long:
            return
        unfinished = {mistake.source for mistake, _ in self._explainer.iter_unfinished_misconceptions(seed=0)}
        mistakes = [mistake.source for mistake in self.misconceptions if mistake.source not in unfinished][:1]
        for source in mistakes if self.heavy else (self.solution, *mistakes):
            self.grade(source.encode(), LOCAL, seed=0, version="")

    def mistake_ids(self) -> frozenset[str]:
        """Return the ids of the misconceptions."""
        return frozenset(misconception.id for misconception in self.misconceptions)

    def known_submissions(self) -> Iterator[KnownSubmission]:
        """Yield the solution, the catalogued mistakes and the specimens, with their expected verdicts."""
        yield KnownSubmission("référence", _same_source_for_all_seeds(self.solution.encode()), Outcome.OK)
        for misconception in self.misconceptions:
            source = _same_source_for_all_seeds(misconception.source.encode())
            yield KnownSubmission(f"erreur {misconception.id}", source, diagnosis=misconception.id)
        for specimen in self.specimens():
            subject = f"spécimen {specimen.outcome.value}/{specimen.path.name}"
            yield KnownSubmission(subject, _same_source_for_all_seeds(specimen.path.read_bytes()), specimen.outcome)

    def specimens(self) -> Iterator[Specimen]:
        """Yield the submissions under `specimens/<outcome>/`. Raises MalformedExerciseError."""
        return read_specimens(self.folder)


def _blamed_functions(failed: Sequence[Check]) -> frozenset[str]:
    """Return the functions that fail a check of their own; where there are none, all functions of failed checks."""
    alone = [check for check in failed if len(check.functions) == 1]
    return frozenset(function for check in alone or failed for function in check.functions)


def _same_source_for_all_seeds(source: bytes) -> Callable[[int], bytes]:
    return lambda _seed: source
