"""Every registered reader of strangers' bytes takes linear time of any shape of text, within a bound."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Iterator

import pytest

from graders.core.answers.numbers import NotANumberError
from server.base.errors import ServiceError
from server.sandbox.faults import ProgramFault
from tests.support.readers import READERS, Reader

#: Of four times the text, how many times the processor time at most: 4 where it is linear, 16 where it is quadratic.
MAX_RATIO = 6.0
#: Seconds of processor time below which nothing is compared, and which no text may take at its longest.
FLOOR, CEILING = 0.0025, 2.0
TRIES = 6
SAMPLE = 16 * 1024  # characters of the longer of the two texts that are compared
REFUSALS = (ValueError, RecursionError, ServiceError, ProgramFault, NotANumberError)


def seconds(reader: Reader, text: str) -> float:
    began = time.process_time()
    with contextlib.suppress(*REFUSALS):
        reader.read(text)
    return time.process_time() - began


def complaints(reader: Reader) -> Iterator[str]:
    """Compare only what takes some time; measure again what seems to be too slow: only the least time tells."""
    large = min(reader.longest, SAMPLE)
    for name, make in reader.shapes.items():
        whole, part = make(large), make(large // 4)
        slow = seconds(reader, whole)
        if slow <= FLOOR:
            continue
        fast = seconds(reader, part)
        for _ in range(TRIES):
            if slow <= MAX_RATIO * max(fast, FLOOR / 4):
                break
            slow, fast = min(slow, seconds(reader, whole)), min(fast, seconds(reader, part))
        else:
            yield f"{name}: {fast:.4f} s, then {slow:.4f} s of four times the text"
            continue
        growth = max(4.0, slow / max(fast, FLOOR / 4))
        expected = slow * growth ** math.log(reader.longest / large, 4)
        if expected > CEILING / 2 and all(seconds(reader, make(reader.longest)) > CEILING for _ in range(2)):
            yield f"{name}: more than {CEILING} s of {reader.longest} characters"


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_a_reader_takes_linear_time_of_any_shape(reader: Reader) -> None:
    seconds(reader, "1")  # what is loaded at first is no matter of the text
    assert not list(complaints(reader))


def test_a_reader_that_takes_the_square_is_told() -> None:
    def squared(text: str) -> int:
        return sum(text[:end].count("a") for end in range(len(text)))

    told = list(complaints(Reader("squared", squared, SAMPLE, {"one word": lambda size: "a" * size})))
    assert [line.partition(":")[0] for line in told] == ["one word"]
