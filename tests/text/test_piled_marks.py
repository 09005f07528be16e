"""Thousands of marks on one letter take nobody's time: they are cut in texts, and refused in programs."""

import time
from collections.abc import Callable
from typing import Any

import pytest

from graders.typography import MAX_MARKS, limit_marks, unaccented
from server.base.errors import Invalid
from server.classes.folding import normalise_name
from server.identity.logins import normalise_login
from server.sandbox.faults import ProgramFault
from server.sandbox.policy import Policy
from server.sandbox.sources import require_text
from server.steps.calls import parse_call
from server.text.lines import normalise_line

#: Four classes of marks, which Unicode puts in order one by one.
PILE = "\u0327\u0301\u0323\u0308"


def test_marks_that_a_language_writes_stay() -> None:
    for text in ("é", "Nguyễn", "e\u0323\u0302\u0301", "שָׁלוֹם", "a" + "\u0301" * MAX_MARKS, "ascii"):
        assert limit_marks(text) == text
    assert limit_marks("a" + "\u0301" * 500 + "b") == "a" + "\u0301" * MAX_MARKS + "b"


@pytest.mark.parametrize("read", [normalise_line, unaccented, normalise_name, normalise_login])
def test_reading_them_takes_linear_time(read: Callable[[str], Any]) -> None:
    def seconds(count: int) -> float:
        best = float("inf")
        for _ in range(3):
            began = time.process_time()
            read("a" + PILE * count)
            best = min(best, time.process_time() - began)
        return best

    assert seconds(16_000) <= 8 * max(seconds(4_000), 0.004)


def test_a_program_that_holds_them_is_refused_with_its_line() -> None:
    require_text("é = 1  # e\u0301\n".encode(), Policy())
    with pytest.raises(ProgramFault, match="plus de 30 accents") as refused:
        require_text(f"x = 1\na{PILE * 8} = 2\n".encode(), Policy())
    assert refused.value.line == 2
    with pytest.raises(Invalid, match="trop d’accents"):
        parse_call(f"f(a{PILE * 8})")
