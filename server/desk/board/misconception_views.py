"""The page of one misconception in a class."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from urllib.parse import urlencode

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.board import repository, service
from server.board.catalogue import CataloguedMisconception, find_misconception
from server.board.extracts import anonymise_extract, extract_function, folded_name_words
from server.board.progress import ClassProgress
from server.board.schemas import FEWEST_FOR_A_SHARE, ImprovementStats, MisconceptionStats
from server.course import Course, Exercise
from server.database import utc_now
from server.desk.board.links import BoardLinks, misconception_href
from server.desk.board.schemas import MisconceptionPage
from server.desk.board.side_panel import share_text
from server.desk.board.views import misconception_row
from server.desk.views import class_head, class_href
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.views import lesson_href

EXTRACTS = 2
MAX_SOURCES = 20  # the latest programs, of which the shortest are shown
UNKNOWN = "Personne, dans cette classe, n’a eu cette erreur à un exercice qui compte."


def misconception_page(
    db: Session, course: Course, access: ClassAccess, exercise_id: str, misconception: str
) -> MisconceptionPage:
    """Build the page. Raise NotFound where nobody had it."""
    school_class = access.school_class
    progress = service.load_class_progress(db, course, school_class, utc_now(), only=exercise_id)
    by_id = {stats.id: stats for stats in progress.sorted_misconception_stats}
    stats = by_id.get(misconception)
    if stats is None:
        raise NotFound(UNKNOWN)
    exercise, known = course.exercises[exercise_id], find_misconception(course, exercise_id, misconception)
    href = class_href(school_class)
    links = BoardLinks(course, href, progress.students)
    had = progress.students_who_had(exercise_id, misconception)
    paragraphs = [part.strip() for part in known.diagnosis.explanation.split("\n\n") if part.strip()]
    return MisconceptionPage(
        head=class_head(course, access, "/tableau"),
        row=misconception_row(links, stats),
        paragraphs=tuple(
            exercise.render_paragraphs(paragraph) if exercise.answers else paragraph for paragraph in paragraphs
        ),
        prose=exercise.answers is not None,
        extracts=_source_extracts(db, progress, exercise, known, misconception),
        still=links.people(stats.students, exercise_id),
        freed=links.people(had - set(stats.students), exercise_id),
        after=_improvement_text(stats),
        lesson=_lesson_link(course, exercise),
        project_href=f"{misconception_href(href, exercise_id, misconception)}/projeter",
        word_href=_word_href(href, stats) if access.has(Right.comment) and stats.now else "",
    )


def _word_href(class_href: str, stats: MisconceptionStats) -> str:
    """Return the address of the form that writes to all who have it now."""
    return f"{class_href}/mots?{urlencode({'exercice': stats.exercise, 'erreur': stats.id})}#ecrire"


def _improvement_text(stats: MisconceptionStats) -> str:
    if stats.followed < FEWEST_FOR_A_SHARE:
        return ""
    return share_text(ImprovementStats(stats.exercise, stats.title, stats.followed, stats.improved))


def _lesson_link(course: Course, exercise: Exercise) -> tuple[str, str] | None:
    """Return address and title of the lesson to read again."""
    lessons = course.modules[exercise.module].lessons
    lesson = next((lesson for lesson in lessons if lesson.slug == exercise.seance), None)
    return None if lesson is None else (lesson_href(lesson), lesson.title)


def _source_extracts(
    db: Session, progress: ClassProgress, exercise: Exercise, known: CataloguedMisconception, misconception: str
) -> tuple[str, ...]:
    """Return the shortest of the latest programs that show it, one a student; none for answers without code."""
    if exercise.answers is not None:
        return ()
    functions = known.functions or tuple(function.name for function in exercise.functions)
    people = folded_name_words(student.name for student in progress.students)
    rows = repository.load_sources_with_misconception(db, progress.scope, exercise.id, misconception, MAX_SOURCES)
    by_student = {row.account: row.source for row in reversed(rows)}
    texts = {_source_extract(source, functions, people) for source in by_student.values()} - {""}
    return tuple(sorted(texts, key=lambda text: (len(text), text))[:EXTRACTS])


def _source_extract(source: bytes, functions: Sequence[str], people: Collection[str]) -> str:
    code = source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return anonymise_extract(extract_function(code, functions), people)
