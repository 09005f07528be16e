"""The shapes of the HTTP interface for marks, the gradebook and the log (contract, section 6)."""

from datetime import datetime
from typing import Annotated, Any
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict
from server.assignments.models import Mode
from server.marks.models import REASON_LENGTH
from server.marks.schemas import MarkState

Points = Annotated[float, Field(ge=0, le=20, description="Out of 20, rounded to the hundredth.")]


class NewMark(Strict):
    model_config = ConfigDict(json_schema_extra={"examples": [{"points": 14.5, "reason": "Reprise à l’oral."}]})

    points: Annotated[float | None, Field(ge=0, le=20, description="Out of 20; or `excused`, one of both.")] = None
    excused: Annotated[bool, Field(description="Leaves the exercise out of all means.")] = False
    reason: Annotated[str, Field(max_length=REASON_LENGTH, description="Told to the student, and kept in the log.")]


class OverrideOut(Strict):
    points: Points | None
    excused: bool
    reason: str
    by: Annotated[str | None, Field(description="Null once that account is erased.")]
    at: datetime
    stale: Annotated[bool, Field(description="Another grading counts than the one that it was based on.")]


class ExerciseMarkOut(Strict):
    """`points` are those in force, `automatic` those of the attempt that counts, as lateness leaves them."""

    exercise: str
    points: Points | None
    automatic: Points | None
    excused: bool
    days_late: Annotated[int, Field(ge=0)]
    attempts: Annotated[int, Field(ge=0, description="Within the dates.")]
    override: OverrideOut | None


class MarkOut(Strict):
    student: UUID
    mark: ExerciseMarkOut


class WeightedOut(Strict):
    exercise: str
    weight: float


class AssignmentColumn(Strict):
    """`mean` and `median` are of the copies that were sent. `held_back`: students are told nothing of it yet."""

    id: UUID
    title: str
    mode: Mode
    weight: float
    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    held_back: bool
    exercises: list[WeightedOut]
    copies: Annotated[int, Field(ge=0)]
    mean: Points | None
    median: Points | None


class AssignmentMarkOut(Strict):
    assignment: UUID
    state: MarkState
    points: Points | None
    days_late: Annotated[int, Field(ge=0)]
    exercises: list[ExerciseMarkOut]


class StudentRow(Strict):
    id: UUID
    name: str
    groups: list[str]
    average: Points | None
    marks: Annotated[list[AssignmentMarkOut], Field(description="In the order of `assignments`.")]


class ClassNamed(Strict):
    id: UUID
    name: str
    module: str


class GradebookOut(Strict):
    model_config = ConfigDict(populate_by_name=True)

    class_: Annotated[ClassNamed, Field(alias="class")]
    generated_at: datetime
    assignments: list[AssignmentColumn]
    students: list[StudentRow]


class NamedOut(Strict):
    id: UUID
    name: str


class EventOut(Strict):
    """One change. `by` is null once that account is erased; `words` says `what` in French."""

    id: UUID
    at: datetime
    by: NamedOut | None
    what: str
    words: str
    student: NamedOut | None
    about: str
    before: dict[str, Any]
    after: dict[str, Any]
    reason: str


class LogOut(Strict):
    """Some of the events, newest first, and how many there are in all."""

    total: Annotated[int, Field(ge=0)]
    events: list[EventOut]
