"""From the course and the stored submissions to what the templates show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from graders.core.code.grading import CodeGrader
from graders.core.contract.kits import SCENARIOS
from graders.core.contract.progress import Progress as Mended
from graders.core.contract.progress import measure_progress as progress_since
from graders.core.contract.streams import stream
from graders.core.contract.verdict import TEACHER, Verdict
from server.assignments import sittings
from server.assignments.feedback import FeedbackHold
from server.assignments.models import SavedWork
from server.base.errors import NotFound
from server.behaviour import service as behaviour
from server.course import Exercise, Module
from server.course.reuse import offers_course_functions
from server.database import utc_now
from server.gradebook import early_verdicts, importable_files, solutions, team_work
from server.gradebook import service as gradebook
from server.gradebook.figures import describe_figures
from server.gradebook.schemas import NOTHING_YET, Attempt, AttemptLine, AttemptList
from server.pages import kits, marks, notebook, onward, opening, talk, withheld
from server.pages.policy import describe_policy_limits
from server.pages.schemas import (
    AttemptPage,
    AttemptRow,
    ExercisePage,
    RecalledMistake,
    ResultsView,
    ReusableExerciseView,
    SubmissionView,
    TranscriptView,
)
from server.pages.waiting import describe_waiting
from server.steps.replayable import can_replay
from server.submissions.models import SubmissionState
from server.submissions.service import GradingProgress
from server.web import deadlines, regraded, verdicts
from server.web.schemas import VerdictView
from server.web.views import (
    Reader,
    build_module_link,
    build_student_progress,
    exercise_href,
    lesson_href,
)
from server.web.words import format_mark

RECENT_ATTEMPTS = 8
ATTEMPTS_A_PAGE = 50
HELD = "Reçu, résultat à paraître"
NOT_LOADED = "Reçu, mais ne s’exécute pas en entier : à corriger"
FAILED = "Pas corrigé, erreur de notre côté"


def find_attempt_at_exercise(reader: Reader, exercise: Exercise, submission_id: str) -> Attempt:
    """An attempt at this exercise, to be taken up again. Raises NotFound."""
    attempt = gradebook.find_attempt(reader.db, reader.account, submission_id)
    if attempt.submission.exercise != exercise.id:
        raise NotFound("Cet essai est celui d’un autre exercice.")
    return attempt


def build_exercise_page(reader: Reader, exercise: Exercise, taken: str | None) -> ExercisePage:
    """The exercise as this account sees it; `taken` is an attempt's code to start again from."""
    latest = gradebook.find_latest_attempt(reader.db, reader.account, exercise.id)
    saved = withheld.load_saved_work(reader, exercise, latest) if taken is None else None
    written = saved.source.decode() if saved else latest.submission.code if latest else exercise.starter
    kit = "" if exercise.kit == SCENARIOS else kits.kit_file_name(reader.course.modules[exercise.module], exercise.kit)
    return ExercisePage(
        **build_common_fields(reader, exercise, latest, saved),
        functions=exercise.functions,
        reused=tuple(_list_reusable_exercises(reader, exercise)),
        starter=exercise.starter,
        code=taken if taken is not None else written,
        taken=taken is not None,
        limits=describe_policy_limits(exercise),
        replay=f"{exercise_href(exercise)}/pas" if exercise.functions else "",
        is_class=all(wanted.is_class for wanted in exercise.functions),
        examples=tuple((function.name, function.example) for function in exercise.functions if function.example),
        kit_href=f"/{exercise.module}/kit/{kit}",
        kit_name=kit,
    )


def _list_reusable_exercises(reader: Reader, exercise: Exercise) -> Iterator[ReusableExerciseView]:
    """The functions that the program may import, and whose they are."""
    earlier = reader.course.importable_exercises(exercise.id)
    own = (
        importable_files.load_importable_file_times(reader.db, reader.account.id, [exercise.id for exercise in earlier])
        if reader.account
        else {}
    )
    tested = frozenset[str]()
    if reader.account and earlier:
        tested = sittings.load_exercises_in_sat_tests(reader.db, reader.account.id, utc_now())
    for reused in earlier:
        functions = tuple(function.name for function in reused.functions)
        offered = offers_course_functions(exercise, reused, tested)
        yield ReusableExerciseView(reused.title, exercise_href(reused), functions, own.get(reused.id), offered)


def _find_lesson_link(module: Module, exercise: Exercise) -> tuple[str, str] | None:
    """The page that the exercise follows: its address and its short name."""
    lesson = next((lesson for lesson in module.lessons if lesson.slug == exercise.seance), None)
    return (lesson_href(lesson), lesson.label) if lesson else None


def build_common_fields(
    reader: Reader, exercise: Exercise, latest: Attempt | None, saved: SavedWork | None, deal: int | None = None
) -> dict[str, Any]:
    """Return the fields that the pages of exercises of every kind share, with the verdict of the latest attempt.

    `saved` is what the fields hold of what was saved in a test; `deal`, in an exercise answered without code, is the
    seed of what was dealt to this account.
    """
    attempts = gradebook.list_attempts(reader.db, reader.account, exercise.id, RECENT_ATTEMPTS)
    work = _build_submission_view(reader, exercise, latest, attempts.total, deal)
    module = reader.course.modules[exercise.module]
    previous, following = onward.find_neighbouring_exercises(module, exercise, onward.find_chosen_path(reader, module))
    return {
        "id": exercise.id,
        "title": exercise.title,
        "summary": exercise.summary,
        "stars": exercise.stars,
        "origin": exercise.origin,
        "module": build_module_link(module),
        "lesson": _find_lesson_link(module, exercise),
        "statement": Markup(exercise.statement_html),
        "action": f"{exercise_href(exercise)}/soumissions",
        "results": build_results(reader, exercise, attempts, work, deal, latest.feedback.diagnosis if latest else None),
        "test": withheld.build_test_banner(reader, exercise, saved),
        "previous": previous,
        "following": following,
        "due": deadlines.load_assignments_due_for_exercise(reader.db, reader.account, exercise.id),
    }


def build_attempt_page(
    reader: Reader,
    exercise: Exercise,
    attempt: Attempt,
    transcript: Sequence[TranscriptView] | None = None,
    *,
    again: bool = False,
) -> AttemptPage:
    """`transcript` is what was answered, where that is not code; `again` as in `SubmissionView`."""
    submission = attempt.submission
    number = gradebook.attempt_number(reader.db, submission)
    href = exercise_href(exercise)
    work = _build_submission_view(reader, exercise, attempt, number, submission.seed, again=again)
    return AttemptPage(
        module=build_module_link(reader.course.modules[exercise.module]),
        exercise_title=exercise.title,
        exercise_href=href,
        take_href=f"{href}?reprendre={submission.id}",
        when=submission.created_at,
        code=submission.code,
        transcript=None if transcript is None else tuple(transcript),
        results=build_results(
            reader,
            exercise,
            _list_attempts_beside(reader, attempt, number),
            work,
            submission.seed,
            attempt.feedback.diagnosis,
        ),
    )


def _list_attempts_beside(reader: Reader, attempt: Attempt, number: int) -> AttemptList:
    """List the attempts beside an attempt: its author's latest ones; for a teacher, only itself."""
    submission, grading = attempt.submission, attempt.grading
    if reader.account is not None and submission.account_id == reader.account.id:
        return gradebook.list_attempts(reader.db, reader.account, submission.exercise, RECENT_ATTEMPTS)
    marks = (grading.outcome, grading.score) if grading else (None, None)
    return AttemptList((AttemptLine(submission.id, number, submission.created_at, *marks),), 1)


def build_attempts_page(reader: Reader, exercise: Exercise, number: int) -> dict[str, Any]:
    """Build page `number` of one's attempts, the newest on page 1. Raise NotFound beyond the last."""
    skipped = (number - 1) * ATTEMPTS_A_PAGE
    attempts = gradebook.list_attempts(reader.db, reader.account, exercise.id, ATTEMPTS_A_PAGE, skipped)
    if skipped and not attempts.lines:
        raise NotFound("Il n’y a pas d’essais plus anciens.")
    return {
        "module": build_module_link(reader.course.modules[exercise.module]),
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "attempts": _build_attempt_rows(exercise, attempts),
        "shared": None if attempts.lines else team_work.find_teammate_attempt(reader.db, reader.account, exercise.id),
        "total": attempts.total,
        "number": number,
        "more": skipped + ATTEMPTS_A_PAGE < attempts.total,
    }


def build_results(
    reader: Reader,
    exercise: Exercise,
    attempts: AttemptList,
    work: SubmissionView | None,
    seed: int | None,
    diagnosis_held: FeedbackHold | None = None,
) -> ResultsView:
    """Build the parts that a verdict changes: the verdict, the hints, the solution, the attempts (newest first).

    `seed` is that of the deal whose correction is shown, in an exercise answered without code.
    """
    progress = gradebook.load_progress(reader.db, reader.account, exercise.id).get(exercise.id, NOTHING_YET)
    verdict = work.verdict if work else None
    access = solutions.load_solution_access(reader.db, reader.account, exercise.id)
    return ResultsView(
        work=work,
        hints=opening.build_hint_views(reader, exercise, progress, access),
        solution=opening.build_solution_view(reader, exercise, progress, access, seed),
        attempts=_build_attempt_rows(exercise, attempts),
        all_attempts=f"{exercise_href(exercise)}/essais" if attempts.total > RECENT_ATTEMPTS else "",
        own=build_student_progress(progress),
        hints_held=None if access.teaches else withheld.build_withheld_view(access.hints_held, "hints"),
        diagnosis_held=withheld.build_withheld_view(diagnosis_held, "diagnosis")
        if verdict and verdict.tone != "good"
        else None,
        solution_held=withheld.build_withheld_view(access.solution_held, "solution")
        if access.is_closed_only_by_hold(progress)
        else None,
        onward=onward.build_way_onward(reader, exercise, verdict) if progress.succeeded else None,
    )


def _build_submission_view(
    reader: Reader,
    exercise: Exercise,
    attempt: Attempt | None,
    number: int,
    seed: int | None,
    *,
    again: bool = False,
) -> SubmissionView | None:
    """`seed` is that of the deal that the page shows, in an exercise answered without code."""
    if attempt is None:
        return None
    submission = attempt.submission
    verdict, is_search_pending = behaviour.load_visible_verdict_and_search_state(reader.db, attempt)
    href = f"/soumissions/{submission.id}"
    place = (
        GradingProgress(SubmissionState.running if attempt.settles_in else SubmissionState.done)
        if attempt.held
        else reader.submissions.progress(reader.db, submission)
    )
    work = SubmissionView(
        id=str(submission.id),
        number=number,
        status=place.state.value,
        waiting=describe_waiting(place),
        held=attempt.held_text,
        runs=not attempt.load_error,
        verdict=None,
        page=href,
        events=f"{href}/evenements",
        fragment=f"{href}/verdict{'?deja=true' if again else ''}",
        again=again,
        marks=marks.build_question_marks(exercise, submission, verdict, seed),
        progress=_build_progress(reader, exercise, attempt, verdict),
        asks=talk.may_ask_question(reader, exercise, submission.account_id),
        regraded=regraded.load_regrade_notice(reader.db, attempt.grading.id, exercise.kind)
        if attempt.grading and not attempt.feedback.diagnosis
        else None,
    )
    if verdict is None or attempt.grading is None:
        return replace(work, early=_early_verdict(reader, exercise, attempt, place.state))
    view = verdicts.build_verdict_view(
        verdict,
        f"{href}/figures",
        None if exercise.answers is None else exercise,
        exercise.functions,
        grading=attempt.grading.id,
        described=describe_figures(reader.db, attempt.grading.id, verdict),
        films=(f"{href}/rejeux", attempt.grading.filmed or ()),
        replayed=(f"{href}/pas", [check.id for check in verdict.checks if can_replay(exercise, check)]),
        world=_find_check_world(exercise, verdict),
    )
    return replace(
        work,
        verdict=view,
        searched=is_search_pending,
        recalled=_recalled_mistake(reader, exercise, attempt, verdict),
    )


def _recalled_mistake(reader: Reader, exercise: Exercise, attempt: Attempt, verdict: Verdict) -> RecalledMistake | None:
    named = verdict.diagnosis
    if named is None or named.source == TEACHER:
        return None
    return notebook.find_recalled_mistake(reader, exercise, attempt.submission, named.id)


def _early_verdict(reader: Reader, exercise: Exercise, attempt: Attempt, state: SubmissionState) -> VerdictView | None:
    """Return the checks of an attempt whose mistake is still sought; None where nothing may be shown yet."""
    if attempt.held or state is not SubmissionState.running:
        return None
    verdict = early_verdicts.load_early_verdict(reader.db, attempt.submission.id)
    if verdict is None:
        return None
    undrawn = replace(verdict, checks=[replace(check, figure=None) for check in verdict.checks])
    world = _find_check_world(exercise, verdict)
    return verdicts.build_verdict_view(undrawn, "", functions=exercise.functions, world=world)


def _find_check_world(exercise: Exercise, verdict: Verdict) -> verdicts.World:
    """Return the kit's settings under which the checks of a verdict ran, which its seed tells."""
    grader = exercise.grader
    if not isinstance(grader, CodeGrader):
        return verdicts.NO_WORLD
    return grader.kit(stream(verdict.seed, "kit")), exercise.solution


def _build_progress(reader: Reader, exercise: Exercise, attempt: Attempt, verdict: Verdict | None) -> Mended | None:
    """What code mended since the attempt before; answers without code are marked one by one in their places."""
    before = None
    if verdict is not None and exercise.answers is None:
        before = gradebook.load_previous_verdict(reader.db, attempt)
    return None if before is None or verdict is None else progress_since(before, verdict)


def _build_attempt_rows(exercise: Exercise, attempts: AttemptList) -> tuple[AttemptRow, ...]:
    return tuple(_build_attempt_row(exercise, line) for line in attempts.lines)


def _build_attempt_row(exercise: Exercise, line: AttemptLine) -> AttemptRow:
    return AttemptRow(
        number=line.number,
        href=f"/soumissions/{line.id}",
        when=line.sent_at,
        points="" if line.score is None else format_mark(20 * line.score),
        outcome=_withheld_outcome_text(line) if line.held else verdicts.outcome_in_words(line.outcome, exercise.kind),
    )


def _withheld_outcome_text(line: AttemptLine) -> str:
    if line.failed:
        return FAILED
    return HELD if line.runs else NOT_LOADED
