"""The limits that a student meets are those that the page shows, the exercise's own included."""

from __future__ import annotations

import html
import re
from dataclasses import fields

import pytest

from server.api.schemas import LimitsOut
from server.base.validation import format_size
from server.course.schemas import PolicyEntry
from server.pages.policy import describe_policy_limits
from server.sandbox.policy import LIMIT_SPECS, Policy
from tests.support.small_course import EXERCISE, CourseFolder
from tests.support.small_site import PAGE, SmallSite

OWN = {
    "cpu_seconds": (1.5, "1,5\u00a0s"),
    "wall_seconds": (90.0, "90\u00a0s"),
    "memory_bytes": (1536 << 20, "1,5\u00a0Gio"),
    "source_bytes": (1536, "1,5\u00a0Kio"),
    "stdout_bytes": (1 << 20, "1\u00a0Mio"),
    "frame_bytes": (1030, "1,01\u00a0Kio"),
    "items": (234_567, "234\u202f567"),
    "session_bytes": (32 << 20, "32\u00a0Mio"),
    "session_items": (1_234_567, "1\u202f234\u202f567"),
    "judging_seconds": (7.5, "7,5\u00a0s"),
    "depth": (9, "9\u00a0niveaux"),
    "threads": (4, "4"),
    "files": (20, "20"),
    "file_bytes": (3 << 20, "3\u00a0Mio"),
    "folder_bytes": (40 << 20, "40\u00a0Mio"),
}


def shown(page: str) -> list[tuple[str, str]]:
    return [
        (html.unescape(name), html.unescape(value))
        for name, value in re.findall(r"<div><dt>(.*?)</dt><dd>(.*?)</dd></div>", page)
    ]


def test_no_limit_is_kept_from_students_nor_from_authors_nor_from_programs() -> None:
    assert OWN.keys() == {field.name for field in fields(Policy)}
    for schema in (PolicyEntry, LimitsOut):
        assert list(schema.model_fields) == list(LIMIT_SPECS)


@pytest.mark.parametrize("name", LIMIT_SPECS)
def test_an_exercise_may_not_go_beyond_the_bounds_of_a_limit(course_folder: CourseFolder, name: str) -> None:
    for value in (LIMIT_SPECS[name].minimum / 2, LIMIT_SPECS[name].maximum * 2):
        wanted = value if name.endswith("seconds") else int(value)
        course_folder.write("curriculum/m9/exercices/a/exercise.toml", EXERCISE + f"\n[limits]\n{name} = {wanted}\n")
        (problem,) = course_folder.load().problems
        assert problem.line == EXERCISE.count("\n") + 3
        assert name in problem.message


def test_the_page_shows_every_limit(small_site: SmallSite) -> None:
    limits = shown(small_site.get(PAGE))
    assert [name for name, _ in limits] == [row.label for row in LIMIT_SPECS.values()]
    policy = Policy()
    assert ("Temps de calcul", f"{policy.cpu_seconds:g}\u00a0s") in limits
    assert ("Mémoire, sans les bibliothèques", f"{policy.memory_bytes >> 20}\u00a0Mio") in limits
    assert ("Fils d’exécution (threads)", "un seul") in limits


@pytest.mark.parametrize("field", OWN)
def test_an_exercises_own_limit_binds_and_shows(course_folder: CourseFolder, field: str) -> None:
    value, told = OWN[field]
    course_folder.write("curriculum/m9/exercices/a/exercise.toml", EXERCISE + f"\n[limits]\n{field} = {value}\n")
    course = course_folder.load()
    assert not course.problems
    own, usual = (course.exercises[f"m9/{slug}"] for slug in ("a", "b"))
    assert getattr(own.policy, field) == value
    changed = set(describe_policy_limits(own)) - set(describe_policy_limits(usual))
    assert changed == {(LIMIT_SPECS[field].label, told)}


@pytest.mark.parametrize(
    ("count", "text"),
    [
        (0, "0 octet"),
        (1, "1 octet"),
        (2, "2 octets"),
        (1023, "1023 octets"),
        (1024, "1 Kio"),
        (1536, "1,5 Kio"),
        (100 << 20, "100 Mio"),
        ((1 << 20) + (1 << 18), "1,25 Mio"),
        (3 << 29, "1,5 Gio"),
    ],
)
def test_sizes_are_in_french_units(count: int, text: str) -> None:
    assert format_size(count).replace("\u00a0", " ") == text
