"""The shapes of the HTTP interface for classes (contract, section 6)."""

from datetime import datetime
from typing import Annotated
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict, StrictBody
from server.classes.models import ClassRole, Status


class NewClass(StrictBody):
    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "MPSI 2", "module": "l20"}]})

    name: Annotated[str, Field(max_length=400, description="1 to 100 characters.", examples=["MPSI 2"])]
    module: Annotated[str, Field(max_length=100, description="Slug of a module.", examples=["l20"])]


class JoinCode(StrictBody):
    model_config = ConfigDict(json_schema_extra={"examples": [{"code": "BCDF-GHJK"}]})

    code: Annotated[str, Field(max_length=100, description="In any case, with or without dashes and spaces.")]


class NewName(StrictBody):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "title": "L’angle est compté deux fois",
                    "explanation": "Vous ajoutez le cap à un angle qui le contient déjà.",
                    "question": "Dans quel repère b est-elle donnée ?",
                }
            ]
        }
    )

    title: Annotated[str, Field(max_length=4000, description="1 to 200 characters.")]
    explanation: Annotated[str, Field(max_length=40_000, description="Plain text, 1 to 4000 characters.")]
    question: Annotated[str, Field(max_length=10_000, description="Plain text, at most 1000 characters.")] = ""


class NameOut(Strict):
    """The name of a group of programs that answer alike; `students` of the class have sent one at least."""

    exercise: Annotated[str, Field(examples=["l20/poses"])]
    group: str
    title: str
    explanation: str
    question: str
    students: Annotated[int, Field(ge=1)]


class ClassOut(Strict):
    id: UUID
    name: str
    module: str
    join_code: Annotated[str | None, Field(description="While it is good, for who may see it.")]
    url: Annotated[str, Field(examples=["/api/v1/classes/7d0c1a54-6b0e-4c69-9d3b-9a3f3a3c7a10"])]


class ClassSeen(ClassOut):
    """A class, with what one is in it. An administrator may be nothing in a class that they see."""

    role: ClassRole | None
    status: Status | None
    archived_at: datetime | None


class RejectedOut(Strict):
    line: Annotated[int, Field(ge=1, description="In the file, from 1.")]
    reason: str


class ColumnOut(Strict):
    """How a column of the list is read; `read_as` is null for one that is left aside."""

    column: Annotated[str, Field(description="Its header; empty for a column without one.")]
    read_as: Annotated[str | None, Field(examples=["prenom"])]


class LeavingOut(Strict):
    """A student who leaves; who joined by the code is in no list of a school."""

    id: UUID
    name: str
    joined_by_code: bool


class OtherClassOut(Strict):
    """The changes of another of one's classes, whose name the list's column of classes has."""

    id: UUID
    name: str
    added: Annotated[int, Field(ge=0)]
    updated: Annotated[int, Field(ge=0)]
    unchanged: Annotated[int, Field(ge=0)]
    rejected: list[RejectedOut]


class RosterOut(Strict):
    """How many people a list adds, changes, leaves as they are, takes out of the class; which lines it does not."""

    added: Annotated[int, Field(ge=0)]
    updated: Annotated[int, Field(ge=0)]
    unchanged: Annotated[int, Field(ge=0)]
    left: Annotated[
        int, Field(ge=0, description="Students whom a list of mode `replace` does not name. Their work is kept.")
    ]
    rejected: list[RejectedOut]
    ignored_columns: Annotated[list[str], Field(description="Headers of the columns of which nothing is kept.")]
    columns: Annotated[list[ColumnOut], Field(description="Every column, in order.")]
    warnings: Annotated[list[str], Field(description="In French: what one should check.")]
    leaving: Annotated[list[LeavingOut], Field(description="Who leaves, by name, with mode `replace`.")]
    not_in_list: Annotated[int, Field(ge=0, description="Students whom the list does not name, and who stay.")]
    classes: Annotated[list[OtherClassOut], Field(description="Others of one's classes that the list fills.")]
    encoding: Annotated[str, Field(description="Of a text, judged by what comes out; empty for a spreadsheet.")]


class StudentOut(Strict):
    id: UUID
    name: str
    groups: list[str]
    joined_at: datetime
    last_seen_at: datetime | None
