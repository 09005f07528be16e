"""What the room takes and gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from uuid import UUID

from graders.core.code.plain import Plain
from server.behaviour.models import BehaviourGroup, BehaviourName
from server.course.reuse import Own


@dataclass(frozen=True)
class GroupDescription:
    """What a teacher says of a group: plain text, within bounds, without blanks around."""

    title: str
    explanation: str
    question: str


@dataclass(frozen=True)
class FingerprintRequest:
    """A grading whose program is to be asked how it behaves; others that ended `since` follow.

    `own`: the files of its author that it may import from.
    """

    grading_id: UUID
    exercise: str
    version: str
    source: bytes
    digest: str
    since: datetime
    own: Own = field(default_factory=dict)


@dataclass(frozen=True)
class ObservedBehaviour:
    """What a program showed, as it is looked for among the groups of its exercise's version."""

    exercise: str
    version: str
    answers: tuple[Plain, ...]
    functions: tuple[str, ...]
    example: dict[str, object] | None


@dataclass(frozen=True)
class UnnamedGroup:
    """Students whose latest attempt failed alike, without a misconception; `title` is their teacher's, or None.

    `submission` is one of these attempts.
    """

    exercise: str
    group: str
    students: tuple[UUID, ...]
    submission: UUID
    title: str | None


@dataclass(frozen=True)
class GroupMember:
    """A program of a group: whose it is and when it was sent; `latest`: its author has sent none since."""

    submission: UUID
    student: UUID
    sent_at: datetime
    score: float | None
    latest: bool


@dataclass(frozen=True)
class ClassGroup:
    """A group as a class knows it: `total` attempts by so many `students`, the first of them in `lines`; in `known` of
    them a misconception was named."""

    group: BehaviourGroup
    name: BehaviourName | None
    lines: tuple[GroupMember, ...]
    total: int
    students: int
    known: int
