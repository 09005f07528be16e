"""Routers that say by one look at an address that it is none of theirs.

Starlette asks each route in turn whether it is the one. The application has more than two hundred, so that most of the
work of an address of nobody's was asking them, and a third of a small page's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from fastapi import APIRouter
from fastapi.params import Depends
from starlette.routing import BaseRoute, Match
from starlette.types import Scope

_PARAMETER = re.compile(r"\{\w+(:\w+)?\}")


class FilteringRouter(APIRouter):
    """The routes of another router, which are asked only for an address of the form of one of theirs."""

    def __init__(self, router: APIRouter, dependencies: Sequence[Depends] = ()) -> None:
        super().__init__()
        self.include_router(router, dependencies=list(dependencies))
        self._looks_right = re.compile(_pattern_of_routes(router.prefix, router.routes), re.DOTALL).fullmatch

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        return super().matches(scope) if self._looks_right(scope["path"]) else (Match.NONE, {})


def _pattern_of_routes(prefix: str, routes: Iterable[BaseRoute]) -> str:
    """Return a pattern of all addresses of these routes, and of some others; under a prefix, of all that begin so."""
    paths = [getattr(route, "path", None) for route in routes]
    if prefix or None in paths:
        return f"{re.escape(prefix)}.*"
    return "|".join(_path_pattern(str(path)) for path in paths)


def _path_pattern(path: str) -> str:
    pieces, end = list[str](), 0
    for parameter in _PARAMETER.finditer(path):
        pieces += re.escape(path[end : parameter.start()]), ".*" if parameter[1] == ":path" else "[^/]+"
        end = parameter.end()
    return "".join(pieces) + re.escape(path[end:])
