"""The shapes of the HTTP interface for what is said of submissions."""

from datetime import datetime
from typing import Annotated, Literal
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict, StrictBody
from server.comments.line_tracking import LineFate
from server.comments.models import CHECK_LENGTH, TEXT_LENGTH, ThreadState

Line = Annotated[int, Field(ge=1, le=10**6)]


class NewComment(StrictBody):
    """Begins a thread on `lines`, on a `check`, on the whole submission; or, with `thread`, adds to one."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"text": "Je ne comprends pas cette vérification.", "check": "inverse"},
                {"text": "Et si `x` est un tableau ?", "lines": [4, 5]},
            ]
        }
    )

    text: Annotated[str, Field(max_length=4 * TEXT_LENGTH, description="At most 4000 characters.")]
    lines: Annotated[list[Line] | None, Field(min_length=2, max_length=2, description="First and last, from 1.")] = None
    check: Annotated[str | None, Field(max_length=CHECK_LENGTH, description="A check of the verdict, by its id.")] = (
        None
    )
    thread: Annotated[UUID | None, Field(strict=False, description="A thread that is answered, by its id.")] = None


class ThreadChange(StrictBody):
    model_config = ConfigDict(json_schema_extra={"examples": [{"state": "settled"}]})

    state: Annotated[Literal["open", "settled"], Field(description="There is more to say, or no more.")]


class MessageOut(Strict):
    """`author` is empty where that account is gone; `staff`: of who reads the work, not of who did it."""

    id: UUID
    author: str
    staff: bool
    mine: bool
    text: str
    created_at: datetime


class ThreadOut(Strict):
    """What is said of one thing. `lines` are where they stand in the submission that was asked for."""

    id: UUID
    submission: Annotated[UUID | None, Field(description="The one that it was written on; null: the exercise.")]
    lines: list[int] | None
    fate: Annotated[LineFate, Field(description="What became of its lines since that submission.")]
    check: str | None
    state: ThreadState
    created_at: datetime
    messages: list[MessageOut]
