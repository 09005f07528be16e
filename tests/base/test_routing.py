"""A room says at once what is none of its addresses, and never of one that is."""

from __future__ import annotations

import re

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from fastapi.testclient import TestClient

from server.base.routing import Room
from server.routers import ROUTERS

ROOMS = [router for router in ROUTERS if isinstance(router, Room)]
PART = re.compile(r"\{(\w+)(?::(\w+))?\}")


def test_every_router_but_the_api_is_a_room() -> None:
    assert len(ROOMS) == len(ROUTERS) - 1


@pytest.mark.parametrize("room", ROOMS, ids=[str(number) for number in range(len(ROOMS))])
def test_no_address_of_its_own_is_refused(room: Room) -> None:
    for route in room.routes:
        assert isinstance(route, APIRoute)
        for said in ("a", "é.b", "a b", "50%", "x\ny", ".*"):
            path = PART.sub(lambda part: "l20" if part[2] == "module" else said, route.path)  # noqa: B023
            assert not route.path_regex.match(path) or room._perhaps.fullmatch(path), path


def test_others_are_refused_before_a_route_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    room, app = Room(), FastAPI()

    @room.get("/a/{b}/c")
    def found(b: str) -> str:
        return b

    app.include_router(room)
    client = TestClient(app)
    assert client.get("/a/1/c").json() == "1"
    assert client.get("/a/1/c/", follow_redirects=False).status_code == 307
    assert client.post("/a/1/c").status_code == 405
    asked: list[object] = []
    monkeypatch.setattr(APIRoute, "matches", lambda *_: asked.append(_))
    assert client.get("/a/1/d").status_code == 404
    assert asked == []
