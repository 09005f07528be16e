"""Scans: what they show, and what they refuse."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.sensors.rays import thin_scan
from reference.world.scan import Scan, ScanError, full_turn_angles


def test_points_are_those_of_the_beams_that_hit() -> None:
    scan = Scan.full_turn([2.0, 1.0, 5.0, 0.0], 5.0)
    np.testing.assert_allclose(scan.points(), [[2.0, 0.0], [0.0, 1.0]], atol=1e-15)
    assert scan.hit_mask.tolist() == [True, True, False, False]
    assert len(scan) == 4


def test_an_empty_scan_shows_no_point() -> None:
    assert Scan.full_turn([], 5.0).points().shape == (0, 2)


def test_no_echo_and_no_measurement_are_two_events() -> None:
    """REP 117: +Inf says that the way is free; NaN, and -Inf for what is too close, are no measurements."""
    scan = Scan.from_sensor([math.inf, math.nan, -math.inf, 0.0, -1.0, 9.0, 5.0, 2.0, 0.1], np.zeros(9), 5.0, 0.2)
    assert scan.measured.tolist() == [True, False, False, False, False, True, True, True, False]
    assert scan.hit_mask.tolist() == [False] * 7 + [True, False]
    assert scan.too_close.tolist() == [False, False, True, False, False, False, False, False, True]
    assert scan.only_measured().ranges.tolist() == [5.0, 5.0, 5.0, 2.0]
    assert len(scan.points()) == 1


@pytest.mark.parametrize(
    ("zero", "measured", "close"),
    [("no measurement", False, False), ("too close", False, True), ("nothing seen", True, False)],
)
@pytest.mark.parametrize("least", [0.0, 0.2])
def test_a_zero_is_one_event_or_another_as_the_driver_has_it(
    zero: Any, measured: bool, close: bool, least: float
) -> None:
    scan = Scan.from_sensor([0.0, 2.0], np.zeros(2), 5.0, least, zero=zero)
    assert (scan.measured[0], scan.too_close[0], scan.hit_mask[0]) == (measured, close, False)
    assert (scan.measured[1], scan.too_close[1], scan.hit_mask[1]) == (True, False, True)


READINGS = st.one_of(st.floats(-1.0, 9.0), st.sampled_from([math.inf, -math.inf, math.nan, 0.0]))


@given(st.lists(READINGS, max_size=30), st.sampled_from([0.0, 0.1, 1.0]), st.integers(1, 4))
def test_every_reading_is_one_event_and_stays_so_in_parts(readings: Any, least: float, step: int) -> None:
    scan = Scan.from_sensor(readings, np.zeros(len(readings)), 5.0, least)
    nothing_seen = scan.measured & (scan.ranges >= 5.0)
    unknown = ~scan.measured & ~scan.too_close
    events = np.stack([scan.hit_mask, nothing_seen, scan.too_close, unknown])
    assert events.sum(axis=0).tolist() == [1] * len(readings)
    np.testing.assert_array_equal(scan.take_every(step).too_close, scan.too_close[::step])
    np.testing.assert_array_equal(scan.take_every(step).measured, scan.measured[::step])


def test_what_was_not_measured_stays_so_in_parts_of_a_scan() -> None:
    scan = Scan.from_sensor([1.0, math.nan, 3.0, math.nan, 2.0, math.inf], full_turn_angles(6), 5.0)
    assert scan.take_every(3).measured.tolist() == [True, False]
    assert thin_scan(scan, 3).measured.tolist() == [True, True, True]
    assert scan.select_beams([1, 2]).measured.tolist() == [False, True]
    with pytest.raises(ValueError, match="read-only"):
        scan.measured[1] = True
    full = Scan.full_turn([1.0, 5.0], 5.0)
    assert full.measured.all()
    assert full.only_measured() is full


def test_a_gap_is_drawn_between_its_neighbours_all_round() -> None:
    scan = Scan.from_sensor([math.nan, 1.0, math.nan, math.nan, 4.0, math.nan], full_turn_angles(6), 5.0)
    assert scan.filled_ranges().tolist() == [2.0, 1.0, 2.0, 3.0, 4.0, 3.0]
    assert Scan.from_sensor([math.nan] * 3, full_turn_angles(3), 5.0).filled_ranges().tolist() == [5.0] * 3
    assert Scan.full_turn([1.0, 2.0], 5.0).filled_ranges().tolist() == [1.0, 2.0]


def test_one_beam_out_of_three() -> None:
    scan = Scan.full_turn(np.arange(7.0), 9.0).take_every(3)
    assert scan.ranges.tolist() == [0.0, 3.0, 6.0]
    np.testing.assert_allclose(scan.angles, full_turn_angles(7)[::3])


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
        ("measured", lambda: Scan(np.ones(2), np.zeros(2), 5.0, np.array([True]))),
        ("too_close", lambda: Scan(np.ones(2), np.zeros(2), 5.0, too_close=np.array([True]))),
        ("zero", lambda: Scan.from_sensor([1.0], [0.0], 5.0, zero="to close")),  # type: ignore[arg-type]
        ("min_range", lambda: Scan.from_sensor([1.0], [0.0], 5.0, 5.0)),
        ("min_range", lambda: Scan.from_sensor([1.0], [0.0], 5.0, math.nan)),
        ("step", lambda: Scan.full_turn([1.0], 5.0).take_every(0)),
        ("beams", lambda: full_turn_angles(-1)),
    ],
)
def test_what_no_lidar_measures_is_named(argument: str, call: Any) -> None:
    with pytest.raises(ScanError) as error:
        call()
    assert error.value.argument == argument
