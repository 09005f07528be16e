"""What is recorded of a grading."""

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from graders.core.contract.verdict import Outcome, Verdict
from server.course.models import Course
from server.database import utc_now
from server.gradebook.schemas import Graded

UNKNOWN_VERSION = "inconnue"


def recorded(verdict: Verdict, figures: Mapping[str, Any], started_at: datetime) -> Graded:
    """A grading that ends now; an internal error leaves no score, so that it never counts."""
    counted = verdict.outcome is not Outcome.INTERNAL_ERROR
    return Graded(
        exercise_version=verdict.exercise_version,
        outcome=verdict.outcome,
        score=verdict.score if counted else None,
        diagnosis=verdict.diagnosis.id if verdict.diagnosis else None,
        seed=verdict.seed,
        started_at=started_at,
        finished_at=utc_now(),
        timings=verdict.timings,
        verdict=verdict.to_json(),
        figures=figures,
    )


def version_of(course: Course, exercise: str) -> str:
    known = course.exercises.get(exercise)
    return known.version if known else UNKNOWN_VERSION
