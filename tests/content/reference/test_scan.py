"""Scans: what they show, and what they refuse."""

import math
from typing import Any

import numpy as np
import pytest

from reference.world.scan import Scan, ScanError, turn_angles


def test_points_are_those_of_the_beams_that_hit() -> None:
    scan = Scan.full_turn([2.0, 1.0, 5.0, 0.0], 5.0)
    np.testing.assert_allclose(scan.points(), [[2.0, 0.0], [0.0, 1.0]], atol=1e-15)
    assert scan.hits.tolist() == [True, True, False, False]
    assert len(scan) == 4


def test_an_empty_scan_shows_no_point() -> None:
    assert Scan.full_turn([], 5.0).points().shape == (0, 2)


def test_what_a_sensor_says_when_it_sees_nothing() -> None:
    scan = Scan.from_sensor([math.inf, math.nan, 0.0, -1.0, 9.0, 5.0, 2.0], np.zeros(7), 5.0)
    assert scan.ranges.tolist() == [5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 2.0]
    assert scan.hits.sum() == 1


def test_one_beam_out_of_three() -> None:
    scan = Scan.full_turn(np.arange(7.0), 9.0).every(3)
    assert scan.ranges.tolist() == [0.0, 3.0, 6.0]
    np.testing.assert_allclose(scan.angles, turn_angles(7)[::3])


def test_a_scan_keeps_what_it_was_given() -> None:
    ranges = np.array([1.0, 2.0])
    scan = Scan(ranges, np.zeros(2), 5.0)
    ranges[0] = 4.0
    assert scan.ranges[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        scan.ranges[0] = 3.0


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("ranges", lambda: Scan(np.array([6.0]), np.zeros(1), 5.0)),
        ("ranges", lambda: Scan(np.array([-1.0]), np.zeros(1), 5.0)),
        ("ranges", lambda: Scan(np.array([math.nan]), np.zeros(1), 5.0)),
        ("ranges", lambda: Scan(np.ones((1, 1)), np.zeros(1), 5.0)),
        ("angles", lambda: Scan(np.ones(2), np.zeros(1), 5.0)),
        ("angles", lambda: Scan(np.ones(1), np.array([math.nan]), 5.0)),
        ("max_range", lambda: Scan(np.ones(1), np.zeros(1), math.inf)),
        ("step", lambda: Scan.full_turn([1.0], 5.0).every(0)),
        ("beams", lambda: turn_angles(-1)),
    ],
)
def test_what_no_lidar_measures_is_named(argument: str, call: Any) -> None:
    with pytest.raises(ScanError) as error:
        call()
    assert error.value.argument == argument
