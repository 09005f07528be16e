"""A course of skeletons, taken in for the tests of a file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from server.authoring import new
from server.course import Course, load
from tests.support.outside import taken_in

WRITTEN = (
    ("module", "l21"),
    ("page", "l21/premiers-pas"),
    ("page", "l21/fiches/gain"),
    ("exercise", "l21/gain"),
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


@pytest.fixture(scope="module")
def course(place: Path) -> Iterator[Course]:
    with taken_in(place):
        yield load(place / "curriculum", code=place, render=False)
