"""Signatures of scans: invariant under a turn, equal to their definitions; candidates as brute force finds them."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from reference.loop_closure import (
    LoopClosureError,
    fourier_signature,
    histogram_signature,
    loop_candidates,
)

SCANS = arrays(np.float64, st.integers(1, 40), elements=st.floats(0.0, 12.0))


@given(SCANS, st.integers(-50, 50))
def test_signatures_ignore_the_heading(scan: Any, steps: int) -> None:
    turned = np.roll(scan, steps)
    np.testing.assert_allclose(fourier_signature(turned), fourier_signature(scan), atol=1e-9)
    np.testing.assert_array_equal(histogram_signature(turned, 12.0, 7), histogram_signature(scan, 12.0, 7))


@given(SCANS)
def test_the_amplitudes_are_those_of_the_definition(scan: Any) -> None:
    n = len(scan)
    terms = [[z * cmath.exp(-2j * math.pi * f * k / n) for k, z in enumerate(scan)] for f in range(n // 2 + 1)]
    np.testing.assert_allclose(fourier_signature(scan), [abs(sum(row)) for row in terms], atol=1e-8)


@given(SCANS)
def test_the_amplitudes_hold_the_energy_of_the_scan(scan: Any) -> None:
    """Parseval: every frequency but 0 and, for even n, the middle one counts twice."""
    n, power = len(scan), fourier_signature(scan) ** 2
    twice = 2.0 * power.sum() - power[0] - (power[-1] if n % 2 == 0 else 0.0)
    assert twice == pytest.approx(n * np.sum(scan**2), rel=1e-9, abs=1e-9)


@given(SCANS, st.integers(1, 20))
def test_the_histogram_counts_every_beam_in_its_box(scan: Any, bins: int) -> None:
    counts = histogram_signature(scan, 12.0, bins)
    edges = np.linspace(0.0, 12.0, bins + 1)
    inside = [int(sum(low <= z < high for z in scan)) for low, high in pairwise(edges)]
    inside[-1] += int(sum(z == 12.0 for z in scan))
    assert counts.shape == (bins,)
    assert counts.sum() == len(scan)
    # A distance within rounding of an edge may be counted on either side of it.
    edged = sum(bool(np.any(np.abs(z - edges) < 1e-9)) for z in scan)
    assert np.abs(counts - inside).sum() <= 2 * edged


@given(
    arrays(np.float64, st.tuples(st.integers(1, 30), st.integers(1, 5)), elements=st.floats(-10, 10)),
    st.data(),
    st.floats(0.0, 20.0),
    st.integers(1, 12),
)
def test_candidates_are_those_of_brute_force(rows: Any, data: Any, threshold: float, gap: int) -> None:
    i = data.draw(st.integers(0, len(rows) - 1))
    found = loop_candidates(rows, i, threshold, min_gap=gap)
    away = {j: math.dist(rows[j], rows[i]) for j in range(len(rows)) if i - j >= gap}
    sure = [j for j, d in away.items() if d < threshold - 1e-9]
    possible = [j for j, d in away.items() if d <= threshold + 1e-9]
    indices = found.indices.tolist()
    assert set(sure) <= set(indices) <= set(possible)
    assert indices == sorted(indices)
    np.testing.assert_allclose(found.distances, [away[j] for j in indices], atol=1e-12)


def test_the_gap_is_inclusive_and_the_beginning_has_no_candidate() -> None:
    same = np.zeros((24, 3))
    assert loop_candidates(same, 10, 0.0).indices.tolist() == [0]
    assert loop_candidates(same, 9, 0.0).indices.tolist() == []
    assert loop_candidates(same, 23, 0.0).indices.tolist() == list(range(14))


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("scan", lambda: fourier_signature([])),
        ("scan", lambda: fourier_signature([[1.0, 2.0]])),
        ("scan", lambda: fourier_signature([1.0, np.nan])),
        ("scan", lambda: histogram_signature([1.0, 13.0], 12.0, 3)),
        ("scan", lambda: histogram_signature([-1.0], 12.0, 3)),
        ("max_range", lambda: histogram_signature([1.0], 0.0, 3)),
        ("bins", lambda: histogram_signature([1.0], 12.0, 0)),
        ("signatures", lambda: loop_candidates([1.0, 2.0], 0, 1.0)),
        ("signatures", lambda: loop_candidates([[np.inf]], 0, 1.0)),
        ("i", lambda: loop_candidates([[1.0]], 1, 1.0)),
        ("i", lambda: loop_candidates([[1.0]], -1, 1.0)),
        ("threshold", lambda: loop_candidates([[1.0]], 0, np.nan)),
        ("min_gap", lambda: loop_candidates([[1.0]], 0, 1.0, min_gap=0)),
    ],
)
def test_degenerate_input_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(LoopClosureError) as caught:
        call()
    assert caught.value.argument == argument
