"""Filters and entries of the audit log."""

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
    """A person, by the name in the class's list, else their own."""

    id: UUID
    name: str


@dataclass(frozen=True)
class AuditFilter:
    """A filter of events; None matches all."""

    student: UUID | None = None
    what: AuditAction | None = None


@dataclass(frozen=True)
class AuditEntry:
    """An event with names. `by` and `student` are None for erased accounts; `student` also where none is concerned."""

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
        """The student's name, empty where no student is concerned."""
        if self.student is not None:
            return self.student.name
        of_label = "label" in {**self.before, **self.after}
        return ERASED if self.what in STUDENT_ACTIONS and not of_label else ""
