"""Calls and answers as arrays."""

from __future__ import annotations

import numpy as np
import pytest

from graders.core.contract.rows import Rows, as_rows


def test_calls_are_those_of_their_columns() -> None:
    poses, times = np.arange(6.0).reshape(2, 3), np.array([0.5, 1.5])
    calls = list(Rows(poses, times))
    assert [time for _, time in calls] == [0.5, 1.5]
    assert all(np.array_equal(pose, row) for (pose, _), row in zip(calls, poses, strict=True))


@pytest.mark.parametrize("kind", [np.int64, np.float32, np.bool_, np.complex128])
def test_other_numbers_than_floats_are_refused_and_stay_calls(kind: type[np.generic]) -> None:
    """Their bytes would be sent as those of floats."""
    with pytest.raises(TypeError, match="float64 is asked for"):
        Rows(np.ones(3), np.ones(3, kind))  # type: ignore[arg-type]
    calls = [(np.ones(3, kind),), (np.zeros(3, kind),)]
    assert as_rows(calls) is calls  # type: ignore[arg-type]
