"""What an attempt fails at, where its mistake has no name."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from server.gradebook import repository

#: Outcomes of a file that does not run: no check says more.
OF_THE_FILE = frozenset((Outcome.SYNTAX_ERROR, Outcome.IMPORT_ERROR))


class FailedCheck(NamedTuple):
    """The first check that an attempt fails, by its title, and how; `check` is empty where the file does not run."""

    outcome: Outcome
    check: str


def find_first_failed_check(verdict: Verdict) -> FailedCheck:
    """Return what the verdict of a wrong attempt says first."""
    failed = [check for check in verdict.checks if not check.passed and not check.neutral]
    if verdict.outcome in OF_THE_FILE or not failed:
        return FailedCheck(verdict.outcome, "")
    first = next((check for check in failed if check.repeats is None), failed[0])
    return FailedCheck(first.cause or Outcome.WRONG_ANSWER, first.title)


def load_first_failed_checks(db: Session, gradings: Collection[UUID]) -> Mapping[UUID, FailedCheck]:
    """Return what the attempts with these gradings, all of them wrong, fail at."""
    verdicts = repository.load_verdicts(db, gradings) if gradings else {}
    return {grading: find_first_failed_check(Verdict.from_json(verdict)) for grading, verdict in verdicts.items()}
