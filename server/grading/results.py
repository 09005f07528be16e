"""What is recorded of a grading: the columns of the submission's row that its result fills."""

from collections.abc import Callable, Mapping
from typing import Any

from graders.core.contract.verdict import Verdict, internal_error_verdict
from server.course.models import Course
from server.database import utc_now
from server.submissions.models import Submission

UNKNOWN_VERSION = "inconnue"


def recorded(verdict: Verdict, figures: Mapping[str, Any]) -> dict[str, Any]:
    """A result; an internal error leaves no score, so that it never counts."""
    return {
        "verdict": verdict.to_json(),
        "figures": dict(figures),
        "outcome": verdict.outcome.value,
        "score": verdict.score if verdict.outcome.counts else None,
        "finished_at": utc_now(),
    }


def version_of(course: Course, exercise: str) -> str:
    known = course.exercises.get(exercise)
    return known.version if known else UNKNOWN_VERSION


def give_up_with(course: Course) -> Callable[[Submission], dict[str, Any]]:
    """The result of a submission whose grading has killed its workers."""

    def give_up(row: Submission) -> dict[str, Any]:
        return recorded(internal_error_verdict(row.exercise, version_of(course, row.exercise), row.seed), {})

    return give_up
