"""The shapes of the HTTP interface for classes (contract, section 6)."""

from datetime import datetime
from typing import Annotated
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict
from server.classes.models import ClassRole, Status


class NewClass(Strict):
    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "MPSI 2", "module": "l20"}]})

    name: Annotated[str, Field(max_length=400, description="1 to 100 characters.", examples=["MPSI 2"])]
    module: Annotated[str, Field(max_length=100, description="Slug of a module.", examples=["l20"])]


class JoinCode(Strict):
    model_config = ConfigDict(json_schema_extra={"examples": [{"code": "BCDF-GHJK"}]})

    code: Annotated[str, Field(max_length=100, description="In any case, with or without dashes and spaces.")]


class NewName(Strict):
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


class RosterOut(Strict):
    """How many people a list adds, changes, leaves as they are, takes out of the class; which lines it does not."""

    added: Annotated[int, Field(ge=0)]
    updated: Annotated[int, Field(ge=0)]
    unchanged: Annotated[int, Field(ge=0)]
    left: Annotated[int, Field(ge=0, description="Students whom the list does not name. Their work is kept.")]
    rejected: list[RejectedOut]


class StudentOut(Strict):
    id: UUID
    name: str
    groups: list[str]
    joined_at: datetime
    last_seen_at: datetime | None
