"""A course of skeletons, taken in for the tests of a file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from graders.core.contract.kits import scenario_kit
from server.authoring import new
from server.course import Course, load_course
from server.sandbox import Sandbox
from tests.support.outside import taken_in
from tests.support.quick import the_course

WRITTEN = (
    ("module", "l21"),
    ("page", "l21/premiers-pas"),
    ("page", "l21/fiches/gain"),
    ("exercise", "l21/gain"),
    ("declared", "l21/mots"),
    ("choice", "l21/verification"),
    ("numbers", "l21/calcul"),
    ("order", "l21/demo"),
    ("replay", "l21/derive-lente"),
)


@pytest.fixture(scope="session")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("commande")
    for kind, name in WRITTEN:
        assert new.write_skeleton(kind, name, folder)
    return folder


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    """The sandbox in which the programs of declared exercises run, the author's own included."""
    with Sandbox(scenario_kit()) as shared:
        yield shared


@pytest.fixture(scope="module")
def course(place: Path) -> Iterator[Course]:
    the_course()  # the shipped one is read before another is taken in, which would be part of it
    with taken_in(place):
        yield load_course(place / "curriculum", code=place, render=False)
