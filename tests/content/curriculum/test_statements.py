"""The examples that statements work out by hand are what the course's solutions find."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graders.core.contract.local import LocalProgram
from graders.l20 import world
from tests.support.shipped import CODE

ROOM = np.array([[cell == "." for cell in row] for row in ("#######", "#.....#", "#...#.#", "#.....#", "#######")])


def solved(exercise: str, function: str, *arguments: Any) -> Any:
    return LocalProgram(CODE[exercise].solution.encode(), world.STILL).call(function, *arguments).value


@pytest.mark.parametrize(
    ("angle", "distance"), [(0.0, 2.7), (math.pi, 0.3), (math.pi / 2, 1.4), (-0.5, 1.6 / math.sin(0.5))]
)
def test_a_ray_in_the_room_of_the_statement(angle: float, distance: float) -> None:
    assert solved("l20/lidar", "lancer_rayon", ROOM, 1.3, 2.6, angle, 12.0) == pytest.approx(distance, abs=0.1)


@pytest.mark.parametrize(("reading", "logarithm"), [(5.0, 0.3439), (2.0, -3.5616), (10.0, -2.2073)])
def test_a_beam_of_the_statement(reading: float, logarithm: float) -> None:
    arguments = (np.array([reading]), np.array([5.0]), 0.2, 10.0, (0.7, 0.1, 0.1, 0.1), 0.5)
    found = solved("l20/modele_faisceau", "log_vraisemblance", *arguments)
    assert found == pytest.approx(logarithm, abs=5e-5)


def test_one_ray_on_the_grid_of_the_statement() -> None:
    found = solved("l20/occupation", "integrer_scan", np.zeros((5, 8)), (1.5, 2.5, 0.0), np.array([3.5]), 12.0)
    np.testing.assert_allclose(np.asarray(found)[2, 2:7], [-0.847, -0.847, -0.847, 0.847, 0.0], atol=5e-4)
