"""What one student sent to one exercise, in order, and what it comes to: pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from uuid import UUID

from graders.core.contract.outcomes import Blame, Outcome, blamed_on
from server.board.repository import Sent
from server.gradebook.standings import StandingTotals, compute_totals

FAILURES = frozenset(one.value for one in blamed_on(Blame.STUDENT))
#: Failures that have a behaviour: a program that runs, and answers wrongly.
BEHAVING = frozenset((Outcome.WRONG_ANSWER.value, Outcome.INVALID_OUTPUT.value, Outcome.RUNTIME_ERROR.value))

Pair = tuple[UUID, str]


@dataclass(frozen=True, slots=True)
class MisconceptionEpisode:
    """That a student had a misconception: in `attempts` attempts from the first with it to the first without it for
    good, None while they have it.

    `followed`: another attempt came after the first that had it; `improved`: and had more points.
    """

    account: UUID
    attempts: int | None
    followed: bool
    improved: bool


class Trail(tuple[Sent, ...]):
    """What one student sent to one exercise, in order, one attempt at least. What it comes to is reckoned once."""

    @cached_property
    def sums(self) -> StandingTotals:
        return compute_totals(self)

    @cached_property
    def had(self) -> Sequence[tuple[str, MisconceptionEpisode]]:
        return tuple(misconceptions(self))

    @cached_property
    def first_success(self) -> tuple[int, float] | None:
        return first_success(self)


Trails = Mapping[Pair, Trail]


def misconceptions(trail: Sequence[Sent]) -> Iterator[tuple[str, MisconceptionEpisode]]:
    """Each misconception that its author ever had there."""
    places: dict[str, list[int]] = {}
    for place, one in enumerate(trail):
        if one.diagnosis is not None:
            places.setdefault(one.diagnosis, []).append(place)
    for name, (first, *more) in places.items():
        last = more[-1] if more else first
        over = last < len(trail) - 1
        followed = first < len(trail) - 1
        improved = followed and trail[first + 1].score > trail[first].score
        yield name, MisconceptionEpisode(trail[first].account, last - first + 1 if over else None, followed, improved)


def first_success(trail: Sequence[Sent]) -> tuple[int, float] | None:
    """At which attempt, and in how many minutes from the first one."""
    for number, one in enumerate(trail, 1):
        if one.outcome == Outcome.OK:
            return number, (one.sent_at - trail[0].sent_at).total_seconds() / 60
    return None


def after_hints(trail: Sequence[Sent], starter: str | None, opens_after: Collection[int]) -> Iterator[tuple[int, bool]]:
    """After each number of different failures that opened a hint: whether the next attempt brought more points.

    Nothing of those that no attempt came after. `starter`: the digest of what fails without opening anything.
    """
    failed: set[str] = set()
    for one, following in pairwise(trail):
        if one.outcome in FAILURES and one.digest != starter and one.digest not in failed:
            failed.add(one.digest)
            if len(failed) in opens_after:
                yield len(failed), following.score > one.score


def unexplained(trail: Sequence[Sent]) -> bool:
    """Whether the latest attempt answers wrongly, and nothing names why."""
    return trail[-1].diagnosis is None and trail[-1].outcome in BEHAVING
