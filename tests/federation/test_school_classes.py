"""A class of a school's system arrives as a class: through the page on which its teacher sees who would enter."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select

from server.classes.models import Membership, SchoolClass, Status
from server.federation.models import ContextTeacher, IdentityProvider, Protocol, ProviderContext, WaitingStudent
from server.federation.rules import ENT_RULE
from tests.support.client import TestClient
from tests.support.issuer import FakeCas
from tests.support.schools import add_server, browser, count, path_of, query_of, stand_in
from tests.support.service import Site

CLASSES = {"2NDE5": "SIREN=1$2NDE5", "1SPE": "SIREN=1$1SPE"}


def ent(site: Site) -> tuple[IdentityProvider, FakeCas]:
    provider, cas = add_server(site.database, Protocol.cas), stand_in(site, FakeCas())
    with site.database.write() as db:
        found = db.get(IdentityProvider, provider.id)
        assert found is not None
        found.settings = {**found.settings, "rule": ENT_RULE.model_dump(mode="json")}
    return provider, cas


def come(site: Site, provider: IdentityProvider, cas: FakeCas, user: str, **attributes: str) -> tuple[TestClient, str]:
    """Sign in as a person with these attributes; return the browser, and the page that it was led to."""
    cas.user, cas.attributes = user, attributes
    client = browser(site)
    service = query_of(client.get(f"/connexion/etablissement/{provider.id}").headers["location"])["service"]
    return client, client.get(f"{path_of(service)}&ticket={cas.new_ticket(service)}").headers["location"]


def pupil(name: str, of: str = "2NDE5") -> dict[str, str]:
    given, family = name.split()
    profile = {"ENTPersonProfils": "National_ELV", "ENTEleveClasses": CLASSES[of]}
    return {"ENTPersonPrenom": given, "ENTPersonNom": family, **profile}


def members(site: Site) -> list[tuple[str, str, str]]:
    with site.database.read() as db:
        rows = db.execute(select(Membership.given_name, Membership.family_name, Membership.role)).all()
    return sorted((row[0], row[1], row[2]) for row in rows)


def contexts(site: Site) -> dict[str, Any]:
    with site.database.read() as db:
        return {row.title: row.id for row in db.execute(select(ProviderContext)).scalars()}


TEACHER = {"ENTPersonProfils": "National_ENS", "ENTPersonPrenom": "Emmy", "ENTPersonNom": "Noether"}


def test_pupils_who_came_first_enter_the_class_that_their_teacher_makes(site: Site) -> None:
    provider, cas = ent(site)
    for user, name in (("u1", "Ada Lovelace"), ("u2", "Alan Turing")):
        assert come(site, provider, cas, user, **pupil(name))[1] == "/"
    come(site, provider, cas, "u3", **pupil("Kurt Goedel", of="1SPE"))
    emmy, page = come(site, provider, cas, "t1", **TEACHER, ENTAuxEnsClasses=CLASSES["2NDE5"])
    assert page.startswith(f"/etablissement/cours/{contexts(site)['2NDE5']}?")
    shown = emmy.get(page).text
    assert ("2 élèves en sont déjà venus" in shown, "Ada Lovelace" in shown, "Kurt" in shown) == (True, True, False)
    made = emmy.post(page.partition("?")[0], data={"action": "creer", "name": "Seconde 5", "module": "l20"})
    assert made.status_code == 303
    assert members(site) == [("", "", "teacher"), ("Ada", "Lovelace", "student"), ("Alan", "Turing", "student")]
    assert count(site, WaitingStudent) == 1
    _, page = come(site, provider, cas, "u4", **pupil("Grace Hopper"))
    assert page == made.headers["location"]
    assert ("Grace", "Hopper", "student") in members(site)


def test_a_teacher_of_several_classes_chooses_among_them(site: Site) -> None:
    provider, cas = ent(site)
    come(site, provider, cas, "u1", **pupil("Ada Lovelace"))
    cas_classes = f"{CLASSES['2NDE5']}</cas:ENTAuxEnsClasses><cas:ENTAuxEnsClasses>{CLASSES['1SPE']}"
    emmy, page = come(site, provider, cas, "t1", **TEACHER, ENTAuxEnsClasses=cas_classes)
    assert page.startswith("/etablissement/cours?")
    shown = emmy.get(page).text
    assert ("2NDE5" in shown, "1SPE" in shown, "1 élève déjà venu<" in shown) == (True, True, True)
    asked = emmy.get("/classes").text.replace("\xa0", " ")
    assert ("/etablissement/cours?suite=/classes" in asked, "1 élève déjà venu." in asked) == (True, True)
    ada, _ = come(site, provider, cas, "u1", **pupil("Ada Lovelace"))
    assert "/etablissement/cours" not in ada.get("/classes").text
    assert "2NDE5" not in ada.get("/etablissement/cours").text
    assert ada.get(f"/etablissement/cours/{contexts(site)['2NDE5']}").status_code == 404
    come(site, provider, cas, "t1", **TEACHER, ENTAuxEnsClasses=CLASSES["1SPE"])
    assert count(site, ContextTeacher) == 1


def test_a_pupil_who_changes_classes_waits_for_the_new_one_alone(site: Site) -> None:
    provider, cas = ent(site)
    come(site, provider, cas, "u1", **pupil("Ada Lovelace"))
    come(site, provider, cas, "u1", **pupil("Ada Lovelace", of="1SPE"))
    with site.database.read() as db:
        assert list(db.execute(select(WaitingStudent.context_id)).scalars()) == [contexts(site)["1SPE"]]


def test_a_removed_pupil_waits_to_be_admitted_again(site: Site) -> None:
    provider, cas = ent(site)
    come(site, provider, cas, "u1", **pupil("Ada Lovelace"))
    emmy, page = come(site, provider, cas, "t1", **TEACHER, ENTAuxEnsClasses=CLASSES["2NDE5"])
    emmy.post(page.partition("?")[0], data={"action": "creer", "name": "Seconde 5", "module": "l20"})
    with site.database.write() as db:
        (seat,) = db.execute(select(Membership).where(Membership.role == "student")).scalars()
        (school_class,) = db.execute(select(SchoolClass)).scalars()
        emmy_form = {"action": "retirer", "eleve": str(seat.account_id)}
    emmy.post(f"/classes/{school_class.id}/eleves", data=emmy_form)
    come(site, provider, cas, "u1", **pupil("Ada Lovelace"))
    with site.database.read() as db:
        (seat,) = db.execute(select(Membership).where(Membership.role == "student")).scalars()
        assert seat.status == Status.pending
