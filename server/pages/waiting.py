"""The state of a waiting submission, as its page receives it whenever it may have changed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from uuid import UUID

from server.database import Database
from server.gradebook import early_verdicts
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.submissions.models import SubmissionState
from server.submissions.service import GradingProgress, SubmissionService
from server.web.words import count_with_noun


def describe_waiting(place: GradingProgress) -> str:
    """Describe the state of a submission without a verdict."""
    if place.state is SubmissionState.running:
        return "Correction en cours…"
    if place.position is None:
        return ""
    if place.notice is not None:
        return place.notice
    before = place.position - 1
    return (
        f"En attente : {count_with_noun(before, 'envoi passe', 'envois passent')} avant le vôtre."
        if before
        else ("En attente : votre envoi est le prochain.")
    )


@dataclass(frozen=True)
class WaitingState:
    """The state that the page of a waiting submission receives."""

    status: str
    text: str
    settles_in: float | None = field(default=None, compare=False)
    early: bool = False

    @property
    def done(self) -> bool:
        return self.status == SubmissionState.done

    def to_json(self) -> dict[str, Any]:
        """Return the members of its event; `held` and `early`: the page shows what it has at once."""
        members: dict[str, Any] = {"status": self.status, "text": self.text}
        if self.early:
            members["early"] = True
        return members if self.settles_in is None else {**members, "held": True}


def withheld_state(attempt: Attempt) -> WaitingState:
    """Return the state of a withheld attempt: it is watched for a file that does not run, for a fixed time."""
    settles_in = attempt.settles_in
    status = SubmissionState.running if settles_in else SubmissionState.done
    return WaitingState(status, attempt.held_text, settles_in)


@dataclass
class WatchedSubmission:
    """A submission, for whoever may see it: once it has been seen to wait, its place alone is asked for until its job
    is over. Hundreds may look at the same time."""

    account: Account | None
    store: SubmissionService
    database: Database
    submission: UUID
    waits: bool = False

    def read_state(self) -> WaitingState:
        """Raises NotFound."""
        with self.database.read() as db:
            place = self.store.progress_while_waiting(db, self.submission) if self.waits else None
            if place is None:
                attempt = gradebook.find_attempt(db, self.account, self.submission)
                if attempt.held:
                    return withheld_state(attempt)
                place = self.store.progress(db, attempt.submission)
            self.waits = place.state is not SubmissionState.done
            early = place.state is SubmissionState.running and early_verdicts.has_early_verdict(db, self.submission)
            return WaitingState(place.state, describe_waiting(place), early=early)
