"""Re-enactments that are kept give the observations of fresh ones, and the same verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from graders.core.code.diagnosis import are_same_results
from graders.core.code.grading import FRESH_REENACTOR, CodeGrader
from graders.core.code.reenacting import Reenactor
from graders.core.code.runner import Observation
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from tests.support.quick import some
from tests.support.reenactments import Remembering
from tests.support.shipped import CODE

GRADERS = pytest.mark.parametrize("name", ["l20/poses", "l20/kabsch", "l20/reechantillonnage"])


def same(one: Sequence[Observation], other: Sequence[Observation]) -> bool:
    return len(one) == len(other) and all(
        (a.check, a.index, a.function) == (b.check, b.index, b.function) and are_same_results(a, b)
        for a, b in zip(one, other, strict=True)
    )


@GRADERS
def test_a_reenactment_is_the_same_in_whatever_pieces_it_was_made(name: str) -> None:
    grader, memory = CODE[name], Remembering()
    given: dict[str, Any] = {"checks": grader.checks, "kit": grader.kit(stream(3, "kit")), "seed": 3}
    for misconception in some(grader.misconceptions[:6]):
        fresh = FRESH_REENACTOR.reenact(misconception, **given).observe()
        assert fresh
        for count in (1, len(fresh) // 2, len(fresh) + 1, 1):

            def enough(seen: Sequence[Observation], count: int = count) -> bool:
                return len(seen) >= count

            part = FRESH_REENACTOR.reenact(misconception, **given).observe(enough)
            assert same(part, fresh[: len(part)])
            assert same(memory.reenact(misconception, **given).observe(enough), part)
        assert same(memory.reenact(misconception, **given).observe(), fresh)


@GRADERS
def test_verdicts_are_the_same(name: str) -> None:
    def verdicts(reenactor: Reenactor) -> list[Any]:
        grader: CodeGrader = replace(CODE[name], reenactor=reenactor)
        graded = (
            grader.grade(mistake.source.encode(), LOCAL, seed=5, version="v") for mistake in grader.misconceptions[::6]
        )
        return [replace(grading.verdict, timings={}).to_json() for grading in graded]

    assert verdicts(Remembering()) == verdicts(FRESH_REENACTOR)
