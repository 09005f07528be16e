"""Inputs and outputs of the room."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from typing import Any
from uuid import UUID

from graders.core.code.behaviour import Behaviour
from graders.core.code.places import FoundPlace
from graders.core.code.stored_answers import StoredAnswer
from server.behaviour.models import BehaviourGroup, BehaviourName
from server.course.reuse import Own


@dataclass(frozen=True)
class GroupDescription:
    """A teacher's description of a group: plain text, bounded, without blanks around."""

    title: str
    explanation: str
    question: str


@dataclass(frozen=True)
class FingerprintRequest:
    """A grading whose program is to be observed, followed by others that ended after `since`.

    `own`: the files of its author that it may import; `tested`: exercises whose course functions it does not get.
    """

    grading_id: UUID
    exercise: str
    version: str
    source: bytes
    digest: str
    since: datetime
    verdict: dict[str, Any] = field(default_factory=dict)
    own: Own = field(default_factory=dict)
    tested: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Observation:
    """How a program behaves, and the places of its mistakes, if any were found."""

    behaviour: Behaviour
    place: FoundPlace | None = None


@dataclass(frozen=True)
class ObservedBehaviour:
    """The observed behaviour of a program, by which its group is found among those of the exercise's version."""

    exercise: str
    version: str
    answers: tuple[StoredAnswer, ...]
    functions: tuple[str, ...]
    example: dict[str, object] | None


@dataclass(frozen=True)
class UnnamedGroup:
    """Students whose latest attempts failed alike, without a known misconception; `title`: their teacher's, or None.

    `submission`: one of these attempts.
    """

    exercise: str
    group: str
    students: tuple[UUID, ...]
    submission: UUID
    title: str | None


@dataclass(frozen=True)
class GroupMember:
    """A program of a group: author and time; `latest`: its author has sent none since."""

    submission: UUID
    student: UUID
    sent_at: datetime
    score: float | None
    latest: bool


@dataclass(frozen=True)
class ClassGroup:
    """A group within a class: `total` attempts by `students` students, some of them in `lines`; `known` of them have a
    known misconception."""

    group: BehaviourGroup
    name: BehaviourName | None
    lines: tuple[GroupMember, ...]
    total: int
    students: int
    known: int
