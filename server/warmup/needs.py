"""What most students of a class are to see again, from the schedules of all of them. Pure."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from server.board.schemas import FEWEST_TO_PROJECT
from server.recall.scheduling import Review, compute_schedule
from server.recall.service import RecallCandidate


@dataclass(frozen=True)
class StudentRecallHistory:
    """What one student confused: the reviews of each subject, the misconceptions met, and the subjects in which one
    is not mended yet."""

    reviews: Mapping[str, Sequence[Review]]
    confused: Mapping[str, Sequence[RecallCandidate]]
    unmended: Collection[str]


@dataclass(frozen=True)
class SubjectReviewNeed:
    """A subject that `students_to_review` of a class are to see again, of `students_confused`; the misconceptions that
    they met, the most common first."""

    subject: str
    students_to_review: int
    students_confused: int
    candidates: tuple[RecallCandidate, ...]


def rank_subjects_to_review(
    memories: Mapping[UUID, StudentRecallHistory], now: datetime
) -> Sequence[SubjectReviewNeed]:
    """Return the subjects that some are to see again, those of most students first.

    A student is to see a subject again when it is due, or while their mistake is not mended. Subjects that fewer than
    `FEWEST_TO_PROJECT` students met are left out: a class could guess whose they are.
    """
    to_see: Counter[str] = Counter()
    met: Counter[str] = Counter()
    candidates: dict[str, Counter[RecallCandidate]] = defaultdict(Counter)
    for memory in memories.values():
        for subject in {*memory.reviews, *memory.unmended}:
            met[subject] += 1
            to_see[subject] += (
                subject in memory.unmended or compute_schedule(memory.reviews[subject], now).due_at <= now
            )
            candidates[subject].update(dict.fromkeys(memory.confused.get(subject, ()), 1))
    needs = [
        SubjectReviewNeed(subject, to_see[subject], count, _most_common_first(candidates[subject]))
        for subject, count in met.items()
        if to_see[subject] and count >= FEWEST_TO_PROJECT
    ]
    return sorted(needs, key=lambda need: (-need.students_to_review, -need.students_confused, need.subject))


def _most_common_first(counts: Counter[RecallCandidate]) -> tuple[RecallCandidate, ...]:
    return tuple(
        sorted(counts, key=lambda candidate: (-counts[candidate], candidate.exercise, candidate.misconception))
    )
