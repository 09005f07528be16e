"""The shapes of the HTTP interface (contract, sections 3 and 5)."""

from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self
from uuid import UUID

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from graders.core.contract.outcomes import Outcome
from server.base.validation import MAX_NAMES, RequestBody
from server.sandbox.policy import LIMIT_SPECS, Policy

Json = Any
Status = Literal["queued", "running", "done"]


class Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")


class StrictBody(RequestBody, BaseModel):
    model_config = ConfigDict(strict=True)


def _to_init_error(error: ErrorDetails) -> InitErrorDetails:
    return {"type": error["type"], "loc": error["loc"], "input": error["input"], "ctx": error.get("ctx", {})}


class NewSubmission(StrictBody):
    """A file to grade, or the answers to questions: which of the two, the exercise's `kind` says."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"exercise": "l20/poses", "code": "def composer(a, b):\n    return a + b\n"},
                {"exercise": "l20/calcul_odometrie", "answers": {"ds": 0.115, "dtheta": "0,03/0,3"}},
            ],
            "oneOf": [{"required": ["code"]}, {"required": ["answers"]}],
        }
    )

    @model_validator(mode="wrap")
    @classmethod
    def _with_what_is_missing(cls, data: object, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """A name that is refused is often that of what is missing, written otherwise: both are told at once."""
        try:
            return handler(data)
        except ValidationError as error:
            if not isinstance(data, Mapping) or len(data) > MAX_NAMES or {"code", "answers"} & data.keys():
                raise
            missing: InitErrorDetails = {"type": PydanticCustomError("nothing_sent", "missing"), "input": data}
            raise ValidationError.from_exception_data(
                error.title, [*map(_to_init_error, error.errors()), missing]
            ) from error

    exercise: Annotated[str, Field(description="Exercise, as `module/slug`.")]
    code: Annotated[str, Field(description="The whole file, at most 64 KiB in UTF-8.")] = ""
    answers: Annotated[
        dict[str, Json],
        Field(description="By question: a number or its text, a letter, a list of letters; at most 64 KiB as JSON."),
    ] = {}


class CounterexampleOut(Strict):
    inputs: dict[str, Json]
    expected: Json
    got: Json


class CheckOut(Strict):
    id: str
    title: str
    passed: bool
    points: float
    max_points: float
    message: str
    counterexample: CounterexampleOut | None
    hint: str | None
    figure: Annotated[str | None, Field(description="Name of a figure of this submission.")]
    cause: Annotated[
        Outcome | None, Field(description="How a failed check ended; left out where that is a wrong answer.")
    ] = None
    repeats: Annotated[
        str | None, Field(description="The earlier check that failed for the same reason; left out otherwise.")
    ] = None
    neutral: Annotated[
        bool, Field(description="A check without a fault, whose points wait for another one; left out otherwise.")
    ] = False
    kit: Annotated[
        dict[str, Json] | None,
        Field(description="Map, range and seed of a check that ran on another map; left out otherwise."),
    ] = None
    case: Annotated[
        str | None, Field(description="The case that shows the failure, as Python writes it; left out otherwise.")
    ] = None


class DiagnosisOut(Strict):
    id: str
    title: str
    explanation: str
    source: Annotated[
        Literal["teacher"] | None,
        Field(description="`teacher` for what a teacher says of programs that answer alike; left out otherwise."),
    ] = None
    explains: Annotated[
        list[list[str]],
        Field(description="For each title, the failed checks that it explains; left out where that is not known."),
    ] = []
    certain: Annotated[
        bool,
        Field(description="The program answers as one with these mistakes and no other does; left out otherwise."),
    ] = False


class VerdictOut(Strict):
    """What grading found."""  # a test holds it to `graders.core.contract.verdict.Verdict`

    exercise: str
    exercise_version: str
    outcome: Outcome
    score: Annotated[float, Field(ge=0, le=1)]
    points: Annotated[float, Field(description="20 × score.")]
    max_points: float
    checks: list[CheckOut]
    diagnosis: DiagnosisOut | None
    stdout: str
    seed: int
    timings: dict[str, float]
    remarks: Annotated[
        list[str], Field(default=[], description="What was let through in the file; absent where there is nothing.")
    ]
    load_error: Annotated[
        str, Field(default="", description="Why the file does not run, or what it lacks; absent where it does.")
    ]


class SubmissionOut(Strict):
    """A submission as it stands."""

    id: UUID
    status: Status
    position: Annotated[
        int | None,
        Field(
            description="Place in the queue: 1 is next; null once grading has begun. Turns go round those who send, "
            "so that it may go up."
        ),
    ]
    notice: Annotated[str | None, Field(description="Why there is no verdict yet, where it takes long, in French.")]
    held: Annotated[
        bool,
        Field(
            description="A test holds the verdict back until its teacher releases the results: `status` stays "
            "`running` until then, whatever was found, and nothing is to be gained by waiting."
        ),
    ]
    load_error: Annotated[
        str | None,
        Field(
            description="Of an attempt whose verdict a test holds back: why its file does not run, or what it lacks, "
            "in French; null where it runs, whatever was found, and as long as that is not known."
        ),
    ] = None
    verdict: VerdictOut | None
    url: Annotated[str, Field(examples=["/api/v1/submissions/7d0c1a54-6b0e-4c69-9d3b-9a3f3a3c7a10"])]
    exercise: str
    created_at: datetime


class PromiseOut(Strict):
    """A line of what is promised of a function: « Convient », « liste, tuple ou tableau »."""

    label: str
    text: str


class FunctionOut(Strict):
    name: str
    signature: str
    returns: str
    doc: str
    promises: Annotated[
        list[PromiseOut], Field(description="What it is given, and the forms in which it may answer, in French.")
    ]


Kind = Literal["code", "answers"]


class ExerciseOut(Strict):
    """An exercise in the list."""

    id: Annotated[str, Field(examples=["l20/poses"])]
    module: str
    slug: str
    title: str
    summary: str
    stars: int
    course: str
    version: str
    kind: Annotated[Kind, Field(description="What is sent: `code`, or `answers` to questions.")]
    functions: list[FunctionOut]
    url: str


class LimitsRead(Strict):
    """Limits of one execution: a field for each of `server.sandbox.Policy`."""


if TYPE_CHECKING:
    LimitsOut = LimitsRead
else:
    LimitsOut = create_model(
        "LimitsOut",
        __base__=LimitsRead,
        **{name: (type(value), Field(description=LIMIT_SPECS[name].label)) for name, value in asdict(Policy()).items()},
    )


class GivenOut(Strict):
    """A number dealt to this account, as it is to be used."""

    symbol: Annotated[str, Field(description="In TeX.")]
    name: str
    value: Annotated[str, Field(description="With a decimal comma.")]
    unit: str


class PieceOut(Strict):
    """An option or a step, under a letter that is this account's."""

    id: str
    text_html: str


class QuestionOut(Strict):
    id: str
    title: str
    text_html: str
    form: Annotated[
        Literal["number", "one", "several", "order"],
        Field(description="A number; one letter; a list of letters; a list of letters in order, some left aside."),
    ]
    points: float
    unit: str
    pieces: list[PieceOut]


class ExerciseDetail(ExerciseOut):
    statement_html: str
    starter: str
    limits: LimitsOut
    given: Annotated[list[GivenOut], Field(description="This account's data; empty for an exercise of code.")]
    questions: Annotated[list[QuestionOut], Field(description="This account's questions; empty for code.")]


class ProblemPlace(Strict):
    """Where the data is refused: a JSON pointer in the body, or a parameter's name."""

    detail: str
    pointer: str | None = None
    parameter: str | None = None


class ProblemOut(BaseModel):
    """RFC 9457 problem document."""

    type: str
    title: str
    status: int
    detail: str
    instance: str
    errors: list[ProblemPlace] | None = None
