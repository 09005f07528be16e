"""The verdict: one JSON object, the same from the command line, the API and the database."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

MAX_POINTS = 20.0


class Outcome(StrEnum):
    """How a submission ended. All but INTERNAL_ERROR are the submission's own doing."""

    OK = "ok"
    WRONG_ANSWER = "wrong_answer"
    SYNTAX_ERROR = "syntax_error"
    IMPORT_ERROR = "import_error"
    MISSING_FUNCTION = "missing_function"
    RUNTIME_ERROR = "runtime_error"
    TIMEOUT = "timeout"
    MEMORY_LIMIT = "memory_limit"
    OUTPUT_LIMIT = "output_limit"
    FORBIDDEN_OPERATION = "forbidden_operation"
    INVALID_OUTPUT = "invalid_output"
    INTERNAL_ERROR = "internal_error"


# What names the whole submission when its checks fail for several causes: the most telling first.
PRECEDENCE = (
    Outcome.SYNTAX_ERROR,
    Outcome.IMPORT_ERROR,
    Outcome.FORBIDDEN_OPERATION,
    Outcome.MEMORY_LIMIT,
    Outcome.TIMEOUT,
    Outcome.OUTPUT_LIMIT,
    Outcome.MISSING_FUNCTION,
    Outcome.RUNTIME_ERROR,
    Outcome.INVALID_OUTPUT,
    Outcome.WRONG_ANSWER,
)


@dataclass(frozen=True)
class Counterexample:
    """One input on which the submission fails; every field is strict JSON."""

    inputs: dict[str, Any]
    expected: Any
    got: Any

    def to_json(self) -> dict[str, Any]:
        return {"inputs": self.inputs, "expected": self.expected, "got": self.got}


@dataclass(frozen=True)
class CheckResult:
    """What one check found. `figure` names a drawing that can be asked for."""

    id: str
    title: str
    points: float
    max_points: float
    cause: Outcome = Outcome.OK
    message: str = ""
    counterexample: Counterexample | None = None
    hint: str | None = None
    figure: str | None = None

    @property
    def passed(self) -> bool:
        return self.cause is Outcome.OK

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
        }


@dataclass(frozen=True)
class Diagnosis:
    """The misconception whose wrong answers the submission reproduces."""

    id: str
    title: str
    explanation: str

    def to_json(self) -> dict[str, Any]:
        return {"id": self.id, "title": self.title, "explanation": self.explanation}


@dataclass(frozen=True)
class Verdict:
    """The whole verdict of contract section 3; `score` in [0, 1], `points` on the French scale of 20."""

    exercise: str
    exercise_version: str
    outcome: Outcome
    seed: int
    checks: Sequence[CheckResult] = ()
    diagnosis: Diagnosis | None = None
    stdout: str = ""
    timings: dict[str, float] = field(default_factory=dict)

    @property
    def score(self) -> float:
        if self.outcome is Outcome.OK:
            return 1.0
        return round(sum(check.points for check in self.checks) / MAX_POINTS, 6)

    def to_json(self) -> dict[str, Any]:
        return {
            "exercise": self.exercise,
            "exercise_version": self.exercise_version,
            "outcome": self.outcome.value,
            "score": self.score,
            "points": round(MAX_POINTS * self.score, 4),
            "max_points": int(MAX_POINTS),
            "checks": [check.to_json() for check in self.checks],
            "diagnosis": self.diagnosis.to_json() if self.diagnosis else None,
            "stdout": self.stdout,
            "seed": self.seed,
            "timings": self.timings,
        }


def overall_outcome(checks: Sequence[CheckResult]) -> Outcome:
    """Full marks are OK; otherwise the most telling cause among the failed checks."""
    causes = {check.cause for check in checks if not check.passed}
    return next((outcome for outcome in PRECEDENCE if outcome in causes), Outcome.OK)


def internal_error_verdict(exercise: str, version: str, seed: int) -> Verdict:
    """Our own failure: no check, no mark, never counted against the student."""
    return Verdict(exercise=exercise, exercise_version=version, outcome=Outcome.INTERNAL_ERROR, seed=seed)
