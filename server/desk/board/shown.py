"""A class, and where things of it are: what its board's pages share."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from urllib.parse import quote
from uuid import UUID

from server.board.schemas import Board, BoardStudent
from server.course import Course


@dataclass(frozen=True)
class Shown:
    """The students of a class, with what pages need to name things: the course, and where the class is."""

    course: Course
    href: str
    students: Sequence[BoardStudent]

    def title(self, exercise: str) -> str:
        found = self.course.exercises.get(exercise)
        return found.title if found else exercise

    def exercise_href(self, exercise: str) -> str:
        """Empty for an exercise that has left the course."""
        return f"/{exercise.replace('/', '/exercices/', 1)}" if exercise in self.course.exercises else ""

    def people(self, students: Collection[UUID], exercise: str) -> tuple[tuple[str, str], ...]:
        """Name, and address of what they did at the exercise, in the order of the list."""
        wanted = set(students)
        return tuple((one.name, work_href(self.href, one.id, exercise)) for one in self.students if one.id in wanted)


@dataclass(frozen=True)
class ShownBoard(Shown):
    """With its board."""

    board: Board

    @classmethod
    def of(cls, course: Course, href: str, board: Board) -> ShownBoard:
        return cls(course, href, board.students, board)


def work_href(class_href: str, student: UUID, exercise: str) -> str:
    """What a student of a class has sent to an exercise."""
    return f"{class_href}/eleves/{student}/{exercise}"


def mistake_href(class_href: str, exercise: str, misconception: str) -> str:
    return f"{class_href}/erreurs/{exercise}/{quote(misconception, safe='')}"
