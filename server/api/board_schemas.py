"""The shapes of a class's board (contract, section 6)."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict
from server.board.schemas import ProgressState

Count = Annotated[int, Field(ge=0)]


class CountsOut(Strict):
    """How many students there are, have an attempt, solved all that counts, are stuck now."""

    students: Count
    started: Count
    finished: Count
    stuck: Count


class MisconceptionOut(Strict):
    """`now`: students whose latest attempt at the exercise has it (`students`); `overcome`: had it, have it no more."""

    exercise: str
    id: str
    title: str
    now: Count
    ever: Count
    overcome: Count
    median_attempts: Annotated[float | None, Field(description="From the first with it to the first without.")]
    students: list[UUID]


class CellOut(Strict):
    student: UUID
    exercise: str
    points: Annotated[float | None, Field(ge=0, le=20, description="In force.")]
    attempts: Count
    state: ProgressState
    misconception: Annotated[str | None, Field(description="The latest attempt's.")]


class UnnamedOut(Strict):
    """Failures that no misconception names; without a group, one that stands alone."""

    exercise: str
    group: str | None
    students: list[UUID]
    submission: UUID


class ItemOut(Strict):
    exercise: str
    success: Annotated[float | None, Field(ge=0, le=1, description="Share of `n`; null under 10 students.")]
    median_attempts: Annotated[float | None, Field(description="Until the first success.")]
    discrimination: Annotated[float | None, Field(ge=-1, le=1, description="Null under 20 students.")]
    n: Annotated[int, Field(ge=0, description="Students who tried.")]


class DashboardOut(Strict):
    model_config = ConfigDict(populate_by_name=True)

    class_id: Annotated[UUID, Field(alias="class")]
    generated_at: datetime
    counts: CountsOut
    misconceptions: list[MisconceptionOut]
    cells: list[CellOut]
    unnamed: list[UnnamedOut]
    items: list[ItemOut]
