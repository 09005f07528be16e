"""Unread messages of an account: answers to its questions, notes to several students."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from server.comments.schemas import ReceivedNote, UnreadThread
from server.course import Course
from server.web.threads import shorten, thread_subject
from server.web.words import iso_moment, short_moment


@dataclass(frozen=True)
class NewsView:
    """Something that one has not read: of what it is, how it begins, where it stands."""

    exercise: str
    about: str
    text: str
    href: str


@dataclass(frozen=True)
class WordView:
    """A word to several students; `link` and `link_title` are where it sends them."""

    id: str
    author: str
    when: str
    when_text: str
    text: str
    link: str
    link_title: str
    read: bool


def news_views(found: Sequence[UnreadThread], course: Course) -> tuple[NewsView, ...]:
    return tuple(
        NewsView(
            _title(course, thread.thread.exercise),
            thread_subject(thread.thread),
            shorten(thread.text),
            f"/fils/{thread.thread.id}",
        )
        for thread in found
    )


def word_view(word: ReceivedNote, course: Course) -> WordView:
    note = word.note
    return WordView(
        id=str(note.id),
        author=word.author or "Un enseignant",
        when=iso_moment(note.created_at),
        when_text=short_moment(note.created_at),
        text=note.text,
        link=note.link,
        link_title=title_of_link(course, note.link),
        read=word.seen_at is not None,
    )


def title_of_link(course: Course, link: str) -> str:
    """Return the title at a path of the course; empty where nothing is there any more."""
    module, _, rest = link.strip("/").partition("/")
    kind, _, slug = rest.partition("/")
    found = course.modules.get(module)
    if found is None:
        return ""
    if kind == "exercices":
        return _title(course, f"{module}/{slug}") if f"{module}/{slug}" in course.exercises else ""
    return next((lesson.title for lesson in found.lessons if kind == "lire" and lesson.slug == slug), "")


def _title(course: Course, exercise: str) -> str:
    found = course.exercises.get(exercise)
    return found.title if found else exercise
