"""One table of outcomes: its rows are the members of the enum, which is what these tests walk."""

from __future__ import annotations

import json
from collections import Counter
from itertools import permutations
from typing import get_args

import pytest

from graders.core.contract.findings import Finding, make_verdict
from graders.core.contract.outcomes import Blame, Kind, Outcome, most_telling_outcome, outcomes_blamed_on
from graders.core.contract.verdict import CheckResult
from server.api.schemas import VerdictOut
from server.cli.report import CANNOT, FULL_MARKS, NOT_FULL, exit_status_of_verdict, render_verdict
from server.sandbox import FaultKind
from server.web import verdicts

FAILURES = [outcome for outcome in Outcome if outcome is not Outcome.OK]


def ended(*causes: Outcome) -> list[Finding]:
    """One finding for each cause; the checks share the 20 points."""
    most = 20 / len(causes)
    return [
        Finding(CheckResult(f"c{k}", "t", cause is Outcome.OK, most * (cause is Outcome.OK), most), cause)
        for k, cause in enumerate(causes)
    ]


@pytest.mark.parametrize("outcome", Outcome)
def test_an_outcome_has_all_of_its_words(outcome: Outcome) -> None:
    assert outcome.brief
    for kind in get_args(Kind):
        wording = outcome.wording(kind)
        assert wording.title
        assert wording.sentence.endswith((".", "!"))
        assert verdicts.outcome_in_words(outcome.value, kind) == wording.title


@pytest.mark.parametrize("worst", [Outcome.TIMEOUT, Outcome.RUNTIME_ERROR])
def test_what_is_said_above_is_true_beside_a_first_check_that_failed_otherwise(worst: Outcome) -> None:
    """The first check that failed stands open below: « cherchez une boucle sans fin » contradicted its wrong value."""
    view = verdicts.build_verdict_view(
        make_verdict("l20/x", "v", 1, ended(Outcome.WRONG_ANSWER, worst), None, timings={}), ""
    )
    assert view.title == worst.wording().title
    assert "une vérification au moins" in view.sentence.lower()
    assert "boucle" not in view.sentence


def test_no_two_outcomes_are_told_alike() -> None:
    assert max(Counter(outcome.brief for outcome in Outcome).values()) == 1
    assert max(Counter(outcome.wording().title for outcome in Outcome).values()) == 1
    assert sorted(outcome.rank for outcome in Outcome) == list(range(len(Outcome)))


def test_an_outcome_without_a_row_cannot_be_made() -> None:
    with pytest.raises(TypeError, match="has no row"):
        Outcome.__new_member__(Outcome, "melted")  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="melted"):
        Outcome("melted")


@pytest.mark.parametrize("cause", FAILURES)
def test_a_check_that_fails_for_any_cause_is_never_full_marks(cause: Outcome) -> None:
    verdict = make_verdict("l20/x", "v", 1, ended(cause, Outcome.OK), None, timings={})
    assert verdict.outcome is cause
    assert verdict.score == 0.5
    assert exit_status_of_verdict(verdict) != FULL_MARKS


def test_what_names_a_submission_depends_on_no_order_and_ours_wins_over_everything() -> None:
    for pair in permutations(Outcome, 2):
        assert most_telling_outcome(pair) is most_telling_outcome(pair[::-1])
    for other in Outcome:
        assert most_telling_outcome([other, Outcome.INTERNAL_ERROR]) is Outcome.INTERNAL_ERROR
        assert most_telling_outcome([Outcome.OK, other]) is other
    with pytest.raises(ValueError, match="empty"):
        most_telling_outcome([])


def test_a_finding_says_the_same_as_its_line() -> None:
    with pytest.raises(ValueError, match="ends as"):
        Finding(CheckResult("a", "A", True, 20, 20), Outcome.TIMEOUT)
    with pytest.raises(ValueError, match="ends as"):
        Finding(CheckResult("a", "A", False, 0, 20))


def test_everyone_answers_for_something_and_only_what_is_ours_does_not_count() -> None:
    assert {outcome for blame in Blame for outcome in outcomes_blamed_on(blame)} == set(Outcome)
    assert outcomes_blamed_on(Blame.NOBODY) == (Outcome.OK,)
    assert [outcome for outcome in Outcome if not outcome.counts] == list(outcomes_blamed_on(Blame.OURS))


@pytest.mark.parametrize("outcome", Outcome)
def test_the_command_line_and_the_api_know_it(outcome: Outcome) -> None:
    verdict = make_verdict("l20/x", "v", 1, ended(outcome), None, timings={})
    status = {Blame.NOBODY: FULL_MARKS, Blame.STUDENT: NOT_FULL, Blame.OURS: CANNOT}[outcome.blame]
    assert exit_status_of_verdict(verdict) == status
    assert (outcome.brief in render_verdict(verdict)) == outcome.counts
    assert VerdictOut.model_validate_json(json.dumps(verdict.to_json())).outcome is outcome


def test_every_fault_of_a_program_is_an_outcome_of_the_student() -> None:
    assert {Outcome(kind.value).blame for kind in FaultKind} == {Blame.STUDENT}
