"""A course of skeletons, taken in for the tests of a file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from server.authoring import new
from server.course import Course, load
from tests.support.outside import taken_in

WRITTEN = (
    ("module", "l19"),
    ("page", "l19/premiers-pas"),
    ("page", "l19/fiches/gain"),
    ("exercise", "l19/gain"),
    ("choice", "l19/verification"),
    ("numbers", "l19/calcul"),
    ("order", "l19/demo"),
    ("replay", "l19/derive-lente"),
)


@pytest.fixture(scope="session")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kalman")
    for kind, name in WRITTEN:
        assert new.write(kind, name, folder)
    return folder


@pytest.fixture(scope="module")
def course(place: Path) -> Iterator[Course]:
    with taken_in(place):
        yield load(place / "curriculum", code=place, render=False)
