"""Routers that are asked in turn whether an address is one of theirs: each says no at once, and not route by route."""

from __future__ import annotations

import re
from functools import cached_property

from fastapi import APIRouter
from starlette.routing import Match
from starlette.types import Scope

#: What stands for a part of an address: `{class_id}`, `{name:path}`.
PART = re.compile(r"\{[^}]*\}")


class Room(APIRouter):
    """The routes of a room, once they are all there."""

    @cached_property
    def _perhaps(self) -> re.Pattern[str]:
        """Matches each address of its routes, and few others."""
        paths = {getattr(route, "path") for route in self.routes}  # noqa: B009
        return re.compile("|".join(sorted(".*".join(map(re.escape, PART.split(path))) for path in paths)), re.DOTALL)

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        return super().matches(scope) if self._perhaps.fullmatch(scope["path"]) else (Match.NONE, {})
