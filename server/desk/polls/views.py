"""The page of a class's answers to the questions of the lessons."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from sqlalchemy.orm import Session

from server.course import Course
from server.desk.views import class_head
from server.polls import repository, service
from server.polls.schemas import AnswerCount, Poll
from server.rights.service import ClassAccess

PATH = "/previsions"


def build_polls_page(db: Session, course: Course, access: ClassAccess) -> dict[str, Any]:
    """Build the page with two queries, however many questions and students there are."""
    module = course.modules.get(access.school_class.module)
    lessons = []
    if module is not None:
        counts = service.load_class_answer_counts(db, access.school_class.id, module)
        titles = {f"/{module.slug}/lire/{lesson.slug}": lesson.title for lesson in module.lessons}
        by_lesson = groupby(service.polls_of_module(module).values(), key=lambda poll: poll.href.partition("#")[0])
        lessons = [
            (titles[href], [_count_answers(poll, counts.get(poll.name, ())) for poll in polls])
            for href, polls in by_lesson
        ]
    return {
        "head": class_head(course, access, PATH),
        "students": repository.count_active_students(db, access.school_class.id),
        "lessons": lessons,
    }


def _count_answers(poll: Poll, said: Sequence[AnswerCount]) -> dict[str, Any]:
    """Count the students who answered, who were right at first, and who chose each option (those still offered)."""
    counting = [(poll.options_counted_for(answer.first), answer.students) for answer in said]
    return {
        "poll": poll,
        "answered": sum(students for chosen, students in counting if chosen),
        "right": sum(students for chosen, students in counting if ",".join(sorted(chosen)) == poll.right),
        "counts": {
            option.id: sum(students for chosen, students in counting if option.id in chosen) for option in poll.options
        },
    }
