"""A misconception as it is projected to its class: no name, nothing that is held back from a student."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.caches import LRUCache
from server.base.errors import NotFound, ServiceError
from server.board import repository, service
from server.board.catalogue import CataloguedMisconception, find_misconception
from server.board.contrast import Extract, ProgramLine, contrast_with_most_alike, extract_lines
from server.board.extracts import folded_name_words
from server.board.lesson_state import MAX_MISTAKES, count_students_with_misconception, find_lesson_mistakes
from server.board.progress import ClassProgress
from server.board.repository import SubmittedSource
from server.board.schemas import FEWEST_TO_PROJECT
from server.board.stuck import LessonExercises
from server.course import Exercise
from server.database import utc_now
from server.desk.board.links import misconception_href
from server.desk.board.misconception_views import MAX_SOURCES, UNKNOWN
from server.desk.views import class_href
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.lesson import service as lessons
from server.lesson.models import LiveLesson
from server.rights.service import ClassAccess
from server.steps.replayable import can_replay
from server.steps.schemas import ReplayBody
from server.steps.service import StepService
from server.text.python_colours import colour_python_lines
from server.web.views import Reader

MAX_RIGHT_SOURCES = 30
LOCATING_SECONDS = 4.0
MAX_LOCATED = 512
#: The wrong line of a submission for its diagnosis; 0 where none is proven.
_LOCATED: LRUCache[tuple[UUID, str], int] = LRUCache(MAX_LOCATED)


@dataclass(frozen=True)
class ColouredLine:
    """A line of a program as HTML; `marked`: it is wrong, or replaces one that is."""

    html: str
    marked: bool


@dataclass(frozen=True)
class ProjectionPage:
    """A misconception on the wall. Without `refusal`, and for enough students or by choice, everything may be shown.

    `is_of_lesson`: some have made it in the lesson that goes on, and these are counted alone.
    `paragraphs` and `question` are HTML where `prose` is true. `wrong` and `right` are programs of different
    students; `others` are the addresses of the mistakes that may be projected in this lesson.
    """

    title: str
    exercise: str
    question: str
    paragraphs: tuple[str, ...]
    prose: bool
    href: str
    refusal: str
    may_project: bool
    fewest: int
    is_of_lesson: bool
    close_href: str
    others: tuple[str, ...]
    wrong: tuple[ColouredLine, ...] = ()
    right: tuple[ColouredLine, ...] = ()


@dataclass(frozen=True)
class ProjectedPrograms:
    """The programs to compare: a wrong one of a submission, with the id of its failed check, and right ones."""

    submission: UUID
    misconception: str
    check: str
    wrong: Extract
    right: tuple[Extract, ...]


def prepare_projection(
    reader: Reader, account: Account, access: ClassAccess, exercise_id: str, misconception: str, *, chosen: bool
) -> tuple[ProjectionPage, ProjectedPrograms | None]:
    """Build the page without its programs, and the programs to compare; none for answers or where few had it.

    `chosen`: the explanation alone may be projected, however few had it. Raise NotFound where nobody had it.
    """
    db, course, school_class, now = reader.db, reader.course, access.school_class, utc_now()
    lesson = lessons.find_current_lesson(db, school_class.id, now)
    progress = service.load_class_progress(
        db, course, school_class, now, besides=() if lesson is None else lesson.exercises
    )
    had = progress.students_who_had(exercise_id, misconception)
    if not had:
        raise NotFound(UNKNOWN)
    exercise, known = course.exercises[exercise_id], find_misconception(course, exercise_id, misconception)
    students = [student.id for student in progress.students]
    rules = lessons.load_projection_rules(db, students, exercise_id)
    today = 0 if lesson is None else _count_today(progress, lesson, exercise_id, misconception)
    href, is_shared = class_href(school_class), (today or len(had)) >= FEWEST_TO_PROJECT
    is_prose = exercise.answers is not None
    page = ProjectionPage(
        title=known.diagnosis.title,
        exercise=exercise.title,
        question=exercise.render_line(known.question) if is_prose else known.question,
        paragraphs=_explanation_paragraphs(exercise, known),
        prose=is_prose,
        href=misconception_href(href, exercise_id, misconception),
        refusal=rules.refusal,
        may_project=chosen or is_shared,
        fewest=FEWEST_TO_PROJECT,
        is_of_lesson=bool(today),
        close_href=misconception_href(href, exercise_id, misconception) if lesson is None else f"{href}/seance",
        others=() if lesson is None else _other_hrefs(progress, lesson, href),
    )
    if rules.refusal or not is_shared or is_prose:
        return page, None
    return page, _choose_programs(db, account, progress, exercise, known, shows_solution=rules.shows_solution)


def _count_today(progress: ClassProgress, lesson: LiveLesson, exercise: str, misconception: str) -> int:
    """Count who has made a mistake in this lesson, or makes it still: among all who ever did, they would be guessed."""
    had = progress.students_who_had(exercise, misconception)
    made_by = (progress.attempts[account, exercise] for account in had)
    return count_students_with_misconception(made_by, misconception, lesson.started_at)


def _other_hrefs(progress: ClassProgress, lesson: LiveLesson, href: str) -> tuple[str, ...]:
    """Return the addresses of the mistakes of a lesson that may be projected."""
    mistakes = find_lesson_mistakes(progress, LessonExercises(tuple(lesson.exercises), lesson.started_at))
    shared = [mistake for mistake in mistakes if mistake.has_enough_students_to_project][:MAX_MISTAKES]
    return tuple(f"{misconception_href(href, mistake.exercise, mistake.id)}/projeter" for mistake in shared)


def _explanation_paragraphs(exercise: Exercise, known: CataloguedMisconception) -> tuple[str, ...]:
    """Return the explanation without its question."""
    parts = [part.strip() for part in known.diagnosis.explanation.split("\n\n")]
    told = [part for part in parts if part and part != known.question.strip()]
    return tuple(exercise.render_paragraphs(part) if exercise.answers is not None else part for part in told)


def _choose_programs(
    db: Session,
    account: Account,
    progress: ClassProgress,
    exercise: Exercise,
    known: CataloguedMisconception,
    *,
    shows_solution: bool,
) -> ProjectedPrograms | None:
    people = folded_name_words(student.name for student in progress.students)
    wrong = repository.load_sources_with_misconception(db, progress.scope, exercise.id, known.diagnosis.id, MAX_SOURCES)
    right = repository.load_successful_sources(db, progress.scope, exercise.id, MAX_RIGHT_SOURCES)
    for function in dict.fromkeys((*known.functions, *(wanted.name for wanted in exercise.functions))):
        right_extracts = [_source_extract(row, function, people) for row in right]
        right_texts = {tuple(extract.texts) for extract in right_extracts}
        found = [(row, _source_extract(row, function, people)) for row in wrong]
        # A function that stands in a right program too is not where the mistake is.
        shown = [(row, extract) for row, extract in found if extract.lines and tuple(extract.texts) not in right_texts]
        if shown:
            smallest, lines = min(shown, key=lambda pair: (len("".join(pair[1].texts)), str(pair[0].submission)))
            check = _failed_check(db, account, exercise, smallest.submission)
            others = tuple(extract for extract in right_extracts if extract.lines) if shows_solution else ()
            return ProjectedPrograms(smallest.submission, known.diagnosis.id, check, lines, others)
    return None


def _source_extract(row: SubmittedSource, function: str, people: Collection[str]) -> Extract:
    code = row.source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return extract_lines(code, (function,), people)


def _failed_check(db: Session, account: Account, exercise: Exercise, submission: UUID) -> str:
    """Return the id of the first failed check that can be replayed; empty where none can."""
    verdict = gradebook.find_attempt(db, account, submission).verdict
    checks = verdict.checks if verdict is not None else ()
    return next((check.id for check in checks if can_replay(exercise, check)), "")


async def complete_projection(
    page: ProjectionPage, programs: ProjectedPrograms | None, steps: StepService, account: Account, address: str
) -> ProjectionPage:
    """Add the programs, with the lines that are proven wrong."""
    if programs is None:
        return page
    line = await _find_mending_line(programs, steps, account, address)
    contrast = contrast_with_most_alike(programs.wrong, line or None, programs.right)
    return replace(page, wrong=_colour_lines(contrast.wrong), right=_colour_lines(contrast.right))


def _colour_lines(lines: Sequence[ProgramLine]) -> tuple[ColouredLine, ...]:
    html = colour_python_lines("\n".join(line.text for line in lines)) if lines else []
    return tuple(ColouredLine(text, line.marked) for text, line in zip(html, lines, strict=True))


async def _find_mending_line(programs: ProjectedPrograms, steps: StepService, account: Account, address: str) -> int:
    """Return the line of the wrong program at which undoing the mistake mends the check; 0 where none is proven."""
    key = programs.submission, programs.misconception
    located = _LOCATED.get(key)
    if located is not None or not programs.check:
        return located or 0
    try:
        async with asyncio.timeout(LOCATING_SECONDS):
            trace = await steps.trace_check(
                account, str(programs.submission), ReplayBody(check=programs.check), address
            )
    except (ServiceError, TimeoutError):  # the programs are shown without a mark, and located at the next look
        return 0
    mark = json.loads(trace)["mark"]
    return _LOCATED.put(key, 0 if mark is None else int(mark["line"]))
