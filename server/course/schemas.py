"""The shape of `module.toml` and `exercise.toml`: strict, nothing unknown goes unnoticed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from server.sandbox.policy import LIMIT_SPECS, LimitSpec, Policy

Text = Annotated[str, Field(min_length=1)]


def _plain(text: str) -> str:
    if "$" in text or "`" in text:
        raise PydanticCustomError("plain_text", "neither formula nor code here")
    return text


#: Shown as it stands, outside of any Markdown.
PlainText = Annotated[Text, AfterValidator(_plain)]


class Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class PathEntry(Strict):
    """A way through a module for some of its readers: `page` is the slug of the lesson that says it, with its label.

    `exercises` are the slugs of its exercises, in its order; by `name`, lessons say what it leaves for later.
    """

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")] = ""
    title: PlainText
    summary: PlainText
    page: Text
    exercises: list[Text] = []


class ModuleFile(Strict):
    """`curriculum/<module>/module.toml`. `references` are Markdown of one line."""

    title: Text
    number: Text
    summary: Text
    track: str = ""
    sessions: Annotated[int, Field(ge=0)] = 0
    prerequisites: list[Text] = []
    objectives: list[Text] = []
    references: list[Text] = []
    paths: list[PathEntry] = []
    previous: str = ""
    next: str = ""
    order: int | None = None


class FunctionEntry(Strict):
    """One function to write. `signature` may carry a default or a keyword such as `class`.

    `example` is a call of it, in plain values, that a student may begin from.
    """

    name: Annotated[str, Field(pattern=r"^[^\W\d]\w*$")]
    signature: Text
    returns: str = ""
    doc: str = ""
    parts: list[Text] = []
    example: str = ""


class Overrides(Strict):
    """Of `server.sandbox.Policy`, field by field, each within the bounds of its row."""

    def policy(self) -> Policy:
        """The general policy, and what is overridden here."""
        return replace(Policy(), **self.overrides())

    def overrides(self) -> dict[str, Any]:
        return self.model_dump(exclude_none=True)


def _overridable(name: str, row: LimitSpec) -> Any:
    bounded: Any = Annotated[type(getattr(Policy(), name)), Field(ge=row.minimum, le=row.maximum)]
    return (bounded | None, None)


if TYPE_CHECKING:
    PolicyEntry = Overrides
else:
    PolicyEntry = create_model(
        "PolicyEntry", __base__=Overrides, **{name: _overridable(name, row) for name, row in LIMIT_SPECS.items()}
    )


#: Who sees the bug hunts of an exercise: nobody, whoever has solved it, anybody.
HuntRule = Literal["never", "solved", "always"]


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
    reuses: list[Text] = []
    limits: PolicyEntry = PolicyEntry()
    hunts: HuntRule = "solved"


class ObjectiveEntry(Strict):
    """One `[[objective]]` of a lesson: an infinitive, its exercises (`slug` or `slug:function`) and mistakes."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$")]
    text: PlainText
    short: PlainText
    exercises: list[Annotated[str, Field(pattern=r"^[a-z0-9_]+(:\w+)?$")]] = []
    mistakes: list[Annotated[str, Field(pattern=r"^[a-z0-9_]+/\w+$")]] = []


class FrontMatter(Strict):
    """Between the `+++` lines of a lesson. `solution`: what it tells is held back from a class until it is opened.

    Its objectives are plain texts, or tables with the exercises that practise them.
    """

    title: PlainText
    label: PlainText
    summary: PlainText
    order: int
    minutes: Annotated[int, Field(ge=0)] = 0
    objectives: list[PlainText] = []
    objective: list[ObjectiveEntry] = []
    solution: bool = False


class FamilyEntry(Strict):
    """One `[[family]]` of misconceptions; `slips` are usual slips, which any exercise may meet."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9]+(_[a-z0-9]+)*$")]
    title: PlainText
    summary: PlainText
    slips: list[Text] = []


class FamiliesFile(Strict):
    """`curriculum/families.toml`."""

    family: list[FamilyEntry]


class ExerciseFamiliesFile(Strict):
    """`families.toml` of an exercise: its misconceptions by family, or by the reason of having none."""

    families: dict[str, list[Text]] = {}
    apart: dict[str, list[Text]] = {}


class TermEntry(Strict):
    """One `[[terme]]` of `glossaire.toml`. `definition` is Markdown of one paragraph."""

    id: Text
    mot: PlainText
    definition: Text
    page: Text


class Glossary(Strict):
    """The whole file; each entry is then read by itself, so that one that is wrong leaves the others."""

    terme: list[dict[str, object]]
