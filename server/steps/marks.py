"""Locates the line of a named misconception: the line at which undoing the mistake makes the check pass."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from graders.core.code.exercise import CodeDefinition
from graders.core.code.repairs import Repair, find_repairs
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PlannedCalls, Program, Programs, StudentFault
from graders.typography import french
from server.steps.schemas import MarkOut

#: Maximum number of repairs tried, of those tried after a first success, and seconds for all of them.
MAX_REPAIRS, MAX_FURTHER_REPAIRS, MAX_SECONDS = 60, 12, 1.0


def locate_mistake(
    definition: CodeDefinition, mistakes: Sequence[str], source: bytes, check_id: str, programs: Programs, *, seed: int
) -> MarkOut | None:
    """Return the line to mark; None where nothing is named, no repair undoes the mistake, or several lines do."""
    named = next((mistake for mistake in definition.misconceptions if mistake.id in mistakes), None)
    if named is None or definition.prober is None:
        return None
    try:
        text = source.decode()
    except UnicodeDecodeError:
        return None
    deadline = time.monotonic() + MAX_SECONDS

    def spent() -> bool:
        return time.monotonic() > deadline

    candidates = find_repairs(definition.prober.model, named.id, named.functions, text, spent)
    within_time = itertools.takewhile(lambda _: not spent(), itertools.islice(candidates, MAX_REPAIRS))
    lines = _find_repairing_lines(definition, text, within_time, check_id, _TimeLimitedPrograms(programs, spent), seed)
    return MarkOut(line=lines.pop()[0], words=french(named.title)) if len(lines) == 1 else None


@dataclass(frozen=True)
class _TimeLimitedPrograms:
    """Starts no program once the time is spent: a check may start dozens."""

    programs: Programs
    is_expired: Callable[[], bool]

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        if self.is_expired():
            raise StudentFault(Outcome.TIMEOUT, "", fatal=True)
        return self.programs.open(source, kit, ahead)


def _find_repairing_lines(
    definition: CodeDefinition,
    text: str,
    candidates: Iterable[Repair],
    check_id: str,
    programs: _TimeLimitedPrograms,
    seed: int,
) -> set[tuple[int, ...]]:
    """Return the lines of minimal repairs with which the program passes the check.

    Empty where it passes as it is. After the first success, a few more repairs are tried, to find ambiguities.
    """
    grader = definition.bind(sorted(definition.judged_functions))
    checks = [check for check in grader.checks if check.id == check_id]
    lines: set[tuple[int, ...]] = set()
    after = 0

    def passes(text: str) -> bool:
        return grader.first_failed_check(text.encode(), programs, seed=seed, checks=checks) is None

    for index, repair in enumerate(candidates):
        if (index == 0 and passes(text)) or after > MAX_FURTHER_REPAIRS:
            break
        after += bool(lines)
        if repair.lines in lines or not passes(repair.text) or any(map(passes, repair.parts)):
            continue
        if not (repair.parts and programs.is_expired()):  # parts that could not be tried have not failed
            lines.add(repair.lines)
    return lines
