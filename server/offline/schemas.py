"""Contexts of the templates of the archive and of its download page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from markupsafe import Markup

from server.course import FunctionSpec
from server.web.schemas import ModuleLink


@dataclass(frozen=True)
class OfflineExercise:
    """An exercise to read: what it asks, without what grades it. No `starter` where it is answered without code."""

    module: ModuleLink
    title: str
    summary: str
    stars: int
    lesson: tuple[str, str] | None
    functions: tuple[FunctionSpec, ...]
    statement: Markup
    starter: str
    file: str


@dataclass(frozen=True)
class OfflinePage:
    """Where the archive is: `size` of one that is made, in words; pictures `done` of `total` while it is being made."""

    module: ModuleLink
    state: Literal["wanted", "making", "failed", "ready"]
    size: str = ""
    done: int = 0
    total: int = 0
