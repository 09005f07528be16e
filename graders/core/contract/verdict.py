"""The verdict (contract, section 3): one type, and one JSON object, for command line, API, pages and database."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graders.core.contract.json_object import MalformedVerdictError, ObjectReader
from graders.core.contract.outcomes import Outcome

__all__ = [
    "MAX_POINTS",
    "CheckResult",
    "Counterexample",
    "Diagnosis",
    "MalformedVerdictError",
    "Verdict",
    "internal_error_verdict",
]

MAX_POINTS = 20.0
DUST = 1e-9  # what sums of points leave


@dataclass(frozen=True)
class Counterexample:
    """One input on which the submission fails; every field is strict JSON."""

    inputs: dict[str, Any]
    expected: Any
    got: Any

    @property
    def has_expected(self) -> bool:
        """Whether what is expected is known: not where the program gave no value and nothing was compared."""
        return not (self.expected is None and isinstance(self.got, str))

    def to_json(self) -> dict[str, Any]:
        return {"inputs": self.inputs, "expected": self.expected, "got": self.got}

    @classmethod
    def from_json(cls, value: Any, place: str = "") -> Counterexample:
        with ObjectReader(value, place) as members:
            return cls(members.read_object("inputs"), members.read_any("expected"), members.read_any("got"))


@dataclass(frozen=True)
class CheckResult:
    """One check's line of the verdict. `figure` names a drawing that can be asked for.

    `message` says why it failed, or what it measured of a program that is right.

    `cause` is the outcome of a failed check, where it is no wrong answer; `repeats`, the id of an earlier check that
    failed for the same reason, which is told there; `neutral` is a check without a fault, whose points wait for
    another one; `kit`, the map, range and seed of a check that ran on another map than the others; `case`, the case of
    a declared exercise that shows the failure, as Python writes it. JSON has these only where there is something to
    say.

    Raises ValueError unless it has all of its points when it passed, and less when it did not.
    """

    id: str
    title: str
    passed: bool
    points: float
    max_points: float
    message: str = ""
    counterexample: Counterexample | None = None
    hint: str | None = None
    figure: str | None = None
    cause: Outcome | None = None
    repeats: str | None = None
    neutral: bool = False
    kit: dict[str, Any] | None = None
    case: str | None = None

    def __post_init__(self) -> None:
        if self.passed != (self.points == self.max_points) or not 0 <= self.points <= self.max_points:
            state = "passed" if self.passed else "failed"
            raise ValueError(f"check {self.id} {state} with {self.points} points of {self.max_points}")

    def to_json(self) -> dict[str, Any]:
        return {
            "id": self.id,
            "title": self.title,
            "passed": self.passed,
            "points": self.points,
            "max_points": self.max_points,
            "message": self.message,
            "counterexample": self.counterexample.to_json() if self.counterexample else None,
            "hint": self.hint,
            "figure": self.figure,
            **({"cause": self.cause.value} if self.cause else {}),
            **({"repeats": self.repeats} if self.repeats else {}),
            **({"neutral": True} if self.neutral else {}),
            **({"kit": self.kit} if self.kit else {}),
            **({"case": self.case} if self.case else {}),
        }

    @classmethod
    def from_json(cls, value: Any, place: str = "") -> CheckResult:
        with ObjectReader(value, place) as members:
            read: dict[str, Any] = {
                "id": members.read_text("id"),
                "title": members.read_text("title"),
                "passed": members.read_flag("passed"),
                "points": members.read_number("points"),
                "max_points": members.read_number("max_points"),
                "message": members.read_text("message"),
                "counterexample": members.read_optional("counterexample", Counterexample.from_json),
                "hint": members.read_optional_text("hint"),
                "figure": members.read_optional_text("figure"),
                "cause": _read_outcome(members, "cause") if members.has_member("cause") else None,
                "repeats": members.read_text("repeats") if members.has_member("repeats") else None,
                "neutral": members.read_flag("neutral") if members.has_member("neutral") else False,
                "kit": members.read_object("kit") if members.has_member("kit") else None,
                "case": members.read_text("case") if members.has_member("case") else None,
            }
        try:
            return cls(**read)
        except ValueError as error:
            raise MalformedVerdictError(place, str(error)) from error


#: Between the titles of several mistakes, in the one title of a diagnosis.
AND_ALSO = " — et aussi : "
#: Before the title of a mistake that others resemble.
LIKELY = "Peut-être : "
#: The source of a diagnosis that a teacher writes.
TEACHER = "teacher"


@dataclass(frozen=True)
class Diagnosis:
    """The misconception whose wrong answers the submission reproduces; of several together, the first one's id.

    `source` is `TEACHER` for what a teacher says of all programs that answer alike, None for what the grader found.
    `explains` holds, for each title, the ids of the failed checks that it explains; empty where that is not known.
    `certain`: the program answers every probe as one with these mistakes and no other does.
    """

    id: str
    title: str
    explanation: str
    source: str | None = None
    explains: tuple[tuple[str, ...], ...] = ()
    certain: bool = False

    @property
    def titles(self) -> tuple[str, ...]:
        """The title of each mistake."""
        return tuple(self.title.split(AND_ALSO))

    @property
    def is_likely(self) -> bool:
        """Whether other mistakes resemble the first one too."""
        return self.title.startswith(LIKELY)

    def to_json(self) -> dict[str, Any]:
        return {
            "id": self.id,
            "title": self.title,
            "explanation": self.explanation,
            **({} if self.source is None else {"source": self.source}),
            **({"explains": [list(checks) for checks in self.explains]} if self.explains else {}),
            **({"certain": True} if self.certain else {}),
        }

    @classmethod
    def from_json(cls, value: Any, place: str = "") -> Diagnosis:
        with ObjectReader(value, place) as members:
            source = members.read_text("source") if members.has_member("source") else None
            explains = members.read_items("explains", _read_check_ids) if members.has_member("explains") else ()
            certain = members.has_member("certain") and members.read_flag("certain")
            texts = (members.read_text("id"), members.read_text("title"), members.read_text("explanation"))
            return cls(*texts, source, tuple(explains), certain)


def _read_check_ids(value: Any, place: str = "") -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise MalformedVerdictError(place, "a list of texts is expected")
    return tuple(value)


@dataclass(frozen=True)
class Verdict:
    """The whole verdict; `score` in [0, 1], `points` on the French scale of 20.

    `remarks` say what was let through in the file; `load_error`, why it does not run, or what it lacks. JSON has these
    two only where there is something to say.

    Raises ValueError for an outcome that the checks do not bear out: OK is every check passed, which earn 20 points
    together; what counts has checks; only an error of ours may come without any.
    """

    exercise: str
    exercise_version: str
    outcome: Outcome
    seed: int
    checks: Sequence[CheckResult] = ()
    diagnosis: Diagnosis | None = None
    stdout: str = ""
    timings: Mapping[str, float] = field(default_factory=dict)
    remarks: Sequence[str] = ()
    load_error: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "checks", tuple(self.checks))
        object.__setattr__(self, "remarks", tuple(self.remarks))
        failed = [check.id for check in self.checks if not check.passed]
        earned = sum(check.points for check in self.checks)
        if self.outcome is Outcome.OK and (failed or abs(earned - MAX_POINTS) > DUST):
            raise ValueError(f"outcome ok, with {earned} points and the failed checks {failed}")
        if self.outcome is not Outcome.OK and not failed and (self.checks or self.outcome.counts):
            raise ValueError(f"outcome {self.outcome.value}, though no check failed")
        if earned > MAX_POINTS + DUST:
            raise ValueError(f"{earned} points of {MAX_POINTS}")

    @property
    def score(self) -> float:
        if self.outcome is Outcome.OK:
            return 1.0
        return round(sum(check.points for check in self.checks) / MAX_POINTS, 6)

    @property
    def points(self) -> float:
        return round(MAX_POINTS * self.score, 4)

    @property
    def misconception(self) -> str | None:
        """The id of the diagnosis, if there is one."""
        return self.diagnosis.id if self.diagnosis else None

    @property
    def counted_misconception(self) -> str | None:
        """The misconception that teachers' boards count: none that is likely only."""
        return None if self.diagnosis is None or self.diagnosis.is_likely else self.diagnosis.id

    @property
    def max_points(self) -> int:
        return int(MAX_POINTS)

    def to_json(self) -> dict[str, Any]:
        return {
            "exercise": self.exercise,
            "exercise_version": self.exercise_version,
            "outcome": self.outcome.value,
            "score": self.score,
            "points": self.points,
            "max_points": self.max_points,
            "checks": [check.to_json() for check in self.checks],
            "diagnosis": self.diagnosis.to_json() if self.diagnosis else None,
            "stdout": self.stdout,
            "seed": self.seed,
            "timings": dict(self.timings),
            **({"remarks": list(self.remarks)} if self.remarks else {}),
            **({"load_error": self.load_error} if self.load_error else {}),
        }

    @classmethod
    def from_json(cls, value: Any) -> Verdict:
        """Read what `to_json` made, by this version or an earlier one. Raises MalformedVerdictError, with the place."""
        with ObjectReader(value) as members:
            read: dict[str, Any] = {
                "exercise": members.read_text("exercise"),
                "exercise_version": members.read_text("exercise_version"),
                "outcome": _read_outcome(members),
                "checks": members.read_items("checks", CheckResult.from_json),
                "diagnosis": members.read_optional("diagnosis", Diagnosis.from_json),
                "stdout": members.read_text("stdout"),
                "seed": members.read_whole_number("seed"),
                "timings": members.read_numbers("timings"),
                "remarks": members.read_texts("remarks") if members.has_member("remarks") else (),
                "load_error": members.read_text("load_error") if members.has_member("load_error") else "",
            }
            stated = {name: members.read_number(name) for name in ("score", "points", "max_points")}
        try:
            verdict = cls(**read)
        except ValueError as error:
            raise MalformedVerdictError("outcome", str(error)) from error
        for name, number in stated.items():
            if number != getattr(verdict, name):
                raise MalformedVerdictError(name, f"is {number}, where the checks make {getattr(verdict, name)}")
        return verdict


def _read_outcome(members: ObjectReader, member: str = "outcome") -> Outcome:
    name = members.read_text(member)
    try:
        return Outcome(name)
    except ValueError as error:
        raise MalformedVerdictError(members.place_of(member), f"is no outcome: {name}") from error


def internal_error_verdict(exercise: str, version: str, seed: int) -> Verdict:
    """Our own failure: no check, no mark, never counted against the student."""
    return Verdict(exercise=exercise, exercise_version=version, outcome=Outcome.INTERNAL_ERROR, seed=seed)
