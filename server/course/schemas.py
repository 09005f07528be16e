"""The shape of `module.toml` and `exercise.toml`: strict, nothing unknown goes unnoticed."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from server.sandbox.policy import Policy

Text = Annotated[str, Field(min_length=1)]


def _plain(text: str) -> str:
    if "$" in text or "`" in text:
        raise PydanticCustomError("plain_text", "neither formula nor code here")
    return text


#: Shown as it stands, outside of any Markdown.
PlainText = Annotated[Text, AfterValidator(_plain)]


class Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class ModuleFile(Strict):
    """`curriculum/<module>/module.toml`."""

    title: Text
    number: Text
    summary: Text
    track: str = ""
    sessions: Annotated[int, Field(ge=0)] = 0
    prerequisites: list[Text] = []
    objectives: list[Text] = []
    references: list[Text] = []
    previous: str = ""
    next: str = ""
    order: int = 0


class FunctionEntry(Strict):
    """One function to write. `signature` may carry a default or a keyword such as `class`."""

    name: Annotated[str, Field(pattern=r"^[^\W\d]\w*$")]
    signature: Text
    returns: str = ""
    doc: str = ""


class PolicyEntry(Strict):
    """What an exercise overrides of `server.sandbox.Policy`, field by field."""

    cpu_seconds: Annotated[float, Field(gt=0, le=120)] | None = None
    wall_seconds: Annotated[float, Field(gt=0, le=300)] | None = None
    memory_bytes: Annotated[int, Field(ge=64 << 20, le=4 << 30)] | None = None
    stdout_bytes: Annotated[int, Field(ge=1024, le=1 << 20)] | None = None
    source_bytes: Annotated[int, Field(ge=1024, le=1 << 20)] | None = None
    frame_bytes: Annotated[int, Field(ge=1024, le=64 << 20)] | None = None
    items: Annotated[int, Field(ge=1000, le=10_000_000)] | None = None
    depth: Annotated[int, Field(ge=4, le=60)] | None = None
    threads: Annotated[int, Field(ge=1, le=16)] | None = None
    files: Annotated[int, Field(ge=16, le=1024)] | None = None
    file_bytes: Annotated[int, Field(ge=1024, le=64 << 20)] | None = None
    folder_bytes: Annotated[int, Field(ge=64 << 10, le=256 << 20)] | None = None

    def policy(self) -> Policy:
        """The general policy, and what is overridden here."""
        return replace(Policy(), **self.model_dump(exclude_none=True))

    def overrides(self) -> dict[str, Any]:
        return self.model_dump(exclude_none=True)


class ExerciseFile(Strict):
    """`curriculum/<module>/exercices/<slug>/exercise.toml`."""

    title: Text
    summary: Text
    order: int
    stars: Annotated[int, Field(ge=0, le=3)] = 0
    origin: str = ""
    kind: Literal["code", "answers"] = "code"
    seance: str = ""
    functions: list[FunctionEntry] = []
    limits: PolicyEntry = PolicyEntry()


class FrontMatter(Strict):
    """Between the `+++` lines of a lesson."""

    title: PlainText
    label: PlainText
    summary: PlainText
    order: int
    minutes: Annotated[int, Field(ge=0)] = 0
    objectives: list[PlainText] = []


class TermEntry(Strict):
    """One `[[terme]]` of `glossaire.toml`. `definition` is Markdown of one paragraph."""

    id: Text
    mot: PlainText
    definition: Text
    page: Text


class Glossary(Strict):
    """The whole file; each entry is then read by itself, so that one that is wrong leaves the others."""

    terme: list[dict[str, object]]
