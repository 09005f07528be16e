"""From the course and the stored submissions to what the templates show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from server.base.errors import NotFound
from server.course import Exercise, Module
from server.pages.policy import limits_of
from server.pages.schemas import (
    AttemptPage,
    AttemptRow,
    AttemptsPage,
    ExercisePage,
    FunctionView,
    HintView,
    HomePage,
    Results,
    SolutionView,
    ToldView,
    WorkView,
)
from server.queue import service as queue
from server.submissions import draws
from server.submissions import service as submissions
from server.submissions.models import State, Submission
from server.submissions.service import Progress
from server.web import verdicts
from server.web.rendering import python
from server.web.views import NOTHING_YET, Reader, document_href, exercise_href, in_order, module_link, own_state
from server.web.words import moment, moment_text, plural, points

HINT_OPENS_AFTER = (1, 2, 4)  # changed attempts without success
RECENT_ATTEMPTS = 8


def attempt_at(reader: Reader, exercise: Exercise, submission_id: str) -> Submission:
    """An attempt at this exercise, to be taken up again. Raises NotFound."""
    sent = submissions.get_for(reader.db, reader.account, submission_id)
    if sent.exercise != exercise.id:
        raise NotFound("Cet essai est celui d’un autre exercice.")
    return sent


def home_page(reader: Reader) -> HomePage:
    progress = submissions.progress(reader.db, reader.account)
    return HomePage(tuple(module_link(module, progress) for module in reader.course.modules.values()))


def exercise_page(reader: Reader, exercise: Exercise, taken: str | None) -> ExercisePage:
    """The exercise as this account sees it; `taken` is an attempt's code to start again from."""
    attempts = submissions.attempts(reader.db, reader.account, exercise.id)
    kit = f"{exercise.module}.py"
    return ExercisePage(
        **common_parts(reader, exercise, attempts),
        functions=tuple(FunctionView(one.signature, one.returns, one.doc) for one in exercise.functions),
        starter=exercise.starter,
        code=taken if taken is not None else attempts[0].code if attempts else exercise.starter,
        taken=taken is not None,
        limits=limits_of(exercise),
        kit_href=f"/{exercise.module}/kit/{kit}",
        kit_name=kit,
    )


def _lesson(module: Module, exercise: Exercise) -> tuple[str, str] | None:
    """The page that the exercise follows: its address and its short name."""
    found = next((one for one in module.documents if one.slug == exercise.seance), None)
    return (document_href(found), found.label) if found else None


def common_parts(reader: Reader, exercise: Exercise, attempts: Sequence[Submission]) -> dict[str, Any]:
    """What the page of an exercise holds, of whatever kind."""
    module = reader.course.modules[exercise.module]
    previous, following = _neighbours(module, exercise)
    return {
        "id": exercise.id,
        "title": exercise.title,
        "summary": exercise.summary,
        "stars": exercise.stars,
        "origin": exercise.origin,
        "module": module_link(module),
        "lesson": _lesson(module, exercise),
        "statement": exercise.statement_html,
        "action": f"{exercise_href(exercise)}/soumissions",
        "results": results(reader, exercise, attempts, attempts[0] if attempts else None, _draw(reader, exercise)),
        "previous": previous,
        "following": following,
    }


def _neighbours(module: Module, exercise: Exercise) -> tuple[tuple[str, str] | None, tuple[str, str] | None]:
    way = in_order(module)
    place = way.index(exercise)
    around = (way[place - 1] if place else None, *way[place + 1 : place + 2], None)
    before, after = ((exercise_href(one), one.title) if one else None for one in around[:2])
    return before, after


def attempt_page(
    reader: Reader, exercise: Exercise, submission: Submission, told: Sequence[ToldView] | None = None
) -> AttemptPage:
    """`told` is what was answered, where that is not code."""
    owner = reader.account is not None and submission.account_id == reader.account.id
    attempts = submissions.attempts(reader.db, reader.account, exercise.id) if owner else [submission]
    href = exercise_href(exercise)
    return AttemptPage(
        module=module_link(reader.course.modules[exercise.module]),
        exercise_title=exercise.title,
        exercise_href=href,
        take_href=f"{href}?reprendre={submission.id}",
        when=moment(submission.created_at),
        when_text=moment_text(submission.created_at),
        code=submission.code,
        told=None if told is None else tuple(told),
        results=results(reader, exercise, attempts, submission, submission.seed),
    )


def attempts_page(reader: Reader, exercise: Exercise) -> AttemptsPage:
    attempts = submissions.attempts(reader.db, reader.account, exercise.id)
    return AttemptsPage(
        module=module_link(reader.course.modules[exercise.module]),
        exercise_title=exercise.title,
        exercise_href=exercise_href(exercise),
        attempts=_rows(exercise, attempts, len(attempts)),
    )


def _draw(reader: Reader, exercise: Exercise) -> int | None:
    """The seed of what was drawn for this account, where something was."""
    return None if reader.account is None else draws.find(reader.db, reader.account, exercise.id)


def results(
    reader: Reader,
    exercise: Exercise,
    attempts: Sequence[Submission],
    shown: Submission | None,
    seed: int | None,
) -> Results:
    """What a verdict changes on a page: the verdict, the hints, the solution, the list of attempts (newest first).

    `seed` is that of the draw whose correction is shown, in an exercise answered without code.
    """
    progress = submissions.progress(reader.db, reader.account).get(exercise.id, NOTHING_YET)
    return Results(
        work=_work(reader.db, exercise, shown, _number(attempts, shown)) if shown else None,
        hints=_hints(reader, exercise, progress),
        solution=_solution(reader, exercise, seed),
        attempts=_rows(exercise, attempts, RECENT_ATTEMPTS),
        all_attempts=f"{exercise_href(exercise)}/essais" if len(attempts) > RECENT_ATTEMPTS else "",
        own=own_state(progress),
    )


def _number(attempts: Sequence[Submission], shown: Submission) -> int:
    return len(attempts) - [one.id for one in attempts].index(shown.id)


def _work(db: Session, exercise: Exercise, submission: Submission, number: int) -> WorkView:
    href = f"/soumissions/{submission.id}"
    judged = submission.verdict if submission.state == State.done else None
    texts = None if exercise.answers is None else exercise
    return WorkView(
        id=str(submission.id),
        number=number,
        status=State(submission.state).value,
        waiting=waiting_text(submission.state, queue.position(db, submission)),
        verdict=verdicts.view(Verdict.from_json(judged), f"{href}/figures", texts) if judged is not None else None,
        page=href,
        events=f"{href}/evenements",
        fragment=f"{href}/verdict",
    )


def waiting_text(state: str, position: int | None) -> str:
    """What to say while there is no verdict; `position` is 1 for the next one to be graded."""
    if state == State.running:
        return "Correction en cours…"
    if position is None:
        return ""
    before = position - 1
    return (
        f"En attente : {plural(before, 'envoi passe', 'envois passent')} avant le vôtre."
        if before
        else ("En attente : votre envoi est le prochain.")
    )


def _hints(reader: Reader, exercise: Exercise, progress: Progress) -> tuple[HintView, ...]:
    everything = progress.succeeded or (reader.account is not None and reader.account.is_teacher)
    failed = submissions.distinct_failed_attempts(reader.db, reader.account, exercise.id, besides=[exercise.starter])
    views = []
    for number, (html, needed) in enumerate(zip(exercise.hints, HINT_OPENS_AFTER, strict=True), 1):
        closed = "" if everything or failed >= needed else _opens(needed, needed - failed)
        views.append(HintView(number, "" if closed else html, closed))
    return tuple(views)


def _opens(needed: int, left: int) -> str:
    if needed == left:
        return f"s’ouvre après {plural(needed, 'essai non réussi', 'essais différents non réussis')}."
    return f"s’ouvre après {needed} essais différents non réussis (encore {left})."


def _solution(reader: Reader, exercise: Exercise, seed: int | None) -> SolutionView | None:
    """Raises nothing: a solution that one may not read yet is simply absent."""
    if not submissions.solution_open(reader.db, reader.account, exercise.id):
        return None
    for_all = submissions.solution_open(reader.db, None, exercise.id)
    href = f"{exercise_href(exercise)}/corrige"
    if exercise.answers is None:
        return SolutionView(python(exercise.solution), for_all, href)
    return (
        None if seed is None else SolutionView(Markup(exercise.prose(exercise.answers.correction(seed))), for_all, href)
    )


def _rows(exercise: Exercise, attempts: Sequence[Submission], most: int) -> tuple[AttemptRow, ...]:
    return tuple(_row(exercise, one, len(attempts) - place) for place, one in enumerate(attempts[:most]))


def _row(exercise: Exercise, one: Submission, number: int) -> AttemptRow:
    counts = one.outcome is not None and Outcome(one.outcome).counts
    mark = points(20 * one.score) if counts and one.score is not None else ""
    return AttemptRow(
        number=number,
        href=f"/soumissions/{one.id}",
        when=moment(one.created_at),
        when_text=moment_text(one.created_at),
        points=mark,
        outcome=verdicts.title_of(one.outcome, exercise.kind),
    )
