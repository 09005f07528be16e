"""CARMEN logs: what their lines hold, the odometry of corrected ones, and the faults that are named by their line."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from reference.formats.carmen import LogError, parse_flaser
from reference.se2 import compose, relative

Floats = NDArray[np.float64]
LINE = "FLASER 4 1.0 2.5 81.83 3 0.1 0.2 0.3 0.4 0.5 0.6 12.5 pippo 12.5"
ODOM = "ODOM 0 0 0 0 0 0 1 pippo 1"


def odom(pose: Floats) -> str:
    return f"ODOM {pose[0]!r} {pose[1]!r} {pose[2]!r} 0 0 0 1 pippo 1".replace("np.float64(", "").replace(")", "")


def corrected_log(truth: Floats, wheels: Floats, parts: int) -> str:
    """A log as a mapper writes it: true poses at the scans, and odometry that carries on from each of them."""
    lines = []
    for k, pose in enumerate(truth):
        x, y, theta = pose.tolist()
        lines.append(f"FLASER 1 {1 + k} {x!r} {y!r} {theta!r} {x!r} {y!r} {theta!r} {k} pippo {k}")
        step = wheels[k] if k < len(wheels) else np.zeros(3)
        lines += [odom(compose(pose, [*(share * step[:2]), share * step[2]])) for share in np.linspace(0, 1, parts)]
    return "\n".join(lines)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 8), parts=st.integers(2, 5))
def test_a_corrected_log_gives_its_wheels_back(seed: int, n: int, parts: int) -> None:
    """Whatever the corrected poses are, the odometry is that of the steps that the ODOM lines make."""
    rng = np.random.default_rng(seed)
    truth, wheels = rng.uniform(-3, 3, (n, 3)), rng.uniform(-1, 1, (n - 1, 3))
    log = parse_flaser(corrected_log(truth, wheels, parts), 50.0)
    found = log.wheel_poses()
    assert found.shape == (n, 3)
    np.testing.assert_array_equal(found[0], 0.0)
    np.testing.assert_allclose(relative(found[:-1], found[1:]), wheels, atol=1e-9)
    np.testing.assert_allclose(log.T_odom_robot, truth, atol=1e-12)


@pytest.mark.parametrize(
    "line",
    [
        "ODOM 0 0",
        "ODOM 0 0 x 0 0 0 1 pippo 1",
        "ODOM 0 0 nan 0 0 0 1 pippo 1",
        "ODOM 0 0 0 0 0 0 1 pippo 1 2 3",
        "FLASER",
        "FLASER 2.5 1 2 0 0 0 0 0 0 1 pippo 1",
        "FLASER -1",
        "FLASER inf",
        LINE[: len(LINE) // 2],
        LINE.replace("0.6", "inf"),
    ],
)
def test_a_torn_line_is_named(line: str) -> None:
    with pytest.raises(LogError, match="line 3"):
        parse_flaser(f"# a log\n{ODOM}\n{line}\n{ODOM}", 50.0)


def test_a_scan_given_twice_is_named_and_one_like_it_is_not() -> None:
    with pytest.raises(LogError, match="line 4 repeats the scan of line 2"):
        parse_flaser(f"{ODOM}\n{LINE}\n{ODOM}\n{LINE}", 50.0)
    assert len(parse_flaser(f"{LINE}\n{LINE.replace('12.5', '12.7')}", 50.0)) == 2


@pytest.mark.parametrize("stamp", ["12.5", "12.4", "-1"])
def test_dates_out_of_order_are_named_where_an_order_is_asked_for(stamp: str) -> None:
    log = parse_flaser(f"{LINE}\n{ODOM}\n{LINE.replace('12.5', stamp).replace('FLASER 4 1.0', 'FLASER 4 1.1')}", 50.0)
    with pytest.raises(LogError, match=r"line 3 is dated .* line 1"):
        log.increasing_times()
    sorted_log = parse_flaser(f"{LINE}\n{LINE.replace('12.5', '13')}", 50.0)
    assert sorted_log.increasing_times().tolist() == [12.5, 13.0]


def test_a_log_without_odometry_names_the_scan_after_which_it_is_missing() -> None:
    second = LINE.replace("12.5", "13")
    with pytest.raises(LogError, match="follows the scan of line 3"):
        parse_flaser(f"{LINE}\n{ODOM}\n{second}\n{LINE.replace('12.5', '14')}", 50.0).wheel_poses()
    assert parse_flaser(LINE, 50.0).wheel_poses().tolist() == [[0, 0, 0]]


def test_readings_keep_their_three_kinds() -> None:
    line = "FLASER 5 0 0.05 nan 60 2 0 0 0 0 0 0 1 pippo 1"
    scan = parse_flaser(line, 50.0, min_range=0.1, zero="too close").scans[0]
    assert scan.too_close.tolist() == [True, True, False, False, False]
    assert scan.measured.tolist() == [False, False, False, True, True]
    assert math.isclose(scan.ranges[4], 2.0)


def test_codes_of_faults_are_no_measurements() -> None:
    """8183 says that nothing was seen up to there, 8187 and 8191 that the lidar was dazzled or does not know."""
    scan = parse_flaser("FLASER 5 81.83 81.87 81.91 81.92 2 0 0 0 0 0 0 1 pippo 1", 50.0).scans[0]
    assert scan.measured.tolist() == [True, False, False, True, True]
    assert scan.hit_mask.tolist() == [False, False, False, False, True]


def test_the_odometry_of_the_intel_log(dataset: Callable[[str], bytes]) -> None:
    """It turns 0.04 rad too far to the right a step; and four of the log's dates are out of order."""
    log = parse_flaser(dataset("laser/intel.gfs.log"), 40.0)
    wheels = log.wheel_poses()
    error = relative(wheels[:-1], wheels[1:]) - relative(log.T_odom_robot[:-1], log.T_odom_robot[1:])
    turns = np.arctan2(np.sin(error[:, 2]), np.cos(error[:, 2]))
    assert turns[:120].mean() == pytest.approx(-0.040, abs=0.002)
    assert turns[:120].std() == pytest.approx(0.040, abs=0.002)
    with pytest.raises(LogError, match="is dated"):
        log.increasing_times()


@pytest.mark.parametrize(("text", "lines"), [("", 0), ("# a log\nODOM 0 0 0 0 0 0 1 pippo 1\nRAWLASER1 0\n", 3)])
def test_a_log_without_a_scan_is_refused_with_its_last_line(text: str, lines: int) -> None:
    with pytest.raises(LogError, match=f"ends at line {lines} without any FLASER line"):
        parse_flaser(text, 50.0)
