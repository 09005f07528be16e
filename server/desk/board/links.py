"""Titles and addresses of what the pages of a board name."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from urllib.parse import quote
from uuid import UUID

from server.board.schemas import BoardStudent
from server.course import Course


@dataclass(frozen=True)
class BoardLinks:
    """`href`: the address of the class; `students`: those on its board."""

    course: Course
    href: str
    students: Sequence[BoardStudent]

    def title(self, exercise: str) -> str:
        known = self.course.exercises.get(exercise)
        return known.title if known else exercise

    def exercise_href(self, exercise: str) -> str:
        """Return the address of an exercise, empty for one that has left the course."""
        return f"/{exercise.replace('/', '/exercices/', 1)}" if exercise in self.course.exercises else ""

    def people(self, students: Collection[UUID], exercise: str) -> tuple[tuple[str, str], ...]:
        """Return the names of students, in the order of the list, with the addresses of their work at an exercise."""
        wanted = set(students)
        return tuple(
            (student.name, work_href(self.href, student.id, exercise))
            for student in self.students
            if student.id in wanted
        )


def work_href(class_href: str, student: UUID, exercise: str) -> str:
    """Return the address of what a student of a class has sent to an exercise."""
    return f"{class_href}/eleves/{student}/{exercise}"


def misconception_href(class_href: str, exercise: str, misconception: str) -> str:
    return f"{class_href}/erreurs/{exercise}/{quote(misconception, safe='')}"
