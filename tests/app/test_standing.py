"""Tests share the routes of one application, and nothing that one of them has done is there in the next."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from server.app import ApplicationServices, create_app
from server.base.app_services import add_services, app_service, get_service
from server.base.settings import Settings
from server.cells.supervisor import CellRunner
from server.course import Course
from server.database import Database
from server.identity.models import Account
from tests.support.client import TestClient
from tests.support.quick import migrated, standing_app
from tests.support.service import new_account


@contextmanager
def site(folder: Path, course: Course) -> Iterator[TestClient]:
    settings = Settings(data_dir=folder, workers=0)
    migrated(settings).close()
    with TestClient(standing_app(settings, course)) as client:
        yield client


def test_nothing_is_left_of_the_test_before(tmp_path: Path, course: Course) -> None:
    with site(tmp_path / "one", course) as first:
        app = first.app
        before = dict(app.state.provided)  # type: ignore[attr-defined]
        new_account(get_service(app, Database))  # type: ignore[arg-type]
        add_services(app, before[Settings].model_copy(update={"login_burst": 1}))  # type: ignore[arg-type]
        app.dependency_overrides[app_service(CellRunner)] = lambda: None  # type: ignore[attr-defined]
        assert first.get("/l20").status_code == 200
    with site(tmp_path / "two", course) as second:
        assert second.app is app
        after = second.app.state.provided  # type: ignore[attr-defined]
        assert after.keys() == before.keys()
        assert [kind for kind in after if after[kind] is before[kind] and kind is not Course] == []
        assert after[Settings].login_burst == Settings().login_burst
        assert app.dependency_overrides == {}  # type: ignore[attr-defined]
        assert not second.cookies
        with get_service(app, Database).read() as db:  # type: ignore[arg-type]
            assert db.query(Account).count() == 0


def test_the_application_of_tests_alone_starts_without_a_look_at_what_was_left(tmp_path: Path, course: Course) -> None:
    settings = Settings(data_dir=tmp_path, workers=0)
    migrated(settings).close()
    with patch.object(ApplicationServices, "recover_and_clean_at_start", autospec=True) as looks:
        for made, looked in ((standing_app(settings, course), 0), (create_app(settings, course=course), 1)):
            with TestClient(made):
                assert looks.call_count == looked
