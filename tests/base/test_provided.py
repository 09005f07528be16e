"""What an application was built with is handed on by type, and what lacks is told when it is put together."""

from __future__ import annotations

from typing import Annotated

import pytest
from fastapi import Depends, FastAPI

from server.base import app_services as room
from server.base.app_services import add_services, app_service, check_services, get_service
from tests.support.client import TestClient


class Bell:
    def __init__(self, sound: str) -> None:
        self.sound = sound


@pytest.fixture(autouse=True)
def _asked_for_here_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "_requested_types", set())


def test_a_route_gets_the_object_of_the_type_that_it_asks_for() -> None:
    app = FastAPI()

    @app.get("/")
    def ring(bell: Annotated[Bell, Depends(app_service(Bell))]) -> str:
        return bell.sound

    add_services(app, Bell("dong"))
    check_services(app)
    assert TestClient(app).get("/").json() == "dong"
    add_services(app, Bell("ding"))
    assert TestClient(app).get("/").json() == "ding"
    assert get_service(app, Bell).sound == "ding"


def test_what_lacks_is_an_error_when_the_application_is_put_together() -> None:
    class Whistle: ...

    app = FastAPI()
    app_service(Whistle)
    add_services(app, Bell("dong"))
    with pytest.raises(LookupError, match=r"built without .*Whistle"):
        check_services(app)
