"""Statistics of attempts, case by case."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from uuid import UUID

import pytest

from graders.core.contract.outcomes import Outcome
from server.board.attempts import (
    MisconceptionEpisode,
    find_first_success,
    find_misconception_episodes,
    is_latest_failure_unexplained,
    iter_improvements_after_hints,
)
from server.board.insights import ScoreSum, item_rest_correlation
from server.gradebook.histories import Attempts, GradedAttempt
from server.gradebook.schemas import HINT_OPENS_AFTER

NOW = datetime(2026, 11, 23, 10, 0, tzinfo=UTC)
ADA = UUID(int=1)
EXERCISE = "l20/poses"


def attempts_of(*attempts: str) -> Attempts:
    """Each `minutes ago, points[, code[, misconception]]`; 20 points are a success."""
    found = []
    for number, text in enumerate(attempts):
        ago, points, code, name = [*(part.strip() for part in text.split(",")), "", ""][:4]
        outcome = Outcome.OK if points == "20" else Outcome.WRONG_ANSWER
        sent_at = NOW - timedelta(minutes=float(ago))
        score, digest = int(points) / 20, code or f"#{number}"
        id, grading = UUID(int=number), UUID(int=1000 + number)
        found.append(GradedAttempt(id, sent_at, score, ADA, EXERCISE, digest, outcome.value, name or None, grading))
    return tuple(found)


@pytest.mark.parametrize(
    ("attempts", "expected"),
    [
        (["9,5,,a"], {"a": MisconceptionEpisode(ADA, None, False, False)}),
        (["9,5,,a", "8,5,,a", "7,6"], {"a": MisconceptionEpisode(ADA, 2, True, False)}),
        (["9,5,,a", "8,6", "7,5,,a", "6,20"], {"a": MisconceptionEpisode(ADA, 3, True, True)}),
        (
            ["9,5,,a", "8,6,,b"],
            {"a": MisconceptionEpisode(ADA, 1, True, True), "b": MisconceptionEpisode(ADA, None, False, False)},
        ),
        (["9,5", "8,20"], {}),
    ],
)
def test_misconception_episodes(attempts: list[str], expected: dict[str, MisconceptionEpisode]) -> None:
    assert dict(find_misconception_episodes(attempts_of(*attempts))) == expected


def test_first_success_has_number_and_minutes() -> None:
    assert find_first_success(attempts_of("30,0", "20,20", "10,0", "5,20")) == (2, 10.0)
    assert find_first_success(attempts_of("30,0")) is None


def test_improvements_are_counted_after_hints_that_an_attempt_followed() -> None:
    codes = attempts_of("9,0,start", "8,0,a", "7,0,a", "6,5,b", "5,4,c", "4,9,d")
    assert list(iter_improvements_after_hints(codes, "start", HINT_OPENS_AFTER)) == [(1, False), (2, False)]
    assert list(iter_improvements_after_hints(attempts_of("9,0,a", "8,5,b", "7,20,c"), None, HINT_OPENS_AFTER)) == [
        (1, True),
        (2, True),
    ]


def test_running_failures_without_misconception_are_unexplained() -> None:
    assert is_latest_failure_unexplained(attempts_of("9,5"))
    assert not is_latest_failure_unexplained(attempts_of("9,5,,a"))
    assert not is_latest_failure_unexplained(attempts_of("9,20"))
    (one,) = attempts_of("9,5")
    assert not is_latest_failure_unexplained((replace(one, outcome=Outcome.SYNTAX_ERROR.value),)), (
        "it says of itself what it is"
    )


def test_item_rest_correlation_is_hidden_under_twenty() -> None:
    people = [UUID(int=number) for number in range(20)]
    rising = {one: number / 20 for number, one in enumerate(people)}
    falling = {one: 1 - score for one, score in rising.items()}
    flat = dict.fromkeys(people, 0.5)

    def beside(*others: dict[UUID, float]) -> tuple[float | None, int]:
        scores = [rising, *others]
        there = {one: [score[one] for score in scores if one in score] for one in people}
        return item_rest_correlation(rising, {one: ScoreSum(sum(found), len(found)) for one, found in there.items()})

    assert beside(rising, rising) == (1.0, 20)
    assert beside(falling) == (-1.0, 20)
    assert beside(flat) == (None, 20), "where nothing varies, nothing is told"
    assert beside(dict(list(rising.items())[:19])) == (None, 19)
    assert beside() == (None, 0)
