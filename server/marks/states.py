"""The states of a mark, their words, and how a class counts each of them in its means: pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class MarkState(StrEnum):
    """What a mark is. `upcoming`: not open yet; `open`: work may still be sent that counts; `done`: it has points, of
    which 0 are one case; `late_refused`: all that was sent came too late; `absent`: a teacher says so; `not_concerned`:
    the assignment is for groups of which the student is none."""

    upcoming = "upcoming"
    open = "open"
    done = "done"
    not_handed_in = "not_handed_in"
    late_refused = "late_refused"
    absent = "absent"
    excused = "excused"
    not_concerned = "not_concerned"


class DecidedState(StrEnum):
    """What a teacher may decide about a whole assignment of a student."""

    absent = "absent"
    excused = "excused"
    zero = "zero"


class TypedState(StrEnum):
    """What a teacher may type in a manual column in place of points."""

    absent = "absent"
    excused = "excused"
    not_handed_in = "not_handed_in"


class Counting(StrEnum):
    """How a mark without points counts in a mean."""

    ignore = "ignore"
    zero = "zero"


#: What tables, pages and files show where there are no points.
STATE_WORDS: Mapping[MarkState, str] = {
    MarkState.upcoming: "à venir",
    MarkState.open: "à venir",
    MarkState.not_handed_in: "non rendu",
    MarkState.late_refused: "refusé (retard)",
    MarkState.absent: "absent",
    MarkState.excused: "dispensé",
    MarkState.not_concerned: "non concerné",
}
#: Those that count as the class has chosen.
UNMARKED_STATES = frozenset({MarkState.not_handed_in, MarkState.late_refused, MarkState.absent})
#: Those in which nothing of an assignment counts.
LEFT_OUT = frozenset({MarkState.excused, MarkState.not_concerned})
#: Those of an assignment that are also those of each of its exercises, whatever was sent.
WHOLE_STATES = LEFT_OUT | {MarkState.absent}


@dataclass(frozen=True)
class MarkingRules:
    """How each state counts in a class. `unanswered`: an exercise without an attempt in an assignment handed in.

    By default only what a student answered counts, and the blanks of a copy that was handed in. What is excused, or not
    due yet, never counts.
    """

    not_handed_in: Counting = Counting.ignore
    late_refused: Counting = Counting.ignore
    absent: Counting = Counting.ignore
    unanswered: Counting = Counting.zero

    def points_without_mark(self, state: MarkState) -> float | None:
        """Return what a state without points counts: 0, or None where it does not."""
        if state not in UNMARKED_STATES:
            return None
        rule: Counting = getattr(self, state.value)
        return 0.0 if rule is Counting.zero else None


DEFAULT_RULES = MarkingRules()


@dataclass(frozen=True)
class ClassMarking:
    """The rules of a class. `is_chosen`: by a teacher, or by default; an older class keeps the rules of before until
    then. `version` is 0 where nothing is stored."""

    rules: MarkingRules = DEFAULT_RULES
    is_chosen: bool = True
    version: int = 0
