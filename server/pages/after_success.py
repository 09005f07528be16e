"""After success: what could be written otherwise, what it costs, and other right ways, side by side. Never a mark."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response
from starlette.concurrency import run_in_threadpool

from graders.core.advice.ways import choose_diverse_specimens, strip_docstrings_and_comments
from graders.core.code.grading import CodeGrader
from graders.core.contract.outcomes import Outcome
from server.base.http import client_address
from server.course import Exercise
from server.course.dependencies import CourseOf
from server.database import Database
from server.database.dependencies import DatabaseOf
from server.gradebook import service as gradebook
from server.gradebook import solutions
from server.gradebook.schemas import NOTHING_YET
from server.hunts.dependencies import HuntsOf
from server.hunts.protocol import ProgramReview
from server.identity.dependencies import OptionalAccount
from server.identity.models import Account
from server.web.forms import redirect
from server.web.rendering import highlight_python, render_page
from server.web.views import build_module_link, exercise_href, find_exercise

router = APIRouter(include_in_schema=False)

#: Times of the reference from which a program is told to be slower, and below which it is told to be faster.
SLOWER, FASTER = 1.5, 0.67


@dataclass(frozen=True)
class PassedProgram:
    """A program that passes; `may_compare`: its reader may see the solution."""

    exercise: Exercise
    source: str
    may_compare: bool


def can_review_programs(exercise: Exercise, is_packaged: bool) -> bool:
    """Whether something can be said of the programs of an exercise: one of code, of the course itself."""
    return is_packaged and exercise.kind == "code" and isinstance(exercise.grader, CodeGrader)


@router.get("/soumissions/{submission_id}/apres")
async def show_program_review(
    request: Request,
    submission_id: str,
    account: OptionalAccount,
    course: CourseOf,
    database: DatabaseOf,
    hunts: HuntsOf,
) -> Response:
    """Show the remarks on an attempt that passes; lead to the attempt where there is nothing to say."""
    passed = await run_in_threadpool(_load_passed_program, database, course, account, submission_id)
    if passed is None or account is None:
        return redirect(f"/soumissions/{submission_id}")
    review = await hunts.review_program(account, passed.exercise, passed.source, client_address(request))
    page = await run_in_threadpool(_build_review_page, course, passed, review, submission_id)
    return await run_in_threadpool(render_page, request, "after_success.html", account, page=page)


def _load_passed_program(
    database: Database, course: CourseOf, account: Account | None, submission_id: str
) -> PassedProgram | None:
    """Load an attempt that the account may see. Raises NotFound."""
    with database.read() as db:
        attempt = gradebook.find_attempt(db, account, submission_id)
        exercise = find_exercise(course, *attempt.submission.exercise.split("/"))
        has_passed = attempt.held is None and attempt.verdict is not None and attempt.verdict.outcome is Outcome.OK
        if not has_passed or not can_review_programs(exercise, course.exercises.is_packaged(exercise.id)):
            return None
        progress = gradebook.load_progress(db, account, exercise.id).get(exercise.id, NOTHING_YET)
        access = solutions.load_solution_access(db, account, exercise.id)
        return PassedProgram(exercise, attempt.submission.code, access.access_reason(progress) is not None)


def _build_review_page(
    course: CourseOf, passed: PassedProgram, review: ProgramReview, submission_id: str
) -> Mapping[str, Any]:
    exercise = passed.exercise
    return {
        "module": build_module_link(course.modules[exercise.module]),
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "attempt_href": f"/soumissions/{submission_id}",
        "remarks": review.remarks,
        "ratio": review.ratio,
        "pace": "slower" if review.ratio >= SLOWER else "faster" if 0 < review.ratio <= FASTER else "alike",
        "own": highlight_python(passed.source),
        "ways": [(title, highlight_python(text)) for title, text in _pick_contrasting_solutions(exercise)]
        if passed.may_compare
        else (),
    }


@lru_cache(maxsize=128)
def _pick_contrasting_solutions(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Return the reference and two right programs of the course that differ from it as much as possible."""
    assert isinstance(exercise.grader, CodeGrader)
    right = [specimen for specimen in exercise.grader.specimens() if specimen.outcome is Outcome.OK]
    texts = {specimen.path.stem: specimen.path.read_text(encoding="utf-8") for specimen in right}
    names = choose_diverse_specimens(exercise.solution, texts)
    others = [(f"Autrement : {name.replace('_', ' ')}", strip_docstrings_and_comments(texts[name])) for name in names]
    return (("La référence", exercise.solution), *others)
