"""From the questions of a class, and words to its students, to what the templates show of them."""

from __future__ import annotations

from urllib.parse import quote

from server.base.errors import Invalid
from server.classes.repository import load_members
from server.comments import notes_repository, service
from server.comments.models import ThreadState
from server.comments.schemas import SentNote, ThreadSummary
from server.course import Course, Exercise, Module
from server.desk.talk.schemas import FilterView, NoteForm, NotesPage, QuestionRow, QuestionsPage, SentNoteRow
from server.desk.talk.work_views import find_class_exercise
from server.desk.views import class_head, class_href
from server.rights.service import ClassAccess
from server.web.news import title_of_link
from server.web.threads import Draft, shorten, state_label, thread_subject
from server.web.threads import thread_href as href_of_thread
from server.web.views import Reader, exercise_href, exercises_in_reading_order, lesson_href, lessons_in_reading_order
from server.web.words import iso_moment, short_moment

#: In the address of the page; the first is what it shows unasked.
FILTERS: dict[str, tuple[ThreadState | None, str]] = {
    "ouvertes": (ThreadState.open, "À répondre"),
    "repondues": (ThreadState.answered, "Répondus"),
    "reglees": (ThreadState.settled, "Réglés"),
    "toutes": (None, "Tous les fils"),
}
FOREIGN_LINK = "Choisissez une page ou un exercice de ce module."


def build_questions_page(reader: Reader, access: ClassAccess, wanted: str, number: int) -> QuestionsPage:
    """`wanted` is one of FILTERS."""
    school_class = access.school_class
    state, _ = FILTERS[wanted]
    found = service.load_thread_page(reader.db, school_class, state, number)
    href = f"{class_href(school_class)}/questions"
    page = f"{href}?etat={wanted}&page="
    total = sum(found.counts.values())
    return QuestionsPage(
        head=class_head(reader.course, access, "/questions"),
        filters=tuple(
            FilterView(
                f"{label} ({found.counts[filter_state] if filter_state else total})",
                f"{href}?etat={name}",
                name == wanted,
            )
            for name, (filter_state, label) in FILTERS.items()
        ),
        rows=tuple(_question_row(reader.course, access, thread) for thread in found.threads),
        newer=f"{page}{number - 1}" if number > 1 else "",
        older=f"{page}{number + 1}" if found.more else "",
    )


def _question_row(course: Course, access: ClassAccess, summary: ThreadSummary) -> QuestionRow:
    thread = summary.thread
    return QuestionRow(
        href=href_of_thread(thread),
        student=summary.student,
        student_href=f"{class_href(access.school_class)}/eleves/{thread.account_id}/{thread.exercise}",
        exercise=_exercise_title(course, thread.exercise),
        about=thread_subject(thread),
        state=thread.state,
        label=state_label(thread, by_staff_alone=thread.by_staff and summary.messages == 1),
        text=shorten(summary.text),
        messages=summary.messages,
        when=iso_moment(thread.changed_at),
        when_text=short_moment(thread.changed_at),
    )


def _exercise_title(course: Course, exercise: str) -> str:
    found = course.exercises.get(exercise)
    return found.title if found else exercise


def build_notes_page(
    reader: Reader, access: ClassAccess, exercise: str, mistake: str, link: str = "", draft: Draft | None = None
) -> NotesPage:
    """`exercise` and `mistake`, where they are not empty, are what the next word is about. Raises NotFound."""
    school_class = access.school_class
    module = reader.course.modules.get(school_class.module)
    chosen = find_class_exercise(reader, access, *exercise.split("/", 1)) if "/" in exercise else None
    now = notes_repository.load_current_misconceptions(reader.db, school_class.id, chosen.id) if chosen else []
    titles = {name: title for name, title, _ in now}
    href = f"{class_href(school_class)}/mots?exercice="
    return NotesPage(
        head=class_head(reader.course, access, "/questions"),
        exercises=tuple((listed.id, listed.title) for listed in exercises_in_reading_order(module)) if module else (),
        exercise=chosen.id if chosen else "",
        mistakes=tuple(
            (f"{href}{quote(exercise, safe='')}&erreur={quote(name, safe='')}#ecrire", title, count, name == mistake)
            for name, title, count in now
        ),
        form=_note_form(reader, access, module, chosen, mistake, titles, link, draft or Draft())
        if chosen and module
        else None,
        told=tuple(
            _sent_note_row(reader.course, note)
            for note in notes_repository.load_class_notes(reader.db, school_class.id)
        ),
    )


def _note_form(
    reader: Reader,
    access: ClassAccess,
    module: Module,
    exercise: Exercise,
    mistake: str,
    titles: dict[str, str],
    link: str,
    draft: Draft,
) -> NoteForm:
    class_id = access.school_class.id
    concerned = notes_repository.load_student_ids_with_misconception(reader.db, class_id, exercise.id, mistake or None)
    members = load_members(reader.db, class_id, concerned)
    return NoteForm(
        exercise=exercise.id,
        exercise_title=exercise.title,
        mistake=mistake,
        mistake_title=titles.get(mistake, mistake),
        students=tuple(member.name for member in members),
        links=_link_groups(module),
        link=link,
        draft=draft,
    )


def _link_groups(module: Module) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
    lessons = tuple((lesson_href(lesson), lesson.title) for lesson in lessons_in_reading_order(module))
    exercises = tuple((exercise_href(exercise), exercise.title) for exercise in exercises_in_reading_order(module))
    return tuple(group for group in (("Pages du cours", lessons), ("Exercices", exercises)) if group[1])


def validate_link(course: Course, access: ClassAccess, link: str) -> str:
    """Where a word may send students: a page or an exercise of the class's module, or nowhere. Raises Invalid."""
    module = course.modules.get(access.school_class.module)
    known = {address for _, group in _link_groups(module) for address, _ in group} if module else set()
    if link and link not in known:
        raise Invalid(FOREIGN_LINK)
    return link


def _sent_note_row(course: Course, sent_note: SentNote) -> SentNoteRow:
    note = sent_note.note
    return SentNoteRow(
        exercise=_exercise_title(course, note.exercise),
        mistake=note.misconception or "",
        author=sent_note.author or "un enseignant",
        text=note.text,
        link=note.link,
        link_title=title_of_link(course, note.link),
        readers=sent_note.readers,
        seen=sent_note.seen,
        when=iso_moment(note.created_at),
        when_text=short_moment(note.created_at),
    )
