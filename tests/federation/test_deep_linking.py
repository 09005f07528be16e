"""A teacher chooses a content for a course: the signed answer, and who may give it."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import select

from server.assignments.models import AssignedExercise, Assignment
from server.classes.models import SchoolClass
from server.database import utc_now
from server.federation import outbox_repository, signing
from server.federation.models import LineItem, ProviderContext
from tests.support.platforms import AGS, CLAIM, CLIENT, INSTRUCTOR, LEARNER, LINKING, SERVICE, Browser, Platform
from tests.support.service import EXERCISE, Site

SETTINGS = {
    "deep_link_return_url": "https://moodle.example/contentitem_return.php?course=2",
    "accept_types": ["link", "ltiResourceLink"],
    "accept_presentation_document_targets": ["iframe"],
    "accept_lineitem": True,
    "data": "op=321",
}


@pytest.fixture
def platform(site: Site) -> Platform:
    found = Platform()
    found.register(site)
    return found


def choose(browser: Browser, platform: Platform, **changes: Any) -> Any:
    claims = {"message_type": "LtiDeepLinkingRequest", "roles": [INSTRUCTOR], "resource_link": None}
    return browser.launch(platform, **{**claims, f"{LINKING}deep_linking_settings": {**SETTINGS, **changes}})


def verified(site: Site, page: str) -> Mapping[str, Any]:
    """Return the claims of the answer in a page, whose signature our published keys verify."""
    from joserfc import jwt
    from joserfc.jwk import KeySet

    (token,) = re.findall(r'name="JWT" value="([^"]+)"', page)
    keys = KeySet.import_key_set(dict(signing.published_keys(site.database)))
    return jwt.decode(token, keys, algorithms=["RS256"]).claims


def test_an_exercise_goes_to_the_course_signed(site: Site, platform: Platform) -> None:
    browser = Browser(site)
    location = choose(browser, platform).headers["location"]
    page = browser.get(location).text
    assert 'value="/l20/exercices/poses"' in page
    state = location.partition("etat=")[2]
    refused = browser.post(
        "/lti/contenu", data={"etat": state, "contenu": "/l20/exercices/nulle-part", "action": "ajouter"}
    )
    assert refused.status_code == 422
    answer = browser.post("/lti/contenu", data={"etat": state, "contenu": "/l20/exercices/poses", "action": "ajouter"})
    assert f'action="{html.escape(SETTINGS["deep_link_return_url"])}"' in answer.text
    policy = answer.headers["content-security-policy"]
    assert "form-action 'self' https://moodle.example;" in policy
    claims = verified(site, answer.text)
    (item,) = claims[f"{LINKING}content_items"]
    assert (claims["iss"], claims["aud"], claims[f"{LINKING}data"]) == (CLIENT, platform.issuer, "op=321")
    assert claims[f"{CLAIM}message_type"] == "LtiDeepLinkingResponse"
    assert (item["type"], item["url"]) == ("ltiResourceLink", f"{SERVICE}/l20/exercices/poses")
    assert "lineItem" not in item
    again = browser.post("/lti/contenu", data={"etat": state, "contenu": "/l20/exercices/poses", "action": "ajouter"})
    assert again.status_code == 403


def test_an_assignment_goes_with_its_dates_and_its_column(site: Site, platform: Platform) -> None:
    browser = Browser(site)
    course = browser.launch(platform, roles=[INSTRUCTOR]).headers["location"].partition("?")[0]
    browser.post(course, data={"action": "creer", "name": "MPSI", "module": "l20"})
    now = utc_now().replace(microsecond=0)
    with site.database.write() as db:
        (made,) = db.execute(select(SchoolClass)).scalars()
        homework = Assignment(class_id=made.id, title="DM 1", opens_at=now, due_at=now + timedelta(days=2))
        db.add(homework)
        db.flush()
        db.add(AssignedExercise(assignment_id=homework.id, exercise=EXERCISE, position=0))
    state = choose(browser, platform).headers["location"].partition("etat=")[2]
    form = {"etat": state, "contenu": str(homework.id), "action": "ajouter"}
    (item,) = verified(site, browser.post("/lti/contenu", data=form).text)[f"{LINKING}content_items"]
    assert item["url"] == f"{SERVICE}/classes/{made.id}/devoirs/{homework.id}"
    assert item["lineItem"]["resourceId"] == str(homework.id)
    assert item["available"] == {"startDateTime": now.isoformat()}
    assert item["submission"] == {"endDateTime": (now + timedelta(days=2)).isoformat()}
    with site.database.read() as db:
        (line_item,) = db.execute(select(LineItem)).scalars()
    assert line_item.assignment_id == homework.id
    cancelled = choose(browser, platform).headers["location"].partition("etat=")[2]
    page = browser.post("/lti/contenu", data={"etat": cancelled, "action": "annuler"}).text
    assert verified(site, page)[f"{LINKING}content_items"] == []


def test_marks_go_to_the_column_of_the_link_where_the_platform_has_one(site: Site, platform: Platform) -> None:
    """Open edX lets nobody make columns by default, and a Moodle activity has its own already."""
    browser = Browser(site)
    course = browser.launch(platform, roles=[INSTRUCTOR]).headers["location"].partition("?")[0]
    browser.post(course, data={"action": "creer", "name": "MPSI", "module": "l20"})
    now = utc_now()
    with site.database.write() as db:
        (made,) = db.execute(select(SchoolClass)).scalars()
        (context,) = db.execute(select(ProviderContext)).scalars()
        homework = Assignment(class_id=made.id, title="DM 1", opens_at=now, due_at=now)
        db.add(homework)
        db.flush()
        outbox_repository.add_line_item(db, context.id, homework.id, now)
    page = f"{SERVICE}/classes/{made.id}/devoirs/{homework.id}"

    def column(target: str, line_item: str) -> str | None:
        endpoint = {"scope": [f"{AGS}scope/score"], "lineitem": line_item}
        Browser(site).launch(platform, sub="s", target_link_uri=target, **{f"{AGS}claim/endpoint": endpoint})
        with site.database.read() as db:
            return db.execute(select(LineItem.url)).scalar_one()

    mine = f"{platform.issuer}/items/5/lineitem?type_id=3"
    assert column(page, "https://evil.example/items/5") is None
    assert column(f"{SERVICE}/classes/{context.id}/devoirs/{homework.id}", mine) is None
    assert column(f"{SERVICE}/l20/exercices/poses", mine) is None
    assert column(page, mine) == mine
    assert column(page, f"{platform.issuer}/items/6/lineitem") == mine


def test_a_choice_is_of_its_teacher_and_browser(site: Site, platform: Platform) -> None:
    teacher, student = Browser(site), Browser(site)
    location = choose(teacher, platform).headers["location"]
    student.launch(platform, roles=[LEARNER], sub="s")
    assert student.get(location).status_code == 403
    student.cookies.update({name: value for name, value in teacher.cookies.items() if name.startswith("balise_etat")})
    assert student.get(location).status_code == 403
    form = {"etat": location.partition("etat=")[2], "contenu": "/l20/exercices/poses", "action": "ajouter"}
    assert student.post("/lti/contenu", data=form).status_code == 403
    assert teacher.get(location).status_code == 200


def test_only_our_links_and_the_platform_s_own_address_are_served(site: Site, platform: Platform) -> None:
    assert choose(Browser(site), platform, accept_types=["file"]).status_code == 403
    assert choose(Browser(site), platform, deep_link_return_url="https://evil.example/").status_code == 403
    assert choose(Browser(site), platform, deep_link_return_url="javascript:alert(1)").status_code == 403
