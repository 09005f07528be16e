"""The shapes of the HTTP interface for regrades (contract, section 6)."""

from typing import Annotated, Literal
from uuid import UUID

from pydantic import ConfigDict, Field

from server.api.schemas import Strict, StrictBody
from server.regrades.models import RegradePolicy
from server.regrades.schemas import MarkOutcome, RegradeState


class NewRegrade(StrictBody):
    """What to grade anew: of the whole class, unless an assignment or a student is named."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"exercise": "l20/poses", "policy": "keep_best"}]})

    exercise: Annotated[str, Field(max_length=200, description="Exercise, as `module/slug`.")]
    policy: Annotated[
        Literal["keep_best", "replace"], Field(description="Which of the two gradings counts, once it is applied.")
    ] = RegradePolicy.keep_best.value
    assignment: Annotated[UUID | None, Field(strict=False, description="Only attempts that may count in it.")] = None
    student: Annotated[UUID | None, Field(strict=False, description="Only this student's attempts.")] = None


class RegradeBegun(Strict):
    id: UUID


class ProgressOut(Strict):
    done: Annotated[int, Field(ge=0, description="Attempts graded anew.")]
    total: Annotated[int, Field(ge=0)]


class ChangeOut(Strict):
    """A student whose mark changes; points out of 20, null where nothing counts."""

    student: UUID
    before: float | None
    after: float | None
    why: Annotated[str, Field(description="What differs between the two verdicts, in French.")]


class RegradeOut(Strict):
    """A regrade; `changes` has those whose mark changes once it is applied, whether it is or not."""

    id: UUID
    exercise: str
    policy: RegradePolicy
    assignment: UUID | None
    student: UUID | None
    state: RegradeState
    progress: ProgressOut
    students: Annotated[dict[MarkOutcome, int], Field(description="How many gain, lose, keep the better mark, stay.")]
    failed: Annotated[int, Field(ge=0, description="Attempts whose new grading ended by an error of ours.")]
    changes: list[ChangeOut]
