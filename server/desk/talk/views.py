"""The pages of a class's questions, and of notes to several of its students."""

from __future__ import annotations

from typing import Any

from server.base.errors import Invalid
from server.classes.repository import load_members
from server.comments import notes_repository, service
from server.comments.models import ThreadState
from server.course import Course, Exercise, Module
from server.desk.talk.work_views import find_class_exercise
from server.desk.views import class_head
from server.rights.service import ClassAccess
from server.web.threads import UnsentMessageDraft
from server.web.views import (
    Reader,
    exercise_href,
    exercises_in_reading_order,
    lesson_href,
    lessons_in_reading_order,
)

#: The values of `etat` in the address; the first is the default.
FILTERS: dict[str, tuple[ThreadState | None, str]] = {
    "ouvertes": (ThreadState.open, "À répondre"),
    "repondues": (ThreadState.answered, "Répondus"),
    "reglees": (ThreadState.settled, "Réglés"),
    "toutes": (None, "Toutes les discussions"),
}
FOREIGN_LINK = "Choisissez une page ou un exercice de ce module."


def build_questions_page(reader: Reader, access: ClassAccess, wanted: str, number: int) -> dict[str, Any]:
    """Build page `number` of the threads in the state `wanted`, one of FILTERS."""
    state, _ = FILTERS[wanted]
    return {
        "head": class_head(reader.course, access, "/questions"),
        "filters": [(name, *FILTERS[name]) for name in FILTERS],
        "wanted": wanted,
        "listed": service.load_thread_page(reader.db, access.school_class, state, number),
    }


def build_notes_page(
    reader: Reader,
    access: ClassAccess,
    exercise: str,
    mistake: str,
    link: str = "",
    draft: UnsentMessageDraft | None = None,
) -> dict[str, Any]:
    """Build the notes sent so far and, for a chosen exercise, the form of the next one. Raise NotFound."""
    class_id, module = access.school_class.id, reader.course.modules.get(access.school_class.module)
    chosen = find_class_exercise(reader, access, *exercise.split("/", 1)) if "/" in exercise else None
    return {
        "head": class_head(reader.course, access, "/questions"),
        "exercises": exercises_in_reading_order(module) if module else (),
        "chosen": chosen,
        "form": _note_form(reader, access, module, chosen, mistake) if chosen and module else None,
        "link": link,
        "draft": draft or UnsentMessageDraft(),
        "sent": notes_repository.load_class_notes(reader.db, class_id),
    }


def _note_form(reader: Reader, access: ClassAccess, module: Module, exercise: Exercise, mistake: str) -> dict[str, Any]:
    """`mistake` restricts the readers to those who have it now; empty: everyone who tried the exercise."""
    class_id = access.school_class.id
    readers = notes_repository.load_student_ids_with_misconception(reader.db, class_id, exercise.id, mistake or None)
    return {
        "mistake": mistake,
        "mistakes": notes_repository.load_current_misconceptions(reader.db, class_id, exercise.id),
        "students": [member.name for member in load_members(reader.db, class_id, readers)],
        "links": _link_groups(module),
    }


def _link_groups(module: Module) -> list[tuple[str, list[tuple[str, str]]]]:
    lessons = [(lesson_href(lesson), lesson.title) for lesson in lessons_in_reading_order(module)]
    exercises = [(exercise_href(exercise), exercise.title) for exercise in exercises_in_reading_order(module)]
    return [group for group in (("Pages du cours", lessons), ("Exercices", exercises)) if group[1]]


def validate_link(course: Course, access: ClassAccess, link: str) -> str:
    """Return the address of a page or an exercise of the class's module, or an empty one. Raise Invalid."""
    module = course.modules.get(access.school_class.module)
    known = {address for _, group in _link_groups(module) for address, _ in group} if module else set()
    if link and link not in known:
        raise Invalid(FOREIGN_LINK)
    return link
