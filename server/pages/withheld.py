"""Views of withheld results, and of the test that an exercise belongs to."""

from __future__ import annotations

from typing import Literal

from server.assignments import feedback, sittings
from server.assignments.feedback import NO_HOLDS, FeedbackHold, FeedbackHolds, SittingStage
from server.assignments.models import SavedWork
from server.course import Exercise
from server.database import utc_now
from server.gradebook.schemas import Attempt
from server.pages import form_state
from server.pages.schemas import TestBanner, WithheldView
from server.web.views import Reader, exercise_href

What = Literal["hints", "diagnosis", "solution"]
IN_TEST: dict[What, str] = {
    "hints": "Pas d’indices pendant le contrôle « {title} » : ils reviennent avec ses résultats.",
    "diagnosis": "",
    "solution": "",
}
FOR_A_TIME: dict[What, str] = {
    "hints": "Le devoir « {title} » garde les indices fermés",
    "diagnosis": "Le devoir « {title} » ne nomme pas les erreurs",
    "solution": "Le devoir « {title} » garde le corrigé fermé",
}
SHOWN_STAGES: dict[SittingStage, Literal["may_begin", "running", "over"]] = {
    SittingStage.may_begin: "may_begin",
    SittingStage.running: "running",
    SittingStage.over: "over",
    SittingStage.missed: "over",
}


def build_withheld_view(closed: FeedbackHold | None, what: What) -> WithheldView | None:
    """None where nothing is held back, or where nothing is to be said of it."""
    if closed is None:
        return None
    if closed.test:
        text = IN_TEST[what].format(title=closed.title)
        return WithheldView(text) if text else None
    text = FOR_A_TIME[what].format(title=closed.title)
    if closed.until is None:
        return WithheldView(f"{text}.")
    return WithheldView(f"{text} jusqu’au", closed.until)


def load_holds_of_exercise(reader: Reader, exercise: Exercise) -> FeedbackHolds:
    return NO_HOLDS if reader.account is None else feedback.load_holds(reader.db, reader.account.id, exercise.id)


def load_saved_work(reader: Reader, exercise: Exercise, latest: Attempt | None) -> SavedWork | None:
    """What is saved in the test that one sits, where nothing was sent since."""
    if reader.account is None or not load_holds_of_exercise(reader, exercise).running_tests:
        return None
    saved = sittings.load_last_saved_work(reader.db, reader.account.id, exercise.id)
    newer = saved is not None and (latest is None or saved.saved_at > latest.submission.created_at)
    return saved if newer else None


def build_test_banner(reader: Reader, exercise: Exercise, saved: SavedWork | None) -> TestBanner | None:
    """Build the banner of the running test, else of the first test that withholds the exercise."""
    holds = load_holds_of_exercise(reader, exercise)
    tests = holds.tests
    if not tests:
        return None
    test = min(
        tests, key=lambda test: list(SHOWN_STAGES).index(test.stage) if test.stage is not SittingStage.running else -1
    )
    account = reader.account
    last = None if account is None else sittings.load_last_saved_work(reader.db, account.id, exercise.id)
    return TestBanner(
        title=test.title,
        href=test.sitting_path,
        stage=SHOWN_STAGES[test.stage],
        now=utc_now(),
        ends=test.ends_at,
        save=f"{exercise_href(exercise)}/brouillon" if test.stage is SittingStage.running else "",
        saved=saved.saved_at if saved else None,
        restored=saved is not None,
        tests=form_state.running_tests_key(holds),
        version=sittings.saved_work_version(last),
    )
