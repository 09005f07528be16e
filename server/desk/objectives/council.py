"""The sheet for the conseil de classe: a line or two of each student, without a word on any other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base import school_time
from server.board.catalogue import find_misconception
from server.board.objective_loading import ClassObjectives
from server.board.objectives import RULE, Mastery, ObjectiveState
from server.course import Course
from server.desk.objectives.views import load_class_objectives
from server.desk.schemas import ClassHead
from server.desk.views import class_head, class_href
from server.rights.service import ClassAccess
from server.web.words import count_with_noun

WEEK = timedelta(days=7)
MAX_WEAK = 3


@dataclass(frozen=True)
class CouncilRow:
    """A student on the sheet of the conseil de classe: one line or two, of them alone."""

    name: str
    href: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class CouncilPage:
    head: ClassHead
    since: datetime
    until: datetime
    first_day: str
    rows: tuple[CouncilRow, ...]
    rule: str


def build_council_page(db: Session, course: Course, access: ClassAccess, now: datetime, since: datetime) -> CouncilPage:
    """Build the sheet of a class for the period from `since`."""
    loaded = load_class_objectives(db, course, access.school_class, now)
    href = class_href(access.school_class)
    return CouncilPage(
        head=class_head(course, access, "/objectifs"),
        since=since,
        until=loaded.progress.now,
        first_day=f"{school_time.to_local(since):%Y-%m-%d}",
        rows=tuple(
            CouncilRow(
                student.name,
                f"{href}/eleves/{student.id}/objectifs",
                describe_student(course, loaded, student.id, since),
            )
            for student in loaded.progress.students
        ),
        rule=RULE,
    )


def describe_student(course: Course, loaded: ClassObjectives, student: UUID, since: datetime) -> tuple[str, ...]:
    """Return what is to be said of a student in one line or two, without a word on any other."""
    states = loaded.states_by_student[student]
    times = [
        attempt.sent_at
        for series in loaded.attempts_by_student.get(student, {}).values()
        for attempt in series
        if since <= attempt.sent_at
    ]
    mastered = [found for found in states if found.state is Mastery.mastered]
    begun = sum(found.state is not Mastery.none for found in states)
    lately = [found for found in mastered if found.mastered_at is not None and found.mastered_at >= since]
    if not begun:
        return ("Aucun objectif commencé.",)
    acquired = count_with_noun(len(mastered), "objectif acquis", "objectifs acquis")
    first = f"{acquired} sur {count_with_noun(begun, 'commencé')}"
    if 0 < len(lately) < len(mastered):
        first += f", dont {len(lately)} dans la période"
    weeks = len({(moment - since) // WEEK for moment in times})
    work = (
        f"{count_with_noun(len(times), 'essai')} sur {count_with_noun(weeks, 'semaine')}"
        if times
        else "aucun essai dans la période"
    )
    lines = [f"{first} ; {work}."]
    weak = [found for found in states if found.state is Mastery.weak]
    if weak:
        names = [_lower_first_letter(found.objective.objective.short) for found in weak]
        others = f" et {len(names) - MAX_WEAK} autres" if len(names) > MAX_WEAK + 1 else ""
        shown = names[:MAX_WEAK] if others else names
        lines.append(f"À retravailler : {', '.join(shown)}{others}.{_remaining_mistake(course, weak)}")
    return tuple(lines)


def _lower_first_letter(short: str) -> str:
    return short[0].lower() + short[1:]


def _remaining_mistake(course: Course, weak: Sequence[ObjectiveState]) -> str:
    """Return a sentence with the first mistake that remains; empty where none is known."""
    mistakes = [mistake for found in weak for mistake in found.mistakes]
    if not mistakes:
        return ""
    return f" Erreur persistante : « {find_misconception(course, *mistakes[0]).diagnosis.title} »."
