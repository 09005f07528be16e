"""Replays that are kept give the observations of fresh ones, and the same verdicts."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import pytest

from graders.core.code import grading
from graders.core.code.bench import Observation
from graders.core.code.diagnosis import agree
from graders.core.contract.program import local_launcher
from graders.l20.kabsch.grader import GRADER as KABSCH
from graders.l20.poses.grader import GRADER as POSES
from graders.l20.reechantillonnage.grader import GRADER as RESAMPLING
from tests.graders.replays import Replays

FRESH = grading.observe
GRADERS = pytest.mark.parametrize("grader", [POSES, KABSCH, RESAMPLING], ids=lambda grader: grader.exercise)


def same(one: Sequence[Observation], other: Sequence[Observation]) -> bool:
    return len(one) == len(other) and all(
        (a.check, a.index, a.function) == (b.check, b.index, b.function) and agree(a, b)
        for a, b in zip(one, other, strict=True)
    )


@GRADERS
def test_a_replay_is_the_same_in_whatever_pieces_it_was_made(grader: Any) -> None:
    replays, kit = Replays(), grader.kit(grading.stream(3, "kit"))
    for misconception in grader.misconceptions[:6]:
        fresh = FRESH(grader, misconception, kit, 3)
        assert fresh
        for count in (1, len(fresh) // 2, len(fresh) + 1, 1):

            def enough(seen: Sequence[Observation], count: int = count) -> bool:
                return len(seen) >= count

            part = FRESH(grader, misconception, kit, 3, enough)
            assert same(replays.observe(grader, misconception, kit, 3, enough), part)
        assert same(replays.observe(grader, misconception, kit, 3), fresh)


@GRADERS
def test_verdicts_are_the_same(grader: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def verdicts() -> list[Any]:
        return [
            dataclasses.replace(
                grading.grade(grader, local_launcher(one.source), seed=5, version="v").verdict, timings={}
            ).to_json()
            for one in grader.misconceptions[::3]
        ]

    monkeypatch.setattr(grading, "observe", FRESH)
    fresh = verdicts()
    monkeypatch.setattr(grading, "observe", Replays().observe)
    assert verdicts() == fresh
