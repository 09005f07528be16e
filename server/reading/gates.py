"""The answers of a paper: who reads them, and what stands there instead for who does not yet."""

from __future__ import annotations

from server.course.models import Lesson
from server.gradebook import solutions
from server.reading.schemas import SolutionGate
from server.rights import service as rights
from server.web.views import Reader, build_solution_switch_view, lesson_href

#: What an archive shows: it is anybody's file, and no teacher could close it again.
ONLINE = SolutionGate("online")


def choose_solution_gate(reader: Reader, lesson: Lesson, *, is_warning_read: bool) -> SolutionGate | None:
    """None for an ordinary page, and for answers that are open to a student.

    The students of a class read them once a teacher has opened them to it; who is of no class, past a warning.
    """
    if not lesson.solution:
        return None
    access = solutions.load_solution_access(reader.db, reader.account, lesson.id)
    if access.teaches:
        doors = tuple(map(build_solution_switch_view, solutions.list_audiences(reader.db, reader.account, lesson.id)))
        return SolutionGate("open", action=f"{lesson_href(lesson)}/corrige", doors=doors)
    if access.to_all or access.to_class:
        return None
    if rights.is_student(reader.db, reader.account, lesson.module):
        return SolutionGate("kept")
    return None if is_warning_read else SolutionGate("warned", onward=f"{lesson_href(lesson)}?ouvrir=oui")
