"""The application's services, injected into routes by type."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import cache
from typing import Annotated, TypeVar

from fastapi import Depends, FastAPI
from starlette.requests import HTTPConnection

from server.base.settings import Settings

T = TypeVar("T")

_asked_for: set[type] = set()


@cache
def app_service(kind: type[T]) -> Callable[[HTTPConnection], Awaitable[T]]:
    """A dependency that gives the application's only object of this very type."""
    _asked_for.add(kind)

    async def find(connection: HTTPConnection) -> T:  # of the loop's: it is no work for a thread
        return get_service(connection.app, kind)

    return find


def app_service_getter(kind: type[T]) -> Callable[[FastAPI], T]:
    """Gives the application's only object of this type, where it is asked for on the way of every page or submission:
    as a dependency, FastAPI takes longer to come to each than SQLite to answer."""
    _asked_for.add(kind)
    return lambda app: get_service(app, kind)


def add_services(app: FastAPI, *objects: object) -> None:
    """Hands these to the application's routes, beside what it has already; a later one of a type replaces it."""
    known: dict[type, object] = getattr(app.state, "provided", {})
    app.state.provided = {**known, **{type(instance): instance for instance in objects}}


def check_services(app: FastAPI) -> None:
    """Raises LookupError where a route asks for what the application does not have."""
    missing = sorted(kind.__qualname__ for kind in _asked_for - app.state.provided.keys())
    if missing:
        raise LookupError(f"the application was built without {', '.join(missing)}")


def get_service(app: FastAPI, kind: type[T]) -> T:
    """For what is no route: an error's page, the header of every page, a test."""
    instance = app.state.provided[kind]
    if not isinstance(instance, kind):
        raise TypeError(f"{instance!r} stands where a {kind.__qualname__} should")
    return instance


SettingsOf = Annotated[Settings, Depends(app_service(Settings))]
