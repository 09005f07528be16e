"""What streams of the questions of a class show: the numbers of answers, read once for all who watch."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.board.live import ClassView
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course
from server.polls import repository as polls
from server.warmup import service
from server.warmup.schemas import QuestionWithCounts
from server.web.rendering import jinja_environment


@dataclass(frozen=True)
class ShownWarmUp:
    """Today's questions with the answers of the class; none where none were prepared."""

    questions: Sequence[QuestionWithCounts]
    students: int

    @property
    def version(self) -> Hashable:
        return self.students, tuple(tuple(count.students for count in row.counts) for row in self.questions)


def load_warm_up(
    db: Session, _course: Course, school_class: SchoolClass, _now: datetime, _pulse: Sequence[object]
) -> ShownWarmUp:
    warm_up = service.find_todays_warm_up(db, school_class.id)
    questions = [] if warm_up is None else service.count_answers(db, school_class, warm_up)
    return ShownWarmUp(questions, polls.count_active_students(db, school_class.id))


def load_warm_up_pulse(db: Session, class_id: UUID) -> Sequence[object]:
    """Load the numbers themselves: reading them costs as much as a tag of them would."""
    school_class = classes.find_class(db, class_id)
    warm_up = None if school_class is None else service.find_todays_warm_up(db, class_id)
    if school_class is None or warm_up is None:
        return []
    names = service.question_poll_names(school_class, warm_up)
    return [warm_up.id, polls.count_active_students(db, class_id), *polls.load_answer_counts(db, class_id, names)]


WARM_UP: ClassView[Sequence[object], ShownWarmUp] = ClassView(load_warm_up_pulse, load_warm_up)


def render_counts(shown: ShownWarmUp) -> dict[str, str]:
    """Render the answers to each question, for who teaches."""
    return {f"answers-{k}": str(_macros().answers(row, shown.students)) for k, row in enumerate(shown.questions, 1)}


def render_wall(shown: ShownWarmUp, number: int, *, shows_answers: bool) -> dict[str, str]:
    """Render what changes of a projected question; nothing where there is no such question."""
    if not 0 <= number < len(shown.questions):
        return {}
    row = shown.questions[number]
    options = {"options": str(_macros().options(row))} if shows_answers else {}
    return {"answered": str(_macros().answered(row, shown.students)), **options}


def _macros() -> Any:
    return jinja_environment().get_template("classes/warm_up_parts.html").module
