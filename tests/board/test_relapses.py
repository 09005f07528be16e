"""Whether what was asked again is rarer later: counted on simulated students whose chances are known."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from uuid import UUID, uuid4

import numpy as np
import pytest

from server.board.relapses import FEWEST_CASES, RelapseStats, count_relapses
from server.course import Course
from server.gradebook.histories import Attempts, GradedAttempt
from server.recall.models import QuestionKind, RecallAnswer

START = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)
POSES, SLAM, FAMILY = "l20/poses", "l20/slam_graphe", "angle_non_ramene"
MET, AGAIN = "angle_jamais_ramene", "angle_entre_0_et_2pi"


def attempt(account: UUID, exercise: str, day: float, score: float, diagnosis: str | None) -> GradedAttempt:
    return GradedAttempt(
        id=uuid4(), sent_at=START + timedelta(days=day), score=score, account_id=account, exercise=exercise,
        digest="d", outcome="ok" if score == 1 else "wrong_answer", diagnosis=diagnosis, grading_id=uuid4(),
    )  # fmt: skip


def answer(account: UUID, day: float, subject: str = FAMILY) -> RecallAnswer:
    return RecallAnswer(
        account_id=account, subject=subject, kind=QuestionKind.hunt, exercise=POSES, misconception=MET, is_right=True,
        answered_at=START + timedelta(days=day),
    )  # fmt: skip


def simulate(course: Course, students: int, seed: int = 0) -> tuple[RelapseStats, list[int]]:
    """Half of the students are asked in between, who then make it again a fifth of the time; the others, half."""
    rng, attempts, answers, again = np.random.default_rng(seed), dict[tuple[UUID, str], Attempts](), [], [0, 0]
    for number in range(students):
        account, asked = uuid4(), number % 2 == 0
        relapses = bool(rng.random() < (0.2 if asked else 0.5))
        attempts[account, POSES] = [attempt(account, POSES, 0, 0.4, MET), attempt(account, POSES, 1, 1.0, None)]
        first = attempt(account, SLAM, 9, 0.5, AGAIN if relapses else None)
        attempts[account, SLAM] = [first, attempt(account, SLAM, 10, 1.0, None)]
        answers += [answer(account, 5)] if asked else [answer(account, 12), answer(account, 5, "repere")]
        again[0 if asked else 1] += relapses
    return count_relapses(course, attempts, answers), again


def test_the_cases_are_those_of_the_simulation_and_their_shares_its_chances(course: Course) -> None:
    stats, again = simulate(course, 800)
    assert (stats.asked, stats.unasked) == (400, 400)
    assert [stats.asked_again, stats.unasked_again] == again
    assert stats.relapse_shares is not None
    assert stats.relapse_shares[0] == pytest.approx(0.2, abs=0.06)
    assert stats.relapse_shares[1] == pytest.approx(0.5, abs=0.08)


def test_no_share_is_told_of_fewer_than_twenty_cases(course: Course) -> None:
    assert simulate(course, 2 * FEWEST_CASES - 1)[0].relapse_shares is None
    assert simulate(course, 2 * FEWEST_CASES)[0].relapse_shares is not None


def test_what_is_not_mended_or_was_begun_before_is_no_case(course: Course) -> None:
    account = uuid4()
    wrong, right = attempt(account, POSES, 0, 0.4, MET), attempt(account, POSES, 1, 1.0, None)
    before, after = attempt(account, SLAM, 0.5, 0.5, AGAIN), attempt(account, SLAM, 9, 0.5, AGAIN)
    for poses, slam in (([wrong], [after]), ([wrong, right], [before, after]), ([right], [after])):
        stats = count_relapses(course, {(account, POSES): poses, (account, SLAM): slam}, [])
        assert (stats.asked, stats.unasked) == (0, 0)
