"""From the course's lessons, glossary and exercises to what the reading templates show."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import groupby

from markupsafe import Markup

from graders.typography import unaccented
from server.base.errors import NotFound
from server.course import Exercise, Module
from server.course.kinds import KINDS, SEANCE
from server.course.lengths import duration_in_words, estimate_exercise_minutes, estimate_reading_minutes
from server.course.models import Heading, Lesson, ReadingPath, Term
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.identity.models import Account
from server.polls import service as polls
from server.reading import gates, search, texts
from server.reading.schemas import (
    ContentsEntry,
    CourseHome,
    GlossaryLetter,
    GlossaryPage,
    GlossaryTermView,
    LessonLink,
    LessonPage,
    LessonShelf,
    NeighbourModuleView,
    PathView,
    SearchPage,
    SessionCard,
    SolutionGate,
)
from server.recall import paths
from server.sandbox.exceptions import USUAL_ERRORS
from server.studio import service as studio
from server.text.lines import normalise_line
from server.text.prose import render_author_line
from server.web import deadlines, editions
from server.web.deadlines import DueAssignmentView
from server.web.next_step import choose_next_exercise
from server.web.schemas import ExerciseRow, FigureView
from server.web.views import (
    Reader,
    build_exercise_row,
    build_module_link,
    exercises_in_reading_order,
    lesson_href,
    lessons_in_reading_order,
)
from server.web.words import count_with_noun

MAX_HEADING_LEVEL = 3  # in a table of contents
TERM_LINK = re.compile(r'data-term="([^"]+)"')
EXAMPLE_COUNT = 4  # suggested words on an empty search


def find_lesson(module: Module, slug: str) -> Lesson:
    """Raises NotFound."""
    for lesson in module.lessons:
        if lesson.slug == slug:
            return lesson
    raise NotFound("Cette page n’existe pas.")


def build_course_home(reader: Reader, module: Module) -> CourseHome:
    progress = gradebook.load_progress(reader.db, reader.account)
    due = deadlines.load_assignments_due_soon(reader.db, reader.account, progress, module.slug)
    choices = paths.load_chosen_paths(reader.db, reader.account.id if reader.account else None)
    others = {edition.number: f"/{edition.slug}" for edition in reader.course.latest}
    view = build_home_view(module, progress, due, others, paths.find_chosen_path(module, choices))
    names = studio.list_exercises_proposed_to_account(reader.db, reader.account, module.slug)
    found = [exercise for name in names if (exercise := reader.course.exercises.get(name)) is not None]
    proposed = tuple(_exercise_rows_by_slug(found, progress).values())
    return replace(view, edition=editions.build_edition_note(reader, module), proposed=proposed)


def build_home_view(
    module: Module,
    progress: Mapping[str, ExerciseProgress],
    due: tuple[DueAssignmentView, ...],
    others: Mapping[str, str],
    chosen_path: ReadingPath | None = None,
) -> CourseHome:
    """A module's page for one who stands there in its exercises, and has that to hand in.

    `others` are the addresses of modules, by their numbers; `chosen_path` is the reader's path.
    """
    rows = _exercise_rows_by_slug(exercises_in_reading_order(module), progress)
    way = lessons_in_reading_order(module)
    sessions = tuple(
        _build_session_card(module, lesson, _exercise_rows_after(module, rows, lesson), chosen_path)
        for lesson in way
        if lesson.kind is SEANCE
    )
    placed = {row.href for card in sessions for row in card.exercises}
    left = tuple(row for row in rows.values() if row.href not in placed)
    length = count_with_noun(module.sessions, "séance") if module.sessions else ""
    around = (("après", module.previous), ("avant", module.next))
    facts = (
        ("Durée", length),
        ("Prérequis", "\u00a0; ".join(module.prerequisites)),
    )
    return CourseHome(
        slug=module.slug,
        number=module.label,
        title=module.title,
        track=module.track,
        summary=module.summary,
        facts=tuple((name, value) for name, value in facts if value),
        around=tuple(NeighbourModuleView(word, number, others.get(number, "")) for word, number in around if number),
        objectives=module.objectives,
        references=tuple(Markup(render_author_line(reference, module.names)) for reference in module.references),
        paths=tuple(_build_path_view(module, way, chosen_path) for way in module.paths),
        start=_build_lesson_link(way[0]) if way else None,
        resumed=choose_next_exercise(module, progress, chosen_path)
        if any(row.own.attempts for row in rows.values())
        else None,
        sessions=sessions,
        shelves=tuple(_group_lessons_by_kind(way)),
        exercises=tuple(row for row in left if not row.stars),
        challenges=tuple(row for row in left if row.stars),
        terms=len(module.glossary),
        kit_href=f"/{module.slug}/kit/{module.slug}.py",
        done=sum(row.own.done for row in rows.values()),
        total=len(rows),
        due=due,
    )


def _build_path_view(module: Module, path: ReadingPath, chosen_path: ReadingPath | None) -> PathView:
    href = f"/{module.slug}/lire/{path.page}"
    return PathView(path.title, path.summary, href, path.page if path.exercises else "", path is chosen_path)


def _exercise_rows_by_slug(
    exercises: Sequence[Exercise], progress: Mapping[str, ExerciseProgress]
) -> dict[str, ExerciseRow]:
    """One row for each exercise, by its slug."""
    return {
        exercise.slug: build_exercise_row(exercise, progress.get(exercise.id, NOTHING_YET)) for exercise in exercises
    }


def _exercise_rows_after(module: Module, rows: Mapping[str, ExerciseRow], lesson: Lesson) -> tuple[ExerciseRow, ...]:
    return tuple(rows[exercise.slug] for exercise in exercises_after(module, lesson))


def exercises_after(module: Module, lesson: Lesson) -> list[Exercise]:
    """Those that the lesson leads to."""
    return [exercise for exercise in module.exercises if exercise.seance == lesson.slug]


def _build_session_card(
    module: Module, lesson: Lesson, exercises: tuple[ExerciseRow, ...], chosen_path: ReadingPath | None
) -> SessionCard:
    link = _build_lesson_link(lesson, _path_names_to_leave_out(chosen_path))
    return SessionCard(
        link,
        _first_figure_of_lesson(module, lesson),
        exercises,
        _exercise_duration_in_words(module, lesson, chosen_path),
    )


def _path_names_to_leave_out(chosen_path: ReadingPath | None) -> Sequence[str]:
    """Return the name of the path whose parts for later are left out, in a list."""
    return (chosen_path.name,) if chosen_path is not None and chosen_path.name else ()


def _exercise_duration_in_words(module: Module, lesson: Lesson, chosen_path: ReadingPath | None) -> str:
    """Return how long the exercises of a lesson take that the reader's path has, in words."""
    own = (
        exercise
        for exercise in exercises_after(module, lesson)
        if chosen_path is None or not chosen_path.exercises or exercise.slug in chosen_path.exercises
    )
    return duration_in_words(sum(map(estimate_exercise_minutes, own)))


def _first_figure_of_lesson(module: Module, lesson: Lesson) -> FigureView | None:
    """The séance's first drawing, without its description, which stands in the lesson itself."""
    name = next((figure for figure in lesson.figures if figure in module.drawings), None)
    if name is None:
        return None
    light, dark = (f"/{module.slug}/figures/{name}.svg?theme={theme}" for theme in ("light", "dark"))
    return FigureView(light, dark, "")


def _group_lessons_by_kind(way: Sequence[Lesson]) -> Iterator[LessonShelf]:
    for kind in KINDS:
        links = tuple(_build_lesson_link(lesson) for lesson in way if lesson.kind is kind)
        if links and kind.shelf:
            yield LessonShelf(kind.name, kind.shelf, links)


def _build_lesson_link(lesson: Lesson, left: Sequence[str] = ()) -> LessonLink:
    return LessonLink(
        slug=lesson.slug,
        href=lesson_href(lesson),
        label=lesson.label,
        title=lesson.title,
        summary=lesson.summary,
        duration=duration_in_words(estimate_reading_minutes(lesson, left)),
        objectives=len(lesson.objectives),
        parts=sum(heading.level == 2 for heading in lesson.headings),
    )


def build_lesson_page(reader: Reader, module: Module, lesson: Lesson, *, is_warning_read: bool = False) -> LessonPage:
    said = polls.load_first_answers_in_lesson(reader.db, reader.account, module, lesson)
    gate = gates.choose_solution_gate(reader, lesson, is_warning_read=is_warning_read)
    progress = gradebook.load_progress(reader.db, reader.account)
    chosen = paths.find_chosen_path(
        module, paths.load_chosen_paths(reader.db, reader.account.id if reader.account else None)
    )
    return build_lesson_view(module, lesson, progress, said, gate, account=reader.account, chosen_path=chosen)


def build_lesson_view(
    module: Module,
    lesson: Lesson,
    progress: Mapping[str, ExerciseProgress],
    first_answers: Mapping[str, str] | None,
    gate: SolutionGate | None = None,
    account: Account | None = None,
    chosen_path: ReadingPath | None = None,
) -> LessonPage:
    """A lesson for one who stands there in the module's exercises, and gave `first_answers` to its questions; None
    where nobody hears them. Behind a gate that is not open, nothing of its text. `chosen_path` is the reader's path,
    which folds what it leaves for later."""
    way = lessons_in_reading_order(module)
    left = _path_names_to_leave_out(chosen_path)
    rows = _exercise_rows_by_slug(module.exercises, progress)
    following = [exercise.slug for exercise in exercises_after(module, lesson)]
    placed = lesson.text.exercises
    place = way.index(lesson)
    shown = gate is None or gate.state == "open"
    return LessonPage(
        module=build_module_link(module),
        slug=lesson.slug,
        kind=lesson.kind.name,
        label=lesson.label,
        title=lesson.title,
        summary=lesson.summary,
        duration=duration_in_words(estimate_reading_minutes(lesson, left)),
        work=_exercise_duration_in_words(module, lesson, chosen_path),
        later=duration_in_words(estimate_reading_minutes(lesson) - estimate_reading_minutes(lesson, left)),
        path=chosen_path.title if left and chosen_path is not None else "",
        placed=sum(slug in placed for slug in following),
        objectives=lesson.objectives,
        html=texts.fill_lesson_text(module, lesson, rows, account, left, is_heard=first_answers is not None)
        if shown
        else Markup(),
        said=json.dumps(dict(first_answers or {}), ensure_ascii=False),
        contents=build_contents_tree(lesson) if shown else (),
        exercises=tuple(rows[slug] for slug in following if slug not in placed),
        terms=_glossary_terms_in_lesson(module, lesson) if shown else (),
        previous=_build_lesson_link(way[place - 1]) if place else None,
        following=_build_lesson_link(way[place + 1]) if place + 1 < len(way) else None,
        gate=gate,
    )


@lru_cache(maxsize=512)
def build_contents_tree(lesson: Lesson) -> tuple[ContentsEntry, ...]:
    """The lesson's headings as a tree of two levels."""
    headings = [heading for heading in lesson.headings if heading.level <= MAX_HEADING_LEVEL]
    top = min((heading.level for heading in headings), default=0)
    tree: list[tuple[Heading, list[Heading]]] = []
    for heading in headings:
        if heading.level == top:
            tree.append((heading, []))
        elif tree:
            tree[-1][1].append(heading)
    return tuple(
        _build_contents_entry(heading, tuple(_build_contents_entry(subheading, ()) for subheading in below))
        for heading, below in tree
    )


def _build_contents_entry(heading: Heading, below: tuple[ContentsEntry, ...]) -> ContentsEntry:
    return ContentsEntry(heading.id, Markup(heading.html), below)


@lru_cache(maxsize=512)
def _glossary_terms_in_lesson(module: Module, lesson: Lesson) -> tuple[GlossaryTermView, ...]:
    """The words that the lesson links to the glossary, each once."""
    names = dict.fromkeys(TERM_LINK.findall(lesson.html))
    return tuple(_build_term_view(module, module.glossary[name]) for name in names)


def _build_term_view(module: Module, term: Term) -> GlossaryTermView:
    lesson = next((lesson for lesson in module.lessons if lesson.slug == term.page), None)
    href, where = (lesson_href(lesson), lesson.title) if lesson else ("", "")
    return GlossaryTermView(term.id, term.word, Markup(term.html), href, where)


def build_glossary_page(module: Module) -> GlossaryPage:
    """Raises NotFound for a module without one."""
    if not module.glossary:
        raise NotFound("Ce module n’a pas de glossaire.")
    return GlossaryPage(build_module_link(module), _group_terms_by_letter(module), len(module.glossary), USUAL_ERRORS)


@lru_cache(maxsize=32)
def _group_terms_by_letter(module: Module) -> tuple[GlossaryLetter, ...]:
    terms = sorted(
        (_build_term_view(module, term) for term in module.glossary.values()),
        key=lambda term: dictionary_sort_key(term.word),
    )
    groups = groupby(terms, key=lambda term: dictionary_sort_key(term.word)[:1].upper())
    return tuple(GlossaryLetter(letter, tuple(group)) for letter, group in groups)


def dictionary_sort_key(word: str) -> str:
    """A word as a dictionary sorts it: no accent, no capital, no hyphen."""
    return re.sub(r"[^a-z0-9]+", " ", unaccented(word)).strip()


def build_search_page(module: Module, query: str) -> SearchPage:
    query = normalise_line(query)
    found = search.search_lessons(module, query)
    return SearchPage(
        build_module_link(module), query, found.read_as, found.hits, () if found.hits else _example_searches(module)
    )


def _example_searches(module: Module) -> tuple[str, ...]:
    words = [term.word for term in module.glossary.values()]
    return tuple(words[:: max(1, len(words) // EXAMPLE_COUNT)][:EXAMPLE_COUNT])
