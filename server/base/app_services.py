"""The application's services, injected into routes by type.

A service that a route asks for and nobody added is an error when the application is put together."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import cache
from typing import Annotated, TypeVar

from fastapi import Depends, FastAPI
from starlette.requests import HTTPConnection

from server.base.settings import Settings

T = TypeVar("T")

_requested_types: set[type] = set()


@cache
def app_service(kind: type[T]) -> Callable[[HTTPConnection], Awaitable[T]]:
    """Return a FastAPI dependency that gives the application's service of this type."""
    _requested_types.add(kind)

    async def find(connection: HTTPConnection) -> T:  # async: FastAPI would run it in a thread otherwise
        return get_service(connection.app, kind)

    return find


def app_service_getter(kind: type[T]) -> Callable[[FastAPI], T]:
    """Return a function that gives an application's service of this type, for the hot path: resolving it as a FastAPI
    dependency takes longer than a query of SQLite."""
    _requested_types.add(kind)
    return lambda app: get_service(app, kind)


def add_services(app: FastAPI, *objects: object) -> None:
    """Add services to the application; one of a type that it has already replaces it."""
    services: dict[type, object] = getattr(app.state, "provided", {})
    app.state.provided = {**services, **{type(instance): instance for instance in objects}}


def check_services(app: FastAPI) -> None:
    """Raise LookupError where a route asks for a service that the application does not have."""
    missing = sorted(kind.__qualname__ for kind in _requested_types - app.state.provided.keys())
    if missing:
        raise LookupError(f"the application was built without {', '.join(missing)}")


def get_service(app: FastAPI, kind: type[T]) -> T:
    """Return the application's service of this type, for code outside of routes: error pages, tests."""
    instance = app.state.provided[kind]
    if not isinstance(instance, kind):
        raise TypeError(f"{instance!r} stands where a {kind.__qualname__} should")
    return instance


SettingsOf = Annotated[Settings, Depends(app_service(Settings))]
