"""What comes out of the room."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID

from server.audit.models import OF_STUDENTS, WORDS, What

ERASED = "compte effacé"


@dataclass(frozen=True)
class Named:
    """Somebody, by the name that the class's list has, else their own."""

    id: UUID
    name: str


@dataclass(frozen=True)
class Filter:
    """Which events are asked for; None asks for all."""

    student: UUID | None = None
    what: What | None = None


@dataclass(frozen=True)
class Event:
    """One change. `by` and `student` are None for accounts that are no more, `student` for what is about none too."""

    id: UUID
    at: datetime
    by: Named | None
    what: str
    student: Named | None
    about: str
    before: Mapping[str, Any]
    after: Mapping[str, Any]
    reason: str

    @property
    def words(self) -> str:
        return WORDS[What(self.what)] if self.what in set(What) else self.what

    @property
    def by_name(self) -> str:
        return self.by.name if self.by else ERASED

    @property
    def student_name(self) -> str:
        """Empty for what is about no student."""
        if self.student is not None:
            return self.student.name
        of_label = "label" in {**self.before, **self.after}
        return ERASED if self.what in OF_STUDENTS and not of_label else ""
