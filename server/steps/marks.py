"""Which line of a program a named misconception speaks of: the one at which undoing it makes the check pass."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from graders.core.code.exercise import CodeDefinition
from graders.core.code.locating import Repair, repairs
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Foreseen, KitSettings, Program, Programs, StudentFault
from graders.typography import french
from server.steps.schemas import MarkOut

#: Repaired programs that are tried, those after one that passes, and the seconds that they may take.
MOST, DOUBTS, LONGEST = 60, 12, 1.0


def of(
    definition: CodeDefinition, mistakes: Sequence[str], source: bytes, check_id: str, programs: Programs, *, seed: int
) -> MarkOut | None:
    """None where nothing is named, where no change of the program undoes the mistake, and where several lines do."""
    known = next((one for one in definition.misconceptions if one.id in mistakes), None)
    if known is None or definition.prober is None:
        return None
    try:
        text = source.decode()
    except UnicodeDecodeError:
        return None
    until = time.monotonic() + LONGEST

    def spent() -> bool:
        return time.monotonic() > until

    found = repairs(definition.prober.model, known.id, known.functions, text, spent)
    hurried = itertools.takewhile(lambda _: not spent(), itertools.islice(found, MOST))
    lines = _that_undo_it(definition, text, hurried, check_id, _Until(programs, spent), seed)
    return MarkOut(line=lines.pop()[0], words=french(known.title)) if len(lines) == 1 else None


@dataclass(frozen=True)
class _Until:
    """Programs of which none starts any more once one's patience is spent: a check may start dozens."""

    programs: Programs
    spent: Callable[[], bool]

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[Foreseen] = ()) -> Program:
        if self.spent():
            raise StudentFault(Outcome.TIMEOUT, "", fatal=True)
        return self.programs.open(source, kit, ahead)


def _that_undo_it(
    definition: CodeDefinition, text: str, found: Iterable[Repair], check_id: str, programs: _Until, seed: int
) -> set[tuple[int, ...]]:
    """The lines at which the program is changed, and by no change too many, so that it passes the check.

    None where it passes as it is. Once there are some, a few others are tried, which would make it a doubt.
    """
    grader = definition.bind(sorted(definition.judged))
    checks = [check for check in grader.checks if check.id == check_id]
    lines: set[tuple[int, ...]] = set()
    after = 0

    def passes(text: str) -> bool:
        return grader.first_failed(text.encode(), programs, seed=seed, checks=checks) is None

    for place, repair in enumerate(found):
        if (place == 0 and passes(text)) or after > DOUBTS:
            break
        after += bool(lines)
        if repair.lines in lines or not passes(repair.text) or any(map(passes, repair.parts)):
            continue
        if not (repair.parts and programs.spent()):  # what could not be tried has not failed
            lines.add(repair.lines)
    return lines
