"""The shapes of the HTTP interface for columns of a teacher's own."""

from __future__ import annotations

from datetime import date, datetime
from typing import Annotated, Literal
from uuid import UUID

from pydantic import BeforeValidator, ConfigDict, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from server.api.assignment_schemas import Name, Number
from server.api.schemas import Strict, StrictBody
from server.marks.models import COLUMN_TITLE_LENGTH, COMMENT_LENGTH
from server.marks.states import TypedState

DATE_LENGTH = 10
MAX_MARKS = 2000


def _parse_day(value: object) -> object:
    if value is None or isinstance(value, date):
        return value
    try:
        if not isinstance(value, str) or len(value) != DATE_LENGTH:
            raise ValueError(value)
        return date.fromisoformat(value)
    except ValueError as error:
        raise PydanticCustomError("no_day", "not a day") from error


DAY = {"type": "string", "format": "date", "description": "ISO 8601: `2026-03-16`."}
MaybeDay = Annotated[date | None, BeforeValidator(_parse_day), WithJsonSchema({"anyOf": [DAY, {"type": "null"}]})]
Title = Annotated[str, Field(min_length=1, max_length=COLUMN_TITLE_LENGTH)]
Scale = Annotated[Number, Field(gt=0, le=1000, description="The best mark there is; two decimals at most.")]
Weight = Annotated[Number, Field(ge=0, le=1000, description="0: it does not count. A bonus does not use it.")]


class ColumnIn(StrictBody):
    model_config = ConfigDict(
        json_schema_extra={"examples": [{"title": "Oral", "out_of": 10, "taken_on": "2026-03-16", "weight": 2}]}
    )

    title: Title
    out_of: Scale = 20.0
    taken_on: MaybeDay = None
    weight: Weight = 1.0
    bonus: Annotated[bool, Field(description="The points are added to the mean as they are.")] = False
    published: Annotated[bool, Field(description="Whether students see it.")] = False


class ColumnChange(StrictBody):
    """What is left out stays as it is."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"published": True}]})

    title: Title | None = None
    out_of: Scale | None = None
    taken_on: MaybeDay = None
    weight: Weight | None = None
    bonus: bool | None = None
    published: bool | None = None
    place: Annotated[int | None, Field(ge=0, le=1000, description="Among the others, from 0.")] = None
    version: Annotated[
        int | None, Field(ge=0, le=10**9, description="That of the column you have read: 409 if it has changed.")
    ] = None


class ColumnOut(Strict):
    """Students see the column from `published_at` on; one with `deleted_at` can be restored."""

    id: UUID
    title: str
    out_of: float
    taken_on: date | None
    weight: float
    bonus: bool
    published_at: datetime | None
    deleted_at: datetime | None
    version: int


class TypedMarkOut(Strict):
    """`points` out of the column's `out_of`, or a state, or neither; `version` is 0 where nothing was ever typed."""

    student: UUID
    name: str
    points: float | None
    state: TypedState | None
    comment: str
    version: int


class ColumnWithMarks(ColumnOut):
    marks: Annotated[list[TypedMarkOut], Field(description="In the order of the list of names.")]


class TypedMarkIn(StrictBody):
    """Points or a state; without either, the mark is cleared. Without `comment` it stays as it is."""

    student: Annotated[Name, Field(description="`id` of a student of the class.")]
    points: Annotated[Number | None, Field(ge=0, le=1000, description="Two decimals at most.")] = None
    state: Literal["absent", "excused", "not_handed_in"] | None = None
    comment: Annotated[str | None, Field(max_length=COMMENT_LENGTH)] = None
    version: Annotated[
        int | None, Field(ge=0, le=10**9, description="That of the mark you have read: 409 if it has changed.")
    ] = None


class TypedMarksIn(StrictBody):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"marks": [{"student": "0b9f8d2e-5b0e-4d53-9d3e-3f3f0a7c1a11", "points": 7.5}]}]
        }
    )

    marks: Annotated[list[TypedMarkIn], Field(max_length=MAX_MARKS)]
