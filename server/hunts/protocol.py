"""Requests of the service to the process that runs hunts (that of cells), and its answers, as JSON."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

OUTSIDE = (
    "Cette entrée sort de ce que l’énoncé promet : des programmes justes n’y répondent pas tous pareil. "
    "Donnez des valeurs que la fonction peut recevoir."
)
#: Hunts that are tried until one can be made.
MAX_OFFERS = 12
GONE = "Cette chasse n’existe plus : prenez-en une autre."


class HuntProtocolModel(BaseModel):
    """Base of all requests and answers between the service and the process of hunts: strict and frozen."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class HuntName(HuntProtocolModel):
    """The program of a misconception, in an exercise ("l20/poses"); an empty `function`: any that has the mistake."""

    exercise: str
    misconception: str
    function: str = ""


class OfferRequest(HuntProtocolModel):
    """A request for the first of these hunts that can be made, in the form that `seed` gives its program."""

    kind: Literal["offer"] = "offer"
    hunts: tuple[HuntName, ...]
    seed: int


class InputTrial(HuntProtocolModel):
    """A request to run both programs on an input; `typed` are the arguments as they were typed, by name."""

    kind: Literal["input"] = "input"
    hunt: HuntName
    typed: dict[str, str]


class PredictionTrial(HuntProtocolModel):
    """A request to compare a typed value with what the wrong program answers to the witness."""

    kind: Literal["prediction"] = "prediction"
    hunt: HuntName
    typed: str


class LineTrial(HuntProtocolModel):
    """A request to say whether a line makes the program wrong, in the form of `seed`; line 0 gives up."""

    kind: Literal["line"] = "line"
    hunt: HuntName
    seed: int
    line: int


class ComparisonRequest(HuntProtocolModel):
    """A request for a call on which the first possible of these mistakes shows, with the answers of other mistakes."""

    kind: Literal["comparison"] = "comparison"
    hunts: tuple[HuntName, ...]


class ReviewRequest(HuntProtocolModel):
    """A request to say what could be written otherwise in a program that passes."""

    kind: Literal["review"] = "review"
    exercise: str
    source: str


class PreparationRequest(HuntProtocolModel):
    """A request to be ready for the others; its answer says nothing."""

    kind: Literal["readiness"] = "readiness"


class HuntQuestion(HuntProtocolModel):
    """A question of the service, recognised by its field `hunts`; `declarations` are those of declared exercises."""

    hunts: Annotated[
        OfferRequest
        | InputTrial
        | PredictionTrial
        | LineTrial
        | ComparisonRequest
        | ReviewRequest
        | PreparationRequest,
        Field(discriminator="kind"),
    ]
    declarations: dict[str, dict[str, Any]] = {}


class HuntArgument(HuntProtocolModel):
    """An argument of the hunted function, what it is in words, and its value in the witness."""

    name: str
    words: str
    witness: str
    optional: bool = False


class OfferedHunt(HuntProtocolModel):
    """A hunt that can be made. `index` is its place among those asked for; `numbers` and `nonzero`, its answer's size,
    0 where that is not told in numbers.

    `wrong_lines` lines of the program make it wrong, 0 where the mistake is not one of lines. `predictable`: what the
    wrong program answers to the witness is short enough to be typed; `returns` says what it is.
    """

    index: int
    hunt: HuntName
    title: str
    program: str
    arguments: tuple[HuntArgument, ...]
    numbers: int
    nonzero: int
    predictable: bool
    wrong_lines: int = 0
    returns: str


class HuntTrialOutcome(HuntProtocolModel):
    """What an input shows, or why it cannot be taken (`refusal`, of the argument `argument`).

    `small`: no longer than the known answer. `expected` and `got` are written for readers, or lines of the program
    with those that mend it; `fault` says how the wrong program stopped.
    """

    is_right: bool = False
    refusal: str = ""
    argument: str = ""
    expected: str = ""
    got: str = ""
    fault: str = ""
    small: bool = False


class ProgramRemark(HuntProtocolModel):
    """Lines of a program to write otherwise, from `line` on; `gain`: how many times faster, 0 if untold."""

    line: int
    sentence: str
    before: str
    after: str
    gain: float = 0.0


class ProgramReview(HuntProtocolModel):
    """Remarks on a program, each tried; `ratio`: how many times the reference's time it takes, 0 if not measured."""

    remarks: tuple[ProgramRemark, ...] = ()
    ratio: float = 0.0


class ComparedAnswer(HuntProtocolModel):
    """An answer to a call, in words, and the misconception that leads to it."""

    misconception: str
    words: str


class AnswerComparison(HuntProtocolModel):
    """A call, its right answer in words, and different ones of known mistakes, that of the hunt first. `index` is the
    place of the hunt among those asked for."""

    index: int
    hunt: HuntName
    call: str
    right: str
    wrong: tuple[ComparedAnswer, ...]


class HuntReply(HuntProtocolModel):
    """The answer of the process: no hunt at all, an offer, the outcome of a trial, a comparison, or a review."""

    offer: OfferedHunt | None = None
    outcome: HuntTrialOutcome | None = None
    comparison: AnswerComparison | None = None
    review: ProgramReview | None = None
