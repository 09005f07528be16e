"""The retrieval questions of the course: all can be asked, and each séance asks some."""

from __future__ import annotations

from server.course.retrievals import find_question_faults
from tests.support.quick import the_course


def test_all_questions_of_the_course_can_be_asked_and_stand_in_their_page() -> None:
    for module in the_course().modules.values():
        assert list(find_question_faults(module)) == []
        standing = {f"{lesson.slug}/{name}" for lesson in module.lessons for name in lesson.text.retrieval_questions}
        assert set(module.retrievals) == standing


def test_every_seance_asks_and_places_the_exercises_that_follow_it() -> None:
    for module in the_course().modules.values():
        placed = {slug for lesson in module.lessons for slug in lesson.text.exercises}
        for lesson in module.lessons:
            if lesson.kind.name == "seance":
                assert lesson.text.retrieval_questions, lesson.slug
                left = [e.slug for e in module.exercises if e.seance == lesson.slug and not e.stars]
                assert [slug for slug in left if slug not in placed] in ([], ["verification"]), lesson.slug
