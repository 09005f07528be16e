"""The exercises that count in a class."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime

from sqlalchemy.orm import Session

from server.assignments import repository
from server.classes.models import SchoolClass
from server.course import Course


@dataclass(frozen=True)
class CountingExercises:
    """The exercises that count in a class, in the course's order. `groups`: the labels to which alone some go."""

    names: tuple[str, ...]
    groups: Mapping[str, frozenset[str]] = field(default_factory=dict)

    def counting_for_student(self, labels: Collection[str]) -> tuple[str, ...]:
        """Return those that count for a student who has these labels."""
        return tuple(name for name in self.names if name not in self.groups or not self.groups[name].isdisjoint(labels))


def load_counting_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> CountingExercises:
    """Load the exercises that count for a class: those of assignments that are open or past.

    The exercises of its teachers come after those of the module.

    Without assignments, all exercises of the module count; none where the module has left this server.
    """
    module = course.modules.get(school_class.module)
    if module is None:
        return CountingExercises(())
    opened = repository.load_opened_exercises(db, school_class.id, now)
    names = tuple(exercise.id for exercise in module.exercises)
    if opened is None:
        return CountingExercises(names)
    own = sorted(name for name in opened if name not in names and name in course.exercises)
    counting = (*(name for name in names if name in opened), *own)
    return CountingExercises(counting, {name: groups for name, groups in opened.items() if groups})


def list_counting_exercises(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Sequence[str]:
    """Return the exercises that count for a class, or for some groups of it."""
    return load_counting_exercises(db, course, school_class, now).names
