"""What comes out of the room."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID

from server.audit.models import ACTION_LABELS, STUDENT_ACTIONS, AuditAction

ERASED = "compte effacé"


@dataclass(frozen=True)
class PersonName:
    """Somebody, by the name that the class's list has, else their own."""

    id: UUID
    name: str


@dataclass(frozen=True)
class AuditFilter:
    """Which events are asked for; None asks for all."""

    student: UUID | None = None
    what: AuditAction | None = None


@dataclass(frozen=True)
class AuditEntry:
    """One change. `by` and `student` are None for accounts that are no more, `student` for what is about none too."""

    id: UUID
    at: datetime
    by: PersonName | None
    what: str
    student: PersonName | None
    about: str
    before: Mapping[str, Any]
    after: Mapping[str, Any]
    reason: str

    @property
    def words(self) -> str:
        return ACTION_LABELS[AuditAction(self.what)] if self.what in set(AuditAction) else self.what

    @property
    def by_name(self) -> str:
        return self.by.name if self.by else ERASED

    @property
    def student_name(self) -> str:
        """Empty for what is about no student."""
        if self.student is not None:
            return self.student.name
        of_label = "label" in {**self.before, **self.after}
        return ERASED if self.what in STUDENT_ACTIONS and not of_label else ""
