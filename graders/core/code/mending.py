"""Search for the place of a mistake in the student's own program: changed there, it passes checks that it fails.

Most changes are ruled out by the probes, of many changed programs in one launch (`variants`); those that mend some
wrong answer and break none are run through the checks, and what passes then must pass on the inputs of other seeds too:
of thousands of changes, some make up for a mistake on a few inputs. Two changes are found one after the other: the
first must mend something alone. No change is ever shown: it proves where the mistake is, and how much it costs.
"""

from __future__ import annotations

import difflib
import itertools
import re
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from graders.core.code.bench import Bench
from graders.core.code.changes import ProgramChange, find_changes, insert_variable_recorder
from graders.core.code.checks import Check
from graders.core.code.grading import NO_SHRINKING, CodeGrader
from graders.core.code.line_values import LineEvidence, insert_all_recorders, insert_line_recorder, judge_line_by_values
from graders.core.code.loops import ClosedLoop
from graders.core.code.pair_search import OutOfTimeError
from graders.core.code.runner import Runner
from graders.core.code.running import run_check
from graders.core.code.screening import ProbeScreen
from graders.core.code.stateless import may_change_state
from graders.core.code.variants import VariantCaller
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs, Reply, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments
from graders.core.contract.verdict import Diagnosis, Verdict
from graders.core.syntax_trees import parse_or_none

#: Changes run through the checks; changes of one program in all.
MAX_VERIFIED, MAX_STEPS = 8, 2
#: Other lines that are tried where one change mends all that fails.
MAX_OTHER_LINES = 2
#: Changes after which another one is searched; those that are run through the checks though the time is spent.
MAX_BEGUN, MAX_LATE = 2, 3
#: Kinds of changes after which a line is another one.
REORDERING = ("ordre des lignes", "indentation")
#: The kind of change that keeps what is given, or what was returned, as it is.
COPY = "copie"
#: Other seeds on whose inputs a mended check must pass too.
MAX_SEEDS = 4
#: What a program writes that draws from a generator of its own, not from the one that it is given.
_OWN_DRAWS = re.compile(r"\b(?:import|from) random\b|\b(?:np|numpy)\.random\b|\bdefault_rng\b")
#: Copies that are tried where a function modifies its arguments.
MAX_COPIES = 4


@dataclass(frozen=True)
class MendingStep:
    """A change, the ids of the checks that it mends, and the other changes of as much effect at other places.

    `is_doubtful`: it is unlikely, and the values of the line do not bear it out. `is_borne_out`: these are the
    solution's once the line is changed, and only then.
    """

    change: ProgramChange
    mended: frozenset[str]
    rivals: tuple[ProgramChange, ...] = ()
    is_doubtful: bool = False
    is_borne_out: bool = False


@dataclass(frozen=True)
class Mending:
    """The steps found, the ids of the checks that still fail after them, and a name: that of what the last step mends,
    where another one comes before it and the mended program has that name for certain.

    `beside_right_ones`: right functions stood in the place of some of the program's.
    """

    steps: tuple[MendingStep, ...]
    left: frozenset[str]
    last_name: Diagnosis | None = None
    beside_right_ones: bool = False

    @property
    def mended_checks(self) -> frozenset[str]:
        """The ids of the checks that pass after all steps."""
        return frozenset().union(*(step.mended for step in self.steps))


class MendingSearch:
    """Searches in one program of an exercise, on the inputs of one seed, until the time is `spent`.

    Each changed program runs with the `suffix`, which may put right functions in the place of some. The functions
    `apart` are not changed.
    """

    def __init__(
        self, grader: CodeGrader, programs: Programs, seed: int, spent: Callable[[], bool], suffix: str = "",
        apart: Collection[str] = (),
    ) -> None:  # fmt: skip
        self._grader, self._programs, self._seed, self._spent, self._apart = grader, programs, seed, spent, apart
        self._caller, self._suffix = VariantCaller(programs, suffix), suffix
        self._screen = ProbeScreen(grader, programs, self._caller, spent, seed)
        self.tried = 0

    def find_mending(
        self, source: str, functions: Collection[str] = (), helpers: Collection[str] = (), failed: Collection[str] = ()
    ) -> Mending | None:
        """Return the changes that mend checks of a failed program, in some functions if given; None without any.

        The changes are of these functions and of those that they call, but of the `helpers` only where some are given.
        Where some check still fails, a doubtful change proves nothing: it may only pass by the mistake. `failed`: the
        checks that it fails on the seed of this search, by their ids, where these are known.
        """
        if parse_or_none(source) is None:
            return None
        try:
            left = frozenset(failed) or frozenset(check.id for check in self.failed_checks(source))
            if not left or (len(left) == len(self._grader.checks) and not self._can_load(source)):
                return None
            steps = self._search_steps(source, left, MAX_STEPS, functions, helpers)
        except OutOfTimeError:
            return None
        if left.difference(*(step.mended for step in steps)):
            steps = list(itertools.takewhile(lambda step: not step.is_doubtful, steps))
        if not any(step.mended for step in steps):
            return None
        left = left.difference(*(step.mended for step in steps))
        last_name = self._name_if_certain(steps[0].change.text) if len(steps) > 1 or left else None
        return Mending(tuple(map_steps_to_original_lines(source, steps)), left, last_name, bool(self._suffix))

    def _name_if_certain(self, source: str) -> Diagnosis | None:
        named = self._grader.name_mistakes(source + self._suffix, self._programs, self._seed)
        return self._grader.describe_mistakes(replace(named, grounds={})) if named.ids and named.certain else None

    def values_at(self, source: str, line: int, function: str, arguments: Arguments) -> list[tuple[str, float]]:
        """Return the numbers that a line reads when a call first comes to it, in the program as it is."""
        noted = insert_variable_recorder(source, line)
        if noted is None:
            return []
        kit = self._grader.kit(stream(self._seed, "kit"))
        return VariantCaller(self._programs).read_variables(noted[0], function, arguments, noted[1], kit)

    def _can_load(self, source: str) -> bool:
        try:
            self._programs.open((source + self._suffix).encode(), self._grader.kit(stream(self._seed, "kit"))).close()
        except StudentFault:
            return False
        return True

    def _search_steps(
        self, source: str, failed: frozenset[str], most: int, within: Collection[str], helpers: Collection[str]
    ) -> list[MendingStep]:
        """Return at most `most` changes, one after the other, that mend as many of the failed checks as possible.

        A change of which no check passes counts where the next one mends more than it would alone. Where the time is
        spent, what was found before is returned.
        """
        blamed = {name for check in self._grader.checks if check.id in failed for name in check.functions}
        functions = sorted(blamed.intersection(within) or blamed)
        model = self._grader.prober.model if self._grader.prober else None
        changes = find_changes(source, sorted(helpers) or functions, model, self._spent, self._apart)
        self.tried += len(changes)
        tried: list[tuple[ProgramChange, frozenset[str]]] = []
        seen: dict[str, LineEvidence] = {}
        failed_checks = [check for check in self._grader.checks if check.id in failed]
        screened = self._screen.select_mending_changes(source, changes, functions, failed_checks)
        if any(check.requires_other_check for check in failed_checks):
            screened = [*_unscreened_copies(changes, screened), *screened]
        for change in screened[:MAX_VERIFIED]:
            if self._spent() and tried:
                break
            is_late = len(tried) < MAX_LATE
            left = frozenset(check.id for check in self.failed_checks(change.text, is_late, before=failed))
            if not left <= failed:
                continue
            if left < failed:
                left = failed - self.checks_mended_on_other_seeds(change, failed - left)
                seen[change.text] = self._compare_line_values(source, change, functions)
            if seen.get(change.text) is LineEvidence.RIGHT:
                continue
            tried.append((change, left))
            if not left:
                tried += self._equivalent_changes_elsewhere(change, screened[screened.index(change) + 1 :], failed)
                break
        tried.sort(
            key=lambda pair: (len(pair[1]), seen.get(pair[0].text) is not LineEvidence.WRONG, pair[0].is_unlikely)
        )
        if not tried:
            return []
        best, left = tried[0]
        alike = tuple(change for change, other in tried[1:] if other == left)
        doubtful = {c.text for c, _ in tried if c.is_unlikely and seen.get(c.text) is not LineEvidence.WRONG}
        borne_out = {text for text, values in seen.items() if values is LineEvidence.WRONG}
        first = MendingStep(best, failed - left, alike, best.text in doubtful, best.text in borne_out)
        steps = [first] if left < failed else []
        if most == 1 or not left:
            return steps
        for change, other in tried[:MAX_BEGUN]:
            if self._spent():
                break
            further = self._search_steps(change.text, other, most - 1, within, helpers)
            if further and (mended := (failed - other).union(*(step.mended for step in further))) > failed - left:
                is_doubtful, is_borne_out = change.text in doubtful, change.text in borne_out
                begun = MendingStep(change, failed - other, (), is_doubtful, is_borne_out)
                steps, left = [begun, *further], failed - mended
        return steps

    def _equivalent_changes_elsewhere(
        self, change: ProgramChange, others: Sequence[ProgramChange], failed: frozenset[str]
    ) -> list[tuple[ProgramChange, frozenset[str]]]:
        """Return changes of a few other lines that also mend all that fails, with what they leave: nothing."""
        by_line = {other.line: other for other in reversed(others) if other.line != change.line}
        found = []
        for other in sorted(by_line.values(), key=others.index)[:MAX_OTHER_LINES]:
            with suppress(OutOfTimeError):
                if self.failed_checks(other.text) or self.checks_mended_on_other_seeds(other, failed) != failed:
                    continue
                found.append((other, frozenset[str]()))
        return found

    def _compare_line_values(self, source: str, change: ProgramChange, functions: Sequence[str]) -> LineEvidence:
        """Return what the values of a changed line, in the calls of some wrong probes, say of it."""
        texts = [
            insert_line_recorder(source, change.line),
            insert_line_recorder(change.text, change.line),
            insert_all_recorders(self._grader.solution),
        ]
        if change.further_lines or change.operator in REORDERING or None in texts:
            return LineEvidence.UNKNOWN
        *mine, solution = [text for text in texts if text is not None]
        rows: list[list[Sequence[Sequence[float]]]] = [[], [], []]
        for probes, pivots in self._screen.pivots.get(source, ()):
            if probes.function in functions and pivots and not probes.random:
                calls = [probes.calls[k] for k in pivots]
                seen = self._caller.record_line_values(mine, probes.function, calls, probes.kit)
                seen += VariantCaller(self._programs).record_line_values([solution], probes.function, calls, probes.kit)
                for row, answers in zip(rows, seen, strict=len(seen) == len(rows)):
                    row += [answer.value if isinstance(answer, Reply) else () for answer in answers]
        return judge_line_by_values(*rows)

    def checks_mended_on_other_seeds(self, change: ProgramChange, mended: frozenset[str]) -> frozenset[str]:
        """Return those of the checks that a change mends which pass on the inputs of other seeds too.

        A closed loop has the same runs for everybody. What a function passes that does nothing shows no place, unless
        the change is a copy.
        """
        checks = [check for check in self._grader.checks if check.id in mended]
        if change.operator != COPY and not change.mistake and all(check.requires_other_check for check in checks):
            return frozenset()
        held = [check for check in checks if not isinstance(check, ClosedLoop)]
        for seed in range(self._seed + 1, self._seed + 1 + MAX_SEEDS):
            failed = self.failed_checks(change.text, is_late=True, seed=seed, checks=held) if held else []
            mended = mended.difference(check.id for check in failed)
            held = [check for check in held if check.id in mended]
        return mended

    def failed_checks(
        self, source: str, is_late: bool = False, seed: int | None = None, checks: Sequence[Check] = (),
        before: Collection[str] = (),
    ) -> list[Check]:  # fmt: skip
        """Return the checks that a program fails, without shrinking; all of them where it does not load.

        They are all checks, of this search's seed, unless others are given. Those that failed `before` come first:
        where all of these still do, the change mends nothing, and the others are not run. Raises OutOfTimeError where
        the time is spent, unless it may be late.
        """
        if self._spent() and not is_late:
            raise OutOfTimeError
        seed = self._seed if seed is None else seed
        checks = sorted(checks or self._grader.checks, key=lambda check: check.id not in before)
        kit = self._grader.kit(stream(seed, "kit"))
        runner = Runner(self._programs, (source + self._suffix).encode(), kit, budget=NO_SHRINKING)
        failed: list[Check] = []
        try:
            _ = runner.program
            for number, check in enumerate(checks):
                if before and len(failed) == len(before) and check.id not in before:
                    break
                finding = run_check(check, Bench(check.id, runner, stream(seed, check.id), kit))
                if not finding.passed:
                    failed.append(check)
                    runner.failed.add(check.id)
                    if finding.cause is Outcome.TIMEOUT:
                        return [*failed, *checks[number + 1 :]]
        except StudentFault:
            return list(checks)
        finally:
            runner.close()
        return failed


def _unscreened_copies(changes: Sequence[ProgramChange], screened: Sequence[ProgramChange]) -> list[ProgramChange]:
    """Return the first copies that change no answer of a function: its only fault may be to modify its arguments."""
    copies = [change for change in changes if change.operator == COPY and change not in screened]
    return copies[:MAX_COPIES]


def repeatable_failures(source: str, verdict: Verdict) -> list[str]:
    """Return the checks that the program as it is fails each time; none where it may draw, or remember.

    A verdict may hold a check against a function that remembers, which a run of that check alone does not fail.
    """
    if _OWN_DRAWS.search(source) or may_change_state(source.encode()):
        return []
    return [check.id for check in verdict.checks if not check.passed]


def map_steps_to_original_lines(source: str, steps: Sequence[MendingStep]) -> Iterator[MendingStep]:
    """Yield the steps with the lines of the program as it was: a first change may add lines, or take some away."""
    text = source
    for step in steps:
        matcher = difflib.SequenceMatcher(None, text.splitlines(), source.splitlines(), autojunk=False)
        places = {
            begin + k + 1: start + min(k, max(0, stop - start - 1)) + 1
            for _, begin, end, start, stop in matcher.get_opcodes()
            for k in range(end - begin)
        }
        further = tuple(places.get(line, line) for line in step.change.further_lines)
        change = replace(step.change, line=places.get(step.change.line, step.change.line), further_lines=further)
        rivals = tuple(replace(rival, line=places.get(rival.line, rival.line)) for rival in step.rivals)
        yield replace(step, change=change, rivals=rivals)
        text = step.change.text


@runtime_checkable
class MeteredPrograms(Protocol):
    """Programs that run elsewhere, and tell the processor time of those that have ended."""

    def ended_cpu_seconds(self) -> float: ...


def start_time_limit(seconds: float, processor_seconds: float, programs: Programs | None = None) -> Callable[[], bool]:
    """Return whether so many seconds have passed since this call, or so many of processor time.

    That is this thread's time, and that of the programs that have ended, where they are metered.
    """
    deadline, processor_deadline = time.monotonic() + seconds, time.thread_time() + processor_seconds
    metered = programs if isinstance(programs, MeteredPrograms) else None

    def is_spent() -> bool:
        elsewhere = 0.0 if metered is None else metered.ended_cpu_seconds()
        return time.monotonic() > deadline or time.thread_time() + elsewhere > processor_deadline

    return is_spent
