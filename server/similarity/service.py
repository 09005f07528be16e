"""Comparison of the codes of an assignment."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.assignments.models import Assignment
from server.assignments.team_rules import TeamPlace
from server.base.errors import Invalid, Overloaded
from server.base.processes import bare_environment
from server.course import Course, Exercise
from server.similarity import repository
from server.similarity.compare import CPU_SECONDS, MAX_CODES

BUSY = "Une autre comparaison est en cours : réessayez dans quelques secondes."
TOO_MANY = f"Il y a trop de copies pour les comparer : {MAX_CODES} au plus."
FAILED = "Ces copies n’ont pas pu être comparées : l’une d’elles est trop longue ou trop étrange."
NO_CODE = "Cet exercice ne demande pas de code : il n’y a rien à comparer."
_comparing = threading.Lock()


@dataclass(frozen=True)
class ComparedCopy:
    """A student's submitted code."""

    student: UUID
    submission: UUID
    code: str


@dataclass(frozen=True)
class SimilarPair:
    """Two copies, the part of each one's own code that is in the other, and the lines, from 1, where it stands."""

    first: ComparedCopy
    second: ComparedCopy
    shares: tuple[float, float]
    lines: tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True)
class CopyComparison:
    """Pairs that look alike, the most alike first; none where the exercise is `too_short` to tell."""

    compared: int
    too_short: bool
    pairs: tuple[SimilarPair, ...]


def load_best_copies(db: Session, assignment: Assignment, exercise: Exercise) -> Sequence[ComparedCopy]:
    """Each student's best attempt while the assignment was open. Raises Invalid where there are too many."""
    if exercise.answers is not None:
        raise Invalid(NO_CODE)
    rows = repository.load_best_attempt_codes(
        db,
        assignment.class_id,
        exercise.id,
        assignment.opens_at,
        assignment.closes_at,
        most=MAX_CODES + 1,
    )
    if len(rows) > MAX_CODES:
        raise Invalid(TOO_MANY)
    return [ComparedCopy(student, name, source.decode("utf-8-sig", errors="replace")) for student, name, source in rows]


def compare_copies(course: Course, exercise: Exercise, sent: Sequence[ComparedCopy]) -> CopyComparison:
    """In a process of its own, one at a time. Raises Crowded, or Invalid where it does not come to an end."""
    module = course.modules[exercise.module]
    known = [
        submission.source_for_seed(0).decode(errors="replace")
        for submission in exercise.grader.known_submissions()
        if submission.outcome is Outcome.OK
    ]
    question = {
        "course": [exercise.starter, *module.kits.get(exercise.kit, {}).values()],
        "model": exercise.solution,
        "known": known,
        "codes": [copy.code for copy in sent],
    }
    found = _run_comparison(json.dumps(question))
    pairs = tuple(
        SimilarPair(sent[first], sent[second], (share, other), (tuple(lines), tuple(others)))
        for first, second, share, other, lines, others in found["pairs"]
    )
    return CopyComparison(len(sent), bool(found["too_short"]), pairs)


def exclude_teammate_pairs(comparison: CopyComparison, places: Sequence[TeamPlace]) -> CopyComparison:
    """Leave out the pairs of students who hand in together, or have."""
    teams: dict[UUID, set[UUID]] = {}
    for place in places:
        teams.setdefault(place.account_id, set()).add(place.team_id)
    pairs = (
        pair
        for pair in comparison.pairs
        if teams.get(pair.first.student, set()).isdisjoint(teams.get(pair.second.student, set()))
    )
    return replace(comparison, pairs=tuple(pairs))


def _run_comparison(question: str) -> dict[str, list[tuple[int, int, float, float, list[int], list[int]]]]:
    if not _comparing.acquire(blocking=False):
        raise Overloaded(BUSY, retry_after=5)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "server.similarity.compare"],
            input=question.encode(errors="replace"),
            capture_output=True,
            timeout=2 * CPU_SECONDS,
            env=bare_environment(),
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise Invalid(FAILED) from error
    finally:
        _comparing.release()
    if done.returncode != 0:
        raise Invalid(FAILED)
    return dict(json.loads(done.stdout))
