"""The places of mistakes, found after the verdict: stored beside it, joined when read, and shown by themselves."""

from __future__ import annotations

import pytest
from sqlalchemy import select

from graders.core.code.places import FoundPlace
from graders.core.contract.verdict import Diagnosis
from server.base.settings import Settings
from server.behaviour import place_queries
from server.behaviour.fingerprints import FingerprintScheduler
from server.behaviour.models import Fingerprint
from server.classes.models import ClassRole
from server.database import Database
from server.identity.models import Role
from tests.support.behaviour import SUM, PlaceFinder, asking_worker, failed_verdict, sent
from tests.support.classes import new_class, person, seat
from tests.support.quick import the_course
from tests.support.service import QUIET, Site, new_account

PLACE = FoundPlace(Diagnosis("lieu", "Changer la ligne 3 suffit", "Ligne 3 : « a + b ».", None, (("b",),)), "opérateur")


def search(database: Database, settings: Settings, find: PlaceFinder) -> None:
    """Have all failed attempts observed, their places found by `find`."""
    worker = asking_worker(database, settings, find=find)
    FingerprintScheduler(database, QUIET, the_course()).queue_next()
    while worker.run_one():
        pass


@pytest.mark.parametrize("named", [None, "known"])
def test_a_place_is_joined_to_the_verdict_and_the_page_waits_for_it(site: Site, named: str | None) -> None:
    martin, ada = person(site, Role.teacher, "Mme Martin"), person(site, name="Ada")
    seat(site.database, new_class(site.database, martin.account), ada.account, ClassRole.student)
    made = sent(site.database, ada.account, SUM, failed_verdict(named=named))
    page = ada.browser(site)
    assert f'data-later="/soumissions/{made}/verdict"' in page.get(f"/soumissions/{made}").text
    search(site.database, site.settings, lambda *_: PLACE)
    shown = page.get(f"/soumissions/{made}").text
    assert "data-later" not in shown
    assert "ligne 3" in shown
    verdict = site.client.get(f"/api/v1/submissions/{made}", headers=ada.headers).json()["verdict"]
    assert verdict["diagnosis"]["id"] == (named or "lieu")
    assert "Ligne 3 : « a + b »." in verdict["diagnosis"]["explanation"]
    with site.database.read() as db:
        assert db.execute(select(Fingerprint.changes)).scalar_one() == "opérateur"


def test_an_error_of_the_search_costs_the_observation_nothing(
    database: Database, settings: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    teacher = new_account(database, Role.teacher, "Mme Martin")
    ada = seat(database, new_class(database, teacher), new_account(database))
    sent(database, ada, SUM)

    def fail(*_: object) -> None:
        raise ZeroDivisionError

    search(database, settings, fail)
    assert "could not be searched" in caplog.text
    with database.read() as db:
        grading_id = db.execute(select(Fingerprint.grading_id)).scalar_one()
        assert place_queries.load_mistake_places(db, grading_id) == (True, None)
