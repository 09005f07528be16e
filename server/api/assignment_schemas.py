"""The shapes of the HTTP interface for assignments and exceptions (contract, section 6)."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, Literal
from uuid import UUID

from pydantic import BeforeValidator, ConfigDict, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from server.api.schemas import Strict, StrictBody
from server.assignments.models import AttemptSelection, Mode, Visibility
from server.assignments.rule_sources import Field as RuleField
from server.assignments.rule_sources import Origin

LONGEST_DATE = 40


def _parse_moment(value: object) -> object:
    """ISO 8601 with an offset; None stays. What has no offset would be guessed, and is refused."""
    if value is None or isinstance(value, datetime):
        return value
    try:
        when = datetime.fromisoformat(value) if isinstance(value, str) and len(value) <= LONGEST_DATE else None
        if when is None or when.tzinfo is None:
            raise ValueError(value)
        return when.astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise PydanticCustomError("no_moment", "not a date with an offset") from error


def _parse_uuid(value: object) -> object:
    """An identity as JSON has it: text."""
    try:
        return UUID(value) if isinstance(value, str) else value
    except ValueError as error:
        raise PydanticCustomError("no_identity", "not an identity") from error


MOMENT = {"type": "string", "format": "date-time", "description": "ISO 8601 with an offset."}
MaybeMoment = Annotated[
    datetime | None, BeforeValidator(_parse_moment), WithJsonSchema({"anyOf": [MOMENT, {"type": "null"}]})
]
Name = Annotated[UUID | None, BeforeValidator(_parse_uuid)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Lenient = {"strict": False}  # of JSON, the words of an enumeration are text


class PerDay(StrictBody):
    per_day: Annotated[Number, Field(description="Points out of 20 that each day begun costs: above 0, at most 20.")]


Lateness = Literal["refuse", "accept"] | PerDay


class WeightedIn(StrictBody):
    exercise: Annotated[str, Field(max_length=200, description="Exercise, as `module/slug`.", examples=["l20/poses"])]
    weight: Annotated[Number, Field(description="Among the assignment's exercises; above 0.")] = 1.0


Groups = Annotated[tuple[Annotated[str, Field(max_length=1000)], ...], Field(max_length=50)]


class AssignmentIn(StrictBody):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "title": "Se repérer",
                    "exercises": [{"exercise": "l20/poses", "weight": 2}],
                    "opens_at": "2026-03-16T08:00:00+01:00",
                    "due_at": "2026-03-23T18:00:00+01:00",
                    "closes_at": "2026-03-30T18:00:00+02:00",
                    "late": {"per_day": 2},
                    "mode": "practice",
                    "counts": "best",
                }
            ]
        }
    )

    title: Annotated[str, Field(max_length=1000, description="1 to 200 characters.")]
    exercises: Annotated[list[WeightedIn], Field(max_length=500, description="Of the module, in order.")]
    opens_at: Annotated[MaybeMoment, Field(description="Now, where it is null.")] = None
    due_at: Annotated[MaybeMoment, Field(description="Null: nothing is late.")] = None
    closes_at: Annotated[MaybeMoment, Field(description="Null: it stays open.")] = None
    late: Annotated[Lateness, Field(description="What becomes of what is sent after `due_at`.")] = "accept"
    mode: Annotated[Mode, Field(**Lenient)] = Mode.practice
    counts: Annotated[AttemptSelection, Field(description="Which attempt makes the mark.", **Lenient)] = (
        AttemptSelection.best
    )
    weight: Annotated[Number, Field(description="Of the assignment among the others; above 0.")] = 1.0
    hints: Annotated[Visibility, Field(description="When hints are shown.", **Lenient)] = Visibility.usual
    diagnosis: Annotated[Visibility, Field(description="When the diagnosis is shown.", **Lenient)] = Visibility.usual
    solution: Annotated[Visibility, Field(description="When the solution is shown.", **Lenient)] = Visibility.usual
    duration_minutes: Annotated[int | None, Field(description="Of a test, from when one begins it.")] = None
    groups: Annotated[Groups, Field(description="To whom it is given; empty: to the whole class.")] = ()
    team_size: Annotated[int, Field(description="How many students may hand in together, from 1 to 6.")] = 1
    teams_by_students: Annotated[bool, Field(description="Students form the teams too.")] = False


class AssignmentChange(StrictBody):
    """What is to change; what is not sent stays."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"due_at": "2026-03-25T18:00:00+01:00"}]})

    title: Annotated[str, Field(max_length=1000)] = ""
    exercises: Annotated[list[WeightedIn], Field(max_length=500, default_factory=list)]
    opens_at: Annotated[MaybeMoment, Field(description="Now, where it is null.")] = None
    due_at: MaybeMoment = None
    closes_at: MaybeMoment = None
    late: Lateness = "accept"
    mode: Annotated[Mode, Field(**Lenient)] = Mode.practice
    counts: Annotated[AttemptSelection, Field(**Lenient)] = AttemptSelection.best
    weight: Number = 1.0
    hints: Annotated[Visibility, Field(**Lenient)] = Visibility.usual
    diagnosis: Annotated[Visibility, Field(**Lenient)] = Visibility.usual
    solution: Annotated[Visibility, Field(**Lenient)] = Visibility.usual
    duration_minutes: int | None = None
    groups: Groups = ()
    team_size: int = 1
    teams_by_students: bool = False


class AssignmentOut(Strict):
    """An assignment. To a student its dates, `time_factor` and `excused` are those in force for them."""

    id: UUID
    title: str
    exercises: Annotated[list[WeightedIn] | None, Field(description="Null to a student before a test opens.")]
    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    late: Lateness
    mode: Mode
    counts: AttemptSelection
    weight: float
    hints: Visibility
    diagnosis: Visibility
    solution: Visibility
    duration_minutes: int | None
    groups: Annotated[list[str] | None, Field(description="Empty: the whole class. Null to a student.")]
    team_size: Annotated[int, Field(description="How many students may hand in together.")]
    teams_by_students: bool
    released_at: datetime | None
    time_factor: Annotated[float | None, Field(description="Of the student who asks; null to the staff.")]
    excused: Annotated[bool | None, Field(description="The same.")]
    url: str
    warnings: Annotated[
        list[str], Field(default_factory=list, description="To the staff: what its dates may do unmeant.")
    ]


class ExceptionIn(StrictBody):
    """For a student or for a group; what is not said is inherited."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"group": "TP1", "due_at": "2026-03-25T18:00:00+01:00", "reason": "salle fermée"},
            ]
        }
    )

    student: Annotated[Name, Field(description="`id` of a student of the class; or else `group`.")] = None
    group: Annotated[str | None, Field(max_length=200)] = None
    opens_at: MaybeMoment = None
    due_at: MaybeMoment = None
    closes_at: MaybeMoment = None
    time_factor: Annotated[Number | None, Field(description="From 1 to 4, of a test's duration.")] = None
    excused: bool | None = None
    reason: Annotated[str, Field(max_length=20_000, description="For the staff alone.")] = ""


class ExceptionOut(Strict):
    id: UUID
    student: UUID | None
    group: str | None
    opens_at: datetime | None
    due_at: datetime | None
    closes_at: datetime | None
    time_factor: float | None
    excused: bool | None
    reason: str
    created_at: datetime
    revoked_at: datetime | None
    warnings: Annotated[list[str], Field(default_factory=list, description="As it is made: what dates may do unmeant.")]


class SaidOut(Strict):
    """`origin`: whose word it is; `adjusted`: it follows from another field. The reason is null to a student."""

    origin: Origin
    value: Annotated[Any, Field(description="A date, a number or a boolean; null for none.")]
    group: str | None
    reason: str | None


class RulesOut(Strict):
    """The rules in force for a student; `why` has of each field what was said of it, what holds first."""

    student: UUID
    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    late: Lateness
    time_factor: float
    excused: bool
    duration_seconds: Annotated[float | None, Field(description="Of a test, the factor taken in.")]
    why: dict[RuleField, list[SaidOut]]
