"""The notebook of mistakes: one's misconceptions by family, and the attempts that mended them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.board.catalogue import find_misconception
from server.board.latest_change import LatestChange, find_change_between
from server.comments.side_by_side import compare_side_by_side
from server.course import Course, Exercise
from server.course.families import MisconceptionFamily, find_family
from server.gradebook import mistakes
from server.gradebook import service as gradebook
from server.gradebook.mistakes import PastMistake
from server.gradebook.schemas import Attempt
from server.pages.schemas import RecalledMistake
from server.recall import repository as recall
from server.recall.models import RecallAnswer
from server.recall.subjects import subject_of_misconception
from server.submissions.models import Submission
from server.web.dependencies import CurrentReader, PageNumber
from server.web.forms import redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader, build_module_link, exercise_href, find_exercise

router = APIRouter(include_in_schema=False)

PATH = "/compte/carnet-d-erreurs"
MISTAKES_A_PAGE = 30
SOURCE_PAGE = "/soumissions/{id}"


@dataclass(frozen=True)
class NotebookEntry:
    """A misconception in an exercise; `change`: from the last attempt that showed it to the one that mended it.

    `tested` is the latest answer to a question about it, or about another misconception of its family.
    """

    mistake: PastMistake
    title: str
    exercise: Exercise
    family: MisconceptionFamily | None
    change: LatestChange | None = None
    tested: RecallAnswer | None = None

    @property
    def exercise_href(self) -> str:
        return exercise_href(self.exercise)

    @property
    def correction_href(self) -> str:
        return correction_href(self.mistake)


def correction_href(mistake: PastMistake) -> str:
    return f"{SOURCE_PAGE.format(id=mistake.last.id)}/correction"


def find_recalled_mistake(
    reader: Reader, exercise: Exercise, submission: Submission, misconception: str
) -> RecalledMistake | None:
    """Find the latest misconception of the same family that the author mended in another exercise, in three queries.

    None for readers who are not the author, and where nothing of the family was mended before this attempt.
    """
    course = reader.course
    family = find_family(course.families, exercise.filing, misconception)
    if family is None or reader.account is None or submission.account_id != reader.account.id:
        return None
    others = [
        other.id for other in course.exercises.values() if other is not exercise and _may_show_family(other, family)
    ]
    for mistake in mistakes.load_past_mistakes(reader.db, submission.account_id, others):
        earlier = course.exercises[mistake.exercise]
        is_mended = mistake.mended is not None and mistake.mended.sent_at < submission.created_at
        if is_mended and find_family(course.families, earlier.filing, mistake.misconception) is family:
            change = _load_mending_change(reader, earlier, mistake)
            lines = ("", "") if change is None else (change.before, change.after)
            return RecalledMistake(earlier.title, family.title, correction_href(mistake), *lines)
    return None


def _load_mending_change(reader: Reader, exercise: Exercise, mistake: PastMistake) -> LatestChange | None:
    """Load what an author changed to mend a misconception, in one query."""
    if mistake.mended is None:
        return None
    sources = mistakes.load_submission_sources(reader.db, (mistake.last.id, mistake.mended.id))
    before, after = sources[mistake.last.id], sources[mistake.mended.id]
    return find_change_between(before, after, is_code=exercise.answers is None)


def _may_show_family(exercise: Exercise, family: MisconceptionFamily) -> bool:
    return bool(family.slips) or family.id in exercise.filing.families.values()


def list_notebook_entries(reader: Reader) -> Sequence[NotebookEntry]:
    """List the reader's misconceptions by family, the family of the latest one first; those without one are last.

    Those of exercises or catalogues that they have left since are not listed.
    """
    if reader.account is None:
        return ()
    entries = [
        entry
        for mistake in mistakes.load_past_mistakes(reader.db, reader.account.id)
        if (entry := _build_entry(reader.course, mistake)) is not None
    ]
    order = {family: rank for rank, family in reversed([*enumerate(entry.family for entry in entries)])}
    return sorted(entries, key=lambda entry: (entry.family is None, order[entry.family]))


def _build_entry(course: Course, mistake: PastMistake) -> NotebookEntry | None:
    exercise = course.exercises.get(mistake.exercise)
    title = find_misconception(course, mistake.exercise, mistake.misconception).diagnosis.title
    if exercise is None or title == mistake.misconception:
        return None
    return NotebookEntry(mistake, title, exercise, find_family(course.families, exercise.filing, mistake.misconception))


def _add_changes_and_tests(reader: Reader, entries: Sequence[NotebookEntry]) -> Sequence[NotebookEntry]:
    """Add the first lines that each mending changed, and when it was last tested, in two queries for all entries."""
    account = reader.account
    answers = recall.load_recall_answers(reader.db, account.id) if account is not None and entries else ()
    latest = {answer.subject: answer for answer in answers}
    pairs = {entry: (entry.mistake.last.id, entry.mistake.mended.id) for entry in entries if entry.mistake.mended}
    sources = mistakes.load_submission_sources(
        reader.db, {submission for pair in pairs.values() for submission in pair}
    )
    changed = []
    for entry in entries:
        change = None
        if entry in pairs:
            before, after = (sources[submission] for submission in pairs[entry])
            change = find_change_between(before, after, is_code=entry.exercise.answers is None)
        tested = latest.get(subject_of_misconception(reader.course, entry.exercise, entry.mistake.misconception))
        changed.append(replace(entry, change=change, tested=tested))
    return changed


@router.get(PATH)
def show_notebook(request: Request, reader: CurrentReader, number: PageNumber = 1) -> Response:
    """Show one's own mistakes, to nobody else."""
    if reader.account is None:
        return redirect_to_login(request)
    entries = list_notebook_entries(reader)
    skipped = (number - 1) * MISTAKES_A_PAGE
    shown = _add_changes_and_tests(reader, entries[skipped : skipped + MISTAKES_A_PAGE])
    page: Mapping[str, Any] = {
        "families": [(family, tuple(group)) for family, group in groupby(shown, key=lambda entry: entry.family)],
        "total": len(entries),
        "left": sum(entry.mistake.mended is None for entry in entries),
        "number": number,
        "more": skipped + MISTAKES_A_PAGE < len(entries),
        "path": PATH,
    }
    return render_page(request, "notebook.html", reader.account, page=page)


@router.get("/soumissions/{submission_id}/correction")
def show_correction(request: Request, submission_id: str, reader: CurrentReader) -> Response:
    """Show an attempt beside the next one of its author that scored more; lead to the attempt where there is none."""
    attempt = gradebook.find_attempt(reader.db, reader.account, submission_id)
    submission = attempt.submission
    exercise = find_exercise(reader.course, *submission.exercise.split("/"))
    after = _find_next_better_attempt(reader, attempt)
    if after is None or exercise.answers is not None:
        return redirect(SOURCE_PAGE.format(id=(after or attempt).submission.id))
    numbers = [gradebook.attempt_number(reader.db, sent) for sent in (submission, after.submission)]
    diagnosis = attempt.grading.diagnosis if attempt.grading else None
    mistake = find_misconception(reader.course, exercise.id, diagnosis).diagnosis.title if diagnosis else ""
    page: Mapping[str, Any] = {
        "module": build_module_link(reader.course.modules[exercise.module]),
        "exercise_title": exercise.title,
        "exercise_href": exercise_href(exercise),
        "mistake": mistake if mistake != diagnosis else "",
        "when": after.submission.created_at,
        "change": {
            "earlier": numbers[0],
            "number": numbers[1],
            "pair": (submission, after.submission),
            "beside": compare_side_by_side(submission.code, after.submission.code),
        },
        "own": reader.account is not None and reader.account.id == submission.account_id,
        "notebook": PATH,
    }
    return render_page(request, "correction.html", reader.account, page=page)


def _find_next_better_attempt(reader: Reader, attempt: Attempt) -> Attempt | None:
    """Return the first later attempt that scored more, of those that the reader and the author may see."""
    submission = attempt.submission
    seen = mistakes.load_attempts_with_feedback(reader.db, submission.account_id, [submission.exercise])
    series = seen.get(submission.exercise, ())
    place = next((index for index, other in enumerate(series) if other.id == submission.id), None)
    better = None if place is None else mistakes.find_better_attempt(series[place], series[place + 1 :])
    return None if better is None else gradebook.find_attempt(reader.db, reader.account, better.id)
