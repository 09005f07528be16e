"""From the answers of a class to what its page of predictions shows."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from sqlalchemy.orm import Session

from server.course import Course
from server.desk.polls.schemas import LessonPolls, OptionRow, PollRow, PollsPage
from server.desk.views import class_head
from server.polls import repository, service
from server.polls.schemas import AnswerCount, Poll
from server.rights.service import ClassAccess

PATH = "/previsions"


def build_polls_page(db: Session, course: Course, access: ClassAccess) -> PollsPage:
    """Two queries, however many questions and students there are."""
    module = course.modules.get(access.school_class.module)
    lessons: tuple[LessonPolls, ...] = ()
    if module is not None:
        said = service.load_class_answer_counts(db, access.school_class.id, module)
        titles = {f"/{module.slug}/lire/{lesson.slug}": lesson.title for lesson in module.lessons}
        asked = groupby(service.polls_of_module(module).values(), key=lambda poll: poll.href.partition("#")[0])
        lessons = tuple(
            LessonPolls(titles[href], tuple(_poll_row(poll, said.get(poll.name, ())) for poll in polls))
            for href, polls in asked
        )
    return PollsPage(
        class_head(course, access, PATH), repository.count_active_students(db, access.school_class.id), lessons
    )


def _poll_row(poll: Poll, said: Sequence[AnswerCount]) -> PollRow:
    """Answers that the question no longer offers are not counted."""
    counting = [(poll.counted_options(answer.first), answer.students) for answer in said]
    answered = sum(students for chosen, students in counting if chosen)
    counts = {
        option.id: sum(students for chosen, students in counting if option.id in chosen) for option in poll.options
    }
    options = tuple(
        OptionRow(option.words, option.right, counts[option.id], round(100 * counts[option.id] / max(1, answered)))
        for option in poll.options
    )
    found = sum(students for chosen, students in counting if ",".join(sorted(chosen)) == poll.right)
    return PollRow(poll.title, poll.href, poll.question, answered, found, options)
