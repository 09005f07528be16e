"""The shapes of the HTTP interface for marks, the gradebook and the log (contract, section 6)."""

from datetime import date, datetime
from typing import Annotated, Any, Literal
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict, StrictBody
from server.assignments.models import Mode
from server.marks.models import REASON_LENGTH
from server.marks.states import Counting, DecidedState, MarkState

Points = Annotated[float, Field(ge=0, le=20, description="Out of 20, rounded to the hundredth.")]


class NewMark(StrictBody):
    model_config = ConfigDict(json_schema_extra={"examples": [{"points": 14.5, "reason": "Reprise à l’oral."}]})

    points: Annotated[float | None, Field(ge=0, le=20, description="Out of 20; or `excused`, one of both.")] = None
    excused: Annotated[bool, Field(description="Leaves the exercise out of all means.")] = False
    reason: Annotated[str, Field(max_length=REASON_LENGTH, description="Told to the student, and kept in the log.")]


class OverrideOut(Strict):
    points: Points | None
    excused: bool
    reason: str
    assignment: Annotated[UUID | None, Field(description="The only one in which it holds; null: all.")]
    by: Annotated[str | None, Field(description="Null once that account is erased.")]
    at: datetime
    stale: Annotated[bool, Field(description="Another grading counts than the one that it was based on.")]


class ExerciseMarkOut(Strict):
    """`points` are those in force, `automatic` those of the attempt that counts, as lateness leaves them."""

    exercise: str
    state: Annotated[MarkState | None, Field(description="Null where no assignment of the class asks the exercise.")]
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


class NewDecision(StrictBody):
    model_config = ConfigDict(json_schema_extra={"examples": [{"state": "absent", "reason": "Absent le 12 mars."}]})

    state: Annotated[
        Literal["absent", "excused", "zero"], Field(description="What the assignment comes to for the student.")
    ]
    reason: Annotated[str, Field(max_length=REASON_LENGTH, description="Told to the student, and kept in the log.")] = (
        ""
    )


class DecisionOut(Strict):
    state: DecidedState
    reason: str
    by: Annotated[str | None, Field(description="Null once that account is erased.")]
    at: datetime


class StudentDecision(Strict):
    assignment: UUID
    student: UUID
    decision: DecisionOut


class MarkingIn(StrictBody):
    """What is left out stays as it is. `unanswered`: an exercise without an attempt, of an assignment handed in."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"not_handed_in": "zero"}]})

    not_handed_in: Literal["ignore", "zero"] | None = None
    late_refused: Literal["ignore", "zero"] | None = None
    absent: Literal["ignore", "zero"] | None = None
    unanswered: Literal["ignore", "zero"] | None = None
    version: Annotated[
        int | None, Field(ge=0, le=10**9, description="That of the rules you have read: 409 if they have changed.")
    ] = None


class MarkingRulesOut(Strict):
    """How each state counts in a mean: as 0, or not at all."""

    not_handed_in: Counting
    late_refused: Counting
    absent: Counting
    unanswered: Counting


class MarkingOut(MarkingRulesOut):
    """`chosen`: false for an older class that keeps its rules of before until a teacher chooses."""

    chosen: bool
    version: int


class AssignmentMarkOut(Strict):
    """`counted` is what counts in the student's average, null where nothing does. `decision`: of a teacher."""

    assignment: UUID
    state: MarkState
    points: Points | None
    counted: Points | None
    days_late: Annotated[int, Field(ge=0)]
    exercises: list[ExerciseMarkOut]
    decision: DecisionOut | None


class ColumnMarkOut(Strict):
    """`points` are out of the column's `out_of`; `counted` out of 20, of a bonus what it adds."""

    column: UUID
    state: MarkState
    points: float | None
    counted: float | None
    comment: str
    version: int


class GradebookColumn(Strict):
    """A column that teachers type. Students see it from `published_at` on."""

    id: UUID
    title: str
    out_of: float
    taken_on: date | None
    weight: float
    bonus: bool
    published_at: datetime | None
    version: int
    copies: Annotated[int, Field(ge=0)]
    mean: float | None
    median: float | None


class StudentRow(Strict):
    id: UUID
    name: str
    groups: list[str]
    average: Points | None
    marks: Annotated[list[AssignmentMarkOut], Field(description="In the order of `assignments`.")]
    columns: Annotated[list[ColumnMarkOut], Field(description="In the order of `columns`.")]


class ClassNamed(Strict):
    id: UUID
    name: str
    module: str


class GradebookOut(Strict):
    model_config = ConfigDict(populate_by_name=True)

    class_: Annotated[ClassNamed, Field(alias="class")]
    generated_at: datetime
    marking: MarkingRulesOut
    assignments: list[AssignmentColumn]
    columns: list[GradebookColumn]
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
