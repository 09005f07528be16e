"""One misconception in a class: what it is, in whose programs, and what to do about it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from urllib.parse import urlencode

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.board import repository, service
from server.board.extracts import anonymous, function_of, words_of
from server.board.names import Named, named
from server.board.schemas import FEWEST_FOR_A_SHARE, FEWEST_TO_PROJECT, ImprovementStats, MisconceptionStats
from server.board.service import Work
from server.course import Course, Exercise
from server.database import utc_now
from server.desk.board.insight_views import share
from server.desk.board.schemas import MistakePage
from server.desk.board.shown import Shown, mistake_href
from server.desk.board.views import mistake_row
from server.desk.views import head, href_of
from server.rights.models import Right
from server.rights.service import Place
from server.web.views import lesson_href

EXTRACTS = 2
LOOKED_AT = 20  # attempts among which the shortest are chosen
UNKNOWN = "Personne, dans cette classe, n’a eu cette erreur à un exercice qui compte."


def mistake_page(
    db: Session, course: Course, place: Place, exercise_id: str, misconception: str, *, chosen: bool = False
) -> MistakePage:
    """`chosen`: to be projected, however few have had it. Raises NotFound where nobody has."""
    school_class = place.school_class
    work = service.load_exercise_work(db, course, school_class, exercise_id, utc_now())
    found = next((one for one in work.done.misconceptions if one.id == misconception), None)
    if found is None:
        raise NotFound(UNKNOWN)
    exercise, known = course.exercises[exercise_id], named(course, exercise_id, misconception)
    href = href_of(school_class)
    shown = Shown(course, href, work.students)
    had = work.done.ever(exercise_id, misconception)
    paragraphs = [part.strip() for part in known.diagnosis.explanation.split("\n\n") if part.strip()]
    return MistakePage(
        head=head(course, place, ""),
        row=mistake_row(shown, found),
        paragraphs=tuple(exercise.prose(one) if exercise.answers else one for one in paragraphs),
        prose=exercise.answers is not None,
        extracts=_extracts(db, work, exercise, known, misconception),
        still=shown.people(found.students, exercise_id),
        freed=shown.people(had - set(found.students), exercise_id),
        after=_after(found),
        lesson=_lesson(course, exercise),
        project_href=f"{mistake_href(href, exercise_id, misconception)}/projeter",
        word_href=_word_href(href, found) if place.may(Right.comment) and found.now else "",
        may_project=chosen or found.ever >= FEWEST_TO_PROJECT,
        fewest=FEWEST_TO_PROJECT,
    )


def _word_href(class_href: str, found: MisconceptionStats) -> str:
    """Where one writes to all who have it now."""
    return f"{class_href}/mots?{urlencode({'exercice': found.exercise, 'erreur': found.id})}#ecrire"


def _after(found: MisconceptionStats) -> str:
    return (
        share(ImprovementStats(found.exercise, found.title, found.followed, found.improved))
        if (found.followed >= FEWEST_FOR_A_SHARE)
        else ""
    )


def _lesson(course: Course, exercise: Exercise) -> tuple[str, str] | None:
    """What there is to read again: its address and its title."""
    lessons = course.modules[exercise.module].lessons
    found = next((one for one in lessons if one.slug == exercise.seance), None)
    return None if found is None else (lesson_href(found), found.title)


def _extracts(db: Session, work: Work, exercise: Exercise, known: Named, misconception: str) -> tuple[str, ...]:
    """The shortest of the latest programs that have it, each of another student; none of answers without code."""
    if exercise.answers is not None:
        return ()
    functions = known.functions or tuple(one.name for one in exercise.functions)
    people = words_of(one.name for one in work.students)
    rows = repository.sent_with(db, work.scope, exercise.id, misconception, LOOKED_AT)
    by_student = {row[0]: row[1] for row in reversed(rows)}
    texts = {_extract(source, functions, people) for source in by_student.values()} - {""}
    return tuple(sorted(texts, key=lambda text: (len(text), text))[:EXTRACTS])


def _extract(source: bytes, functions: Sequence[str], people: Collection[str]) -> str:
    code = source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return anonymous(function_of(code, functions), people)
