"""What the first reader would wait for is prepared beforehand, whatever is wrong with a part of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from server.course import Course
from server.polls import service as polls
from server.reading import ahead
from tests.support.quick import the_course


class Part:
    """A lesson, or an exercise, that notes what is read of it; `broken`: it cannot be."""

    def __init__(self, name: str, read: list[str], *, broken: bool = False) -> None:
        self.slug = self.id = name
        self._read, self._broken = read, broken
        self.text = SimpleNamespace(source=SimpleNamespace(names=lambda: None))

    @property
    def headings(self) -> tuple[()]:
        return self._seen()

    @property
    def grader(self) -> tuple[()]:
        return self._seen()

    def _seen(self) -> tuple[()]:
        if self._broken:
            raise OSError("un disque arraché")
        self._read.append(self.slug)
        return ()


def test_one_part_that_cannot_be_prepared_is_told_and_the_others_are(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(ahead, "PAUSE", 0.0)
    monkeypatch.setattr(ahead, "FIRST_PAUSE", 0.0)
    monkeypatch.setattr(polls, "polls_of_lesson", lambda _module, _lesson: {})
    read: list[str] = []
    lessons = [Part("a", read), Part("b", read, broken=True), Part("c", read)]
    exercises = {one.id: one for one in (Part("x", read, broken=True), Part("y", read))}
    course: Any = SimpleNamespace(modules={"l20": SimpleNamespace(lessons=lessons)}, exercises=exercises)
    ahead.preload_course(course)
    assert read == ["a", "c", "y"]
    assert [record.args for record in caplog.records] == [("b",), ("x",)]


def test_a_lesson_is_read_without_the_questions_of_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def of_lesson(_module: Any, lesson: Any) -> Any:
        asked.append(lesson.slug)
        return iter(())

    monkeypatch.setattr(polls, "_iter_lesson_polls", of_lesson)
    polls.polls_of_lesson.cache_clear()
    course: Course = the_course()
    module = course.modules["l20"]
    lesson = module.lessons[0]
    nobody: Any = None
    polls.load_first_answers_in_lesson(nobody, nobody, module, lesson)
    assert asked == [lesson.slug]
    polls.polls_of_lesson.cache_clear()
