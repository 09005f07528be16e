"""Our own programs, run in this process."""

from __future__ import annotations

import warnings

import numpy as np

from graders.core.contract.local import LocalProgram
from graders.core.contract.program import KitSettings

DIVIDES = b"def f(x):\n    return 1.0 / x\n"


def test_nobody_is_warned_of_what_a_known_mistake_divides_by() -> None:
    """It is among what the service says to its administrator otherwise."""
    program = LocalProgram(DIVIDES, KitSettings("l20"))
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        assert program.call("f", np.array([0.0, 2.0])).value.tolist() == [float("inf"), 0.5]
        np.array([1.0]) / np.array([0.0])
    assert [str(one.message) for one in heard] == ["divide by zero encountered in divide"], "our own is told as ever"
