"""The shape of `module.toml` and `exercise.toml`: strict, nothing unknown goes unnoticed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model
from pydantic_core import PydanticCustomError

from server.sandbox.policy import LIMIT_SPECS, LimitSpec, Policy

Text = Annotated[str, Field(min_length=1)]


def _require_plain_text(text: str) -> str:
    if "$" in text or "`" in text:
        raise PydanticCustomError("plain_text", "neither formula nor code here")
    return text


#: Shown as it stands, outside of any Markdown.
PlainText = Annotated[Text, AfterValidator(_require_plain_text)]


class StrictModel(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class PathEntry(StrictModel):
    """A way through a module for some of its readers: `page` is the slug of the lesson that says it, with its label.

    `exercises` are the slugs of its exercises, in its order; by `name`, lessons say what it leaves for later.
    """

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")] = ""
    title: PlainText
    summary: PlainText
    page: Text
    exercises: list[Text] = []


class ModuleFile(StrictModel):
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


class FunctionEntry(StrictModel):
    """One function to write. `signature` may carry a default or a keyword such as `class`.

    `example` is a call of it, in plain values, that a student may begin from.
    """

    name: Annotated[str, Field(pattern=r"^[^\W\d]\w*$")]
    signature: Text
    returns: str = ""
    doc: str = ""
    parts: list[Text] = []
    example: str = ""


class LimitOverrides(StrictModel):
    """Of `server.sandbox.Policy`, field by field, each within the bounds of its row."""

    def build_policy(self) -> Policy:
        """The general policy, and what is overridden here."""
        return replace(Policy(), **self.overridden_fields())

    def overridden_fields(self) -> dict[str, Any]:
        return self.model_dump(exclude_none=True)


def _overridable_field(name: str, row: LimitSpec) -> Any:
    bounded: Any = Annotated[type(getattr(Policy(), name)), Field(ge=row.minimum, le=row.maximum)]
    return (bounded | None, None)


if TYPE_CHECKING:
    PolicyEntry = LimitOverrides
else:
    PolicyEntry = create_model(
        "PolicyEntry",
        __base__=LimitOverrides,
        **{name: _overridable_field(name, row) for name, row in LIMIT_SPECS.items()},
    )


#: Who sees the bug hunts of an exercise: nobody, whoever has solved it, anybody.
HuntRule = Literal["never", "solved", "always"]


class ExerciseFile(StrictModel):
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


class ObjectiveEntry(StrictModel):
    """One `[[objective]]` of a lesson: an infinitive, its exercises (`slug` or `slug:function`) and mistakes."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9]+(-[a-z0-9]+)*$")]
    text: PlainText
    short: PlainText
    exercises: list[Annotated[str, Field(pattern=r"^[a-z0-9_]+(:\w+)?$")]] = []
    mistakes: list[Annotated[str, Field(pattern=r"^[a-z0-9_]+/\w+$")]] = []


class FrontMatter(StrictModel):
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


class FamilyEntry(StrictModel):
    """One `[[family]]` of misconceptions; `slips` are usual slips, which any exercise may meet."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9]+(_[a-z0-9]+)*$")]
    title: PlainText
    summary: PlainText
    slips: list[Text] = []


class FamiliesFile(StrictModel):
    """`curriculum/families.toml`."""

    family: list[FamilyEntry]


class ExerciseFamiliesFile(StrictModel):
    """`families.toml` of an exercise: its misconceptions by family, or by the reason of having none."""

    families: dict[str, list[Text]] = {}
    apart: dict[str, list[Text]] = {}


class TermEntry(StrictModel):
    """One `[[terme]]` of `glossaire.toml`. `definition` is Markdown of one paragraph."""

    id: Text
    mot: PlainText
    definition: Text
    page: Text


class GlossaryFile(StrictModel):
    """The whole file; each entry is then read by itself, so that one that is wrong leaves the others."""

    terme: list[dict[str, object]]
