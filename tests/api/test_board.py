"""The board of a class by the HTTP interface (contract, section 6)."""

from __future__ import annotations

import json
from datetime import datetime
from typing import Any

import pytest

from server.api.board import format_board_changes
from server.api.board_schemas import DashboardOut
from server.base.app_services import get_service
from server.board import service
from server.board.live import MAX_STREAMS_PER_ACCOUNT, LiveClassViews
from server.board.schemas import Board
from server.classes.models import SchoolClass
from server.course import Course
from server.database import utc_now
from server.identity.models import Role
from tests.support.classes import Person, new_class, person, seat
from tests.support.crowd import Sent, seated, store
from tests.support.service import EXERCISE, Site

WRONG = "rotation_oubliee"


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def made(site: Site, martin: Person) -> SchoolClass:
    return new_class(site.database, martin.account)


def ask(site: Site, who: Person, made: SchoolClass, what: str, status: int = 200) -> Any:
    answer = site.client.get(f"/api/v1/classes/{made.id}/{what}", headers=who.headers)
    assert answer.status_code == status, answer.text
    return answer


def test_the_dashboard_has_the_contract_s_shape(site: Site, martin: Person, made: SchoolClass, course: Course) -> None:
    ada, alan = seated(site.database, made, 2)
    now = utc_now()
    store(site.database, [Sent(ada, EXERCISE, now, 0.25, WRONG), Sent(alan, EXERCISE, now, 0.6)])
    answer = ask(site, martin, made, "dashboard")
    DashboardOut.model_validate_json(answer.text)
    told = answer.json()
    assert list(told) == ["class", "generated_at", "counts", "misconceptions", "cells", "unnamed", "items"]
    assert told["class"] == str(made.id)
    assert datetime.fromisoformat(told["generated_at"]).utcoffset() is not None
    assert told["counts"] == {"students": 2, "started": 2, "finished": 0, "stuck": 0}
    (row,) = told["misconceptions"]
    assert row.pop("title")
    assert row == {
        "exercise": EXERCISE, "id": WRONG, "now": 1, "ever": 1, "overcome": 0, "median_attempts": None,
        "students": [str(ada)],
    }  # fmt: skip
    assert len(told["cells"]) == 2 * len(course.modules["l20"].exercises)
    (cell,) = [one for one in told["cells"] if (one["student"], one["exercise"]) == (str(alan), EXERCISE)]
    assert cell == {
        "student": str(alan), "exercise": EXERCISE, "points": 12.0, "attempts": 1, "state": "trying",
        "misconception": None,
    }  # fmt: skip
    (unnamed,) = told["unnamed"]
    assert (unnamed["exercise"], unnamed["students"]) == (EXERCISE, [str(alan)])
    assert site.client.get(f"/api/v1/submissions/{unnamed['submission']}", headers=martin.headers).status_code == 200
    (item,) = [one for one in told["items"] if one["exercise"] == EXERCISE]
    assert item == {
        "exercise": EXERCISE, "success": None, "median_attempts": None, "discrimination": None, "n": 2,
    }  # fmt: skip


def test_it_is_for_who_teaches_there(site: Site, martin: Person, made: SchoolClass) -> None:
    ada = person(site)
    seat(site.database, made, ada.account)
    for what in ("dashboard", "events"):
        assert "lire les essais" in ask(site, ada, made, what, 403).json()["detail"]
        ask(site, person(site, Role.teacher), made, what, 404)


def test_events_tell_the_counts_then_what_changes(
    site: Site, martin: Person, made: SchoolClass, course: Course
) -> None:
    boards = get_service(site.app, LiveClassViews)
    boards.max_stream_seconds = 0.0
    (ada,) = seated(site.database, made, 1)

    def board() -> Board:
        with site.database.read() as db:
            school_class = db.get(SchoolClass, made.id)
            assert school_class is not None
            return service.load_board(db, course, school_class, utc_now())

    before = board()
    first = ask(site, martin, made, "events")
    assert first.headers["content-type"].startswith("text/event-stream")
    assert first.text == format_board_changes(None, before)
    assert first.text.startswith("event: counts\ndata: {")
    store(site.database, [Sent(ada, EXERCISE, utc_now(), 1.0)])
    cell, counts, _ = format_board_changes(before, board()).split("\n\n")
    assert cell.startswith("event: cell\n")
    told = json.loads(cell.partition("data: ")[2])
    assert (told["student"], told["state"], told["points"]) == (str(ada), "solved", 20.0)
    assert json.loads(counts.partition("data: ")[2])["started"] == 1
    boards._streams[martin.id] = MAX_STREAMS_PER_ACCOUNT
    assert ask(site, martin, made, "events", 429).headers["retry-after"]
