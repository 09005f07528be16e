"""Pages of classes: made, joined from a phone, filled from a list, set up; passwords on slips."""

from __future__ import annotations

import re
from html import unescape
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from server.classes.models import ClassRole, Membership, SchoolClass
from server.identity.models import Account, Role
from server.rights.models import Right
from tests.support.classes import person
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.forms import hidden_fields
from tests.support.service import Site

LIST = "nom;prenom;identifiant;groupe\nLovelace;Ada;ada;TP1\nTuring;Alan;alan;TP2\n"


@pytest.fixture
def martin(site: Site) -> TestClient:
    return person(site, Role.teacher, "Mme Martin").browser(site)


@pytest.fixture
def href(martin: TestClient) -> str:
    made = martin.post("/classes", data={"name": "MPSI <2>", "module": "l20"})
    assert made.status_code == 303
    return str(made.headers["location"])


def text_of(browser: TestClient, path: str, status: int = 200) -> str:
    answer = browser.get(path)
    assert answer.status_code == status, answer.text
    return str(answer.text)


def code_of(browser: TestClient, href: str) -> str:
    found = re.search(r"/rejoindre/([A-Z]{8})<", text_of(browser, f"{href}/eleves"))
    assert found
    return found[1]


def stored(site: Site, table: Any) -> list[Any]:
    with site.database.read() as db:
        return list(db.query(table).all())


def test_a_class_is_made_by_a_teacher_alone(site: Site, martin: TestClient, href: str) -> None:
    page = text_of(martin, f"{href}/eleves")
    assert "MPSI &lt;2&gt;" in page
    assert '<svg class="qr"' in page or "<svg" in page
    assert "MPSI &lt;2&gt;" in text_of(martin, "/classes")
    assert text_of(martin, f"{href}/code").count("<svg") == 1
    ada = person(site).browser(site)
    assert "Créer une classe" not in text_of(ada, "/classes")
    refused = ada.post("/classes", data={"name": "x", "module": "l20"})
    assert refused.status_code == 403
    assert Right.create_class.value in refused.text
    assert "un nom de 1 à 100" in martin.post("/classes", data={"name": " ", "module": "l20"}).text


def test_a_new_class_is_proposed_the_module_of_the_teachers_others(site: Site, martin: TestClient) -> None:
    def proposed(text: str) -> list[str]:
        return re.findall(r'<option value="(\w+)" selected>', text)

    assert proposed(text_of(martin, "/classes")) == ["l20"], "else the one with the most exercises"
    martin.post("/classes", data={"name": "PSI", "module": "l19"})
    assert proposed(text_of(martin, "/classes")) == ["l19"]
    assert proposed(martin.post("/classes", data={"name": " ", "module": "l20"}).text) == ["l20"], "as was chosen"


def test_a_visitor_joins_under_a_name_and_the_work_follows(site: Site, martin: TestClient, href: str) -> None:
    site.client.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    (guest,) = [one for one in stored(site, Account) if one.role == Role.guest]
    code = code_of(martin, href)
    typed = site.client.get("/rejoindre", params={"code": f" {code[:4].lower()} {code[4:]}"})
    assert typed.headers["location"] == f"/rejoindre/{code[:4].lower()}{code[4:]}"
    page = text_of(site.client, str(typed.headers["location"]))
    assert "MPSI &lt;2&gt;" in page
    assert "Mme Martin" in page
    assert "votre prénom" in site.client.post(f"/rejoindre/{code}", data={"given": "", "family": "L"}).text
    answer = site.client.post(f"/rejoindre/{code}", data={"given": "Ada", "family": "Lovelace"})
    assert (answer.status_code, answer.headers["location"]) == (303, href)
    assert "Vos enseignants voient vos essais" in text_of(site.client, href)
    students = text_of(martin, f"{href}/eleves")
    assert "Ada Lovelace" in students
    (sent,) = re.findall(r"/soumissions/[0-9a-f-]{36}", text_of(site.client, "/l20/exercices/poses/essais"))
    assert text_of(martin, sent)
    site.client.post("/inscription", data={"name": "Ada L.", "login": "ada", "password": "notes sur la machine"})
    assert "Aller aux exercices" in text_of(site.client, href)
    assert [one.account_id for one in stored(site, Membership) if one.role == ClassRole.student] == [guest.id]
    assert site.client.post(f"{href}/quitter").headers["location"] == "/classes"
    text_of(site.client, href, 404)
    assert "1 personne est sortie" in text_of(martin, f"{href}/eleves")


def test_a_visitor_who_has_no_good_code_becomes_nobody(site: Site, martin: TestClient, href: str) -> None:
    before = len(stored(site, Account))
    for path in ("/rejoindre/BCDFGHJK", "/rejoindre/zut"):
        assert site.client.get(path).status_code == 404
        assert site.client.post(path, data={"given": "A", "family": "B"}).status_code == 404
    assert len(stored(site, Account)) == before
    assert site.client.get(href).headers["location"] == f"/connexion?suite={href}"


def test_a_list_is_shown_then_written(site: Site, martin: TestClient, href: str) -> None:
    refused = martin.post(f"{href}/liste", data={"texte": "rien"})
    assert (refused.status_code, "nommer les colonnes" in refused.text) == (422, True)
    shown = martin.post(f"{href}/liste", files={"fichier": ("a.csv", LIST.encode("cp1252"))}).text
    assert "2 ajouts" in shown
    assert len(stored(site, Membership)) == 1
    fields = fields_of(shown)
    back = martin.post(f"{href}/liste", data={**fields, "reprendre": "oui"})
    assert "Lovelace" in back.text
    assert len(stored(site, Membership)) == 1
    assert martin.post(f"{href}/liste", data=fields).headers["location"] == f"{href}/eleves"
    assert len(stored(site, Membership)) == 3
    again = martin.post(f"{href}/liste", data=fields)
    assert "La classe a changé entre-temps" in again.text
    assert "Il n’y a rien à écrire" in again.text
    assert "Alan Turing" not in text_of(martin, f"{href}/eleves?groupe=TP1").split('<h2 id="eleves">')[1]


def fields_of(page: str) -> dict[str, str]:
    text = re.search(r'<textarea name="texte" hidden>\n(.*?)</textarea>', page, re.S)
    digest = re.search(r'name="attendu" value="(\w+)"', page)
    assert text
    assert digest
    return {"texte": unescape(text[1]), "attendu": digest[1]}


def test_slips_lead_to_a_first_password(site: Site, martin: TestClient, href: str) -> None:
    shown = martin.post(f"{href}/liste", data={"texte": LIST}).text
    martin.post(f"{href}/liste", data=fields_of(shown))
    slips = martin.post(f"{href}/acces")
    assert slips.headers["cache-control"] == "private, no-store"
    codes = re.findall(r'<strong class="slip-code">([A-Z2-9]{4}-[A-Z2-9]{4})<', slips.text)
    assert len(codes) == 2
    assert re.findall(r'"slip-code">([\w-]+)<', martin.post(f"{href}/acces").text) == codes, "a reload kills none"
    links = [f"/nouveau-mot-de-passe/{code.lower()}" for code in codes]
    typed = site.client.get("/nouveau-mot-de-passe", params={"code": f" {codes[0].lower()}\u200b "})
    assert typed.headers["location"] == f"/nouveau-mot-de-passe/{codes[0].replace('-', '')}"
    ada = TestClient(site.app, follow_redirects=False)
    assert "ada" in text_of(ada, links[0])
    assert ada.post(links[0], data={"login": "ada", "new_password": "notes sur la machine"}).status_code == 303
    assert "Aller aux exercices" in text_of(ada, href)
    assert text_of(ada, links[0], 404)
    assert "1 fiche de connexion" in martin.post(f"{href}/acces").text, "who has chosen one needs none"
    renewed = martin.post(f"{href}/acces", data={"nouveaux": "oui"}).text
    assert "remplacent les précédentes" in renewed
    assert codes[1] not in renewed
    text_of(ada, links[1], 404)
    site.tighten(guest_burst=2, guest_refill_seconds=1000.0)
    stranger = TestClient(site.app, follow_redirects=False)
    assert [stranger.get(f"/nouveau-mot-de-passe/AAAABBB{last}").status_code for last in "234"] == [404, 404, 429]
    assert martin.post(f"{href}/acces", data={"choix": "coches"}).status_code == 422


def test_settings_change_the_class(site: Site, martin: TestClient, href: str) -> None:
    code = code_of(martin, href)
    with site.database.write() as db:
        db.add(Account(role=Role.student, name="Bob", login="bob"))
    martin.post(f"{href}/reglages", data={"name": "PSI", "approbation": "oui"})
    martin.post(f"{href}/code", data={"action": "renouveler", "duree": "jour"})
    assert site.client.get(f"/rejoindre/{code}").status_code == 404
    code = code_of(martin, href)
    assert "accepter votre demande" in text_of(site.client, f"/rejoindre/{code}")
    site.client.post(f"/rejoindre/{code}", data={"given": "Ada", "family": "Lovelace"})
    assert "attend l’accord" in text_of(site.client, href)
    waiting = text_of(martin, f"{href}/eleves")
    assert "1 demande" in waiting
    (asked,) = re.findall(r'name="eleve" value="([\w-]+)" checked', waiting)
    martin.post(f"{href}/eleves", data={"action": "accepter", "eleve": asked})
    assert "Aller aux exercices" in text_of(site.client, href)
    martin.post(f"{href}/eleves", data={"action": "grouper", "eleve": asked, "groupe": "TP1"})
    assert "TP1" in text_of(site.client, href)
    assert martin.post(f"{href}/eleves", data={"action": "retirer"}).status_code == 422
    named = martin.post(f"{href}/equipe", data={"login": "bob", "role": "assistant"})
    assert named.status_code == 200
    assert "Ajouter Bob" in named.text
    assert "Bob (assistant)" not in text_of(site.client, href)
    assert martin.post(f"{href}/equipe", data=hidden_fields(named.text, f"{href}/equipe")).status_code == 303
    refused = martin.post(f"{href}/equipe", data={"login": "nobody", "role": "assistant"})
    assert refused.status_code == 404
    assert 'name="login" type="text" value="nobody"' in refused.text
    assert "Bob (assistant)" in text_of(site.client, href)
    copied = martin.post(f"{href}/copier", data={"name": "PSI 2027"})
    assert copied.status_code == 303
    martin.post(f"{href}/archiver", data={"archiver": "true"})
    assert "Classes archivées (1)" in text_of(martin, "/classes")
    assert martin.get(f"{href}/liste").status_code == 409
    martin.post(f"{href}/archiver", data={"archiver": "false"})
    assert [one.archived_at for one in stored(site, SchoolClass)] == [None, None]


def test_a_student_of_the_class_cannot_teach_in_it(site: Site, martin: TestClient, href: str) -> None:
    code = code_of(martin, href)
    with site.database.write() as db:
        db.add(Account(role=Role.student, name="Bob", login="bob"))
    bob = person(site, account=next(account for account in stored(site, Account) if account.login == "bob"))
    bob.browser(site).post(f"/rejoindre/{code}")
    for data in ({}, {"confirme": str(bob.id)}):
        refused = martin.post(f"{href}/equipe", data={"login": "bob", "role": "enseignant", **data})
        assert refused.status_code == 409
        assert "on n’enseigne pas dans la classe où l’on apprend" in refused.text
    with site.database.read() as db:
        seats = db.scalars(select(Membership).where(Membership.account_id == bob.id)).all()
    assert [seat.role for seat in seats] == ["student"]


def test_the_team_is_told_of_a_new_teacher(site: Site, martin: TestClient, href: str) -> None:
    with site.database.write() as db:
        db.add(Account(role=Role.teacher, name="Mme Durand", login="durand"))
    named = martin.post(f"{href}/equipe", data={"login": "durand", "role": "enseignant"}).text
    assert "compte d’enseignant" in named
    other = next(account for account in stored(site, Account) if account.login != "durand")
    wrong = {**hidden_fields(named, f"{href}/equipe"), "confirme": str(other.id)}
    assert martin.post(f"{href}/equipe", data=wrong).status_code == 200  # another account: named again
    martin.post(f"{href}/equipe", data=hidden_fields(named, f"{href}/equipe"))
    assert "Mme Durand enseigne ou assiste ici depuis le" in text_of(martin, f"{href}/eleves")


def test_a_solution_is_opened_to_a_class(site: Site, martin: TestClient, href: str) -> None:
    page = "/l20/exercices/poses"
    code = code_of(martin, href)
    other = TestClient(site.app, follow_redirects=False)
    for browser in (site.client, other):
        browser.post(f"{page}/soumissions", data={"code": "x = 1"})
    site.client.post(f"/rejoindre/{code}", data={"given": "Ada", "family": "Lovelace"})
    shown = text_of(martin, page)
    assert "Ouvrir le corrigé à la classe « MPSI &lt;2&gt; »" in shown
    assert "à tous les élèves" not in shown
    class_id = href.rpartition("/")[2]
    assert martin.post(f"{page}/corrige", data={"ouvrir": "true"}).status_code == 403
    assert martin.post(f"{page}/corrige", data={"ouvrir": "true", "classe": class_id}).status_code == 303
    assert "Ouvert à votre classe par l’enseignant." in text_of(site.client, page)
    assert "Corrigé commenté" not in text_of(other, page)
    martin.post(f"{page}/corrige", data={"ouvrir": "false", "classe": class_id})
    assert "Corrigé commenté" not in text_of(site.client, page)


def test_the_answers_of_a_paper_wait_for_the_teacher(site: Site, martin: TestClient, href: str) -> None:
    page, told = "/l20/lire/epreuve-corrige", "d’écart-type"
    code, class_id = code_of(martin, href), href.rpartition("/")[2]
    free = TestClient(site.app, follow_redirects=False)
    assert "Avez-vous fini" in text_of(free, page)
    assert told not in text_of(free, page)
    assert told in text_of(free, f"{page}?ouvrir=oui"), "who is of no class goes on past the warning"
    assert "epreuve-corrige#" not in text_of(free, "/l20/recherche?q=lectrice"), "nor does the search tell"

    site.client.post(f"/rejoindre/{code}", data={"given": "Ada", "family": "Lovelace"})
    for asked in (page, f"{page}?ouvrir=oui"):
        assert "Votre enseignant n’a pas ouvert ce corrigé" in text_of(site.client, asked)
        assert told not in text_of(site.client, asked)
    assert site.client.post(f"{page}/corrige", data={"ouvrir": "true", "classe": class_id}).status_code == 403
    assert martin.post("/l20/lire/localiser/corrige", data={"ouvrir": "true", "classe": class_id}).status_code == 404

    shown = text_of(martin, page)
    assert told in shown
    assert "Ouvrir le corrigé à la classe « MPSI &lt;2&gt; »" in shown
    assert martin.post(f"{page}/corrige", data={"ouvrir": "true", "classe": class_id}).status_code == 303
    assert told in text_of(site.client, page)
    assert "Qui peut lire" not in text_of(site.client, page)
    martin.post(f"{page}/corrige", data={"ouvrir": "false", "classe": class_id})
    assert told not in text_of(site.client, page)
    martin.post(f"{href}/archiver", data={"archiver": "true"})
    assert "Avez-vous fini" in text_of(site.client, page), "a class that is over holds nothing back"


def test_a_class_asks_no_more_for_more_students(site: Site, martin: TestClient, href: str) -> None:
    def statements() -> int:
        with Counted(site.database) as counted:
            text_of(martin, f"{href}/eleves")
        return len(counted.statements)

    text_of(martin, f"{href}/eleves")
    few = statements()
    with site.database.write() as db:
        for number in range(40):
            account = Account(role=Role.student, name=f"Ada {number}")
            db.add(account)
            db.flush()
            db.add(Membership(class_id=UUID(href.rpartition("/")[2]), account_id=account.id))
    assert statements() == few <= 6
    assert "40 élèves" in text_of(martin, f"{href}/eleves")


def test_a_list_replaces_the_class_only_when_asked_and_by_names(site: Site, martin: TestClient, href: str) -> None:
    shown = martin.post(f"{href}/liste", data={"texte": LIST}).text
    martin.post(f"{href}/liste", data=fields_of(shown))
    site.client.post(f"/rejoindre/{code_of(martin, href)}", data={"given": "Grace", "family": "Hopper"})
    part = {"texte": "Élève;Bourse\nLOVELACE Ada;oui\nNOETHER Emmy;non\n"}
    shown = martin.post(f"{href}/liste", data=part).text
    assert "2 élèves de la classe ne sont pas dans la liste et y restent" in shown
    assert "Remplacer la classe" in shown
    replacing = martin.post(f"{href}/liste", data={**part, "mode": "remplacer"}).text
    assert "Remplacer&nbsp;: 2 élèves sortent" in replacing
    assert re.search(r"Grace Hopper.*?entré par le code", replacing, re.S)
    martin.post(f"{href}/liste", data=fields_of(shown))
    assert "4 élèves" in text_of(martin, f"{href}/eleves")
    again = martin.post(f"{href}/liste", data={**part, "mode": "remplacer"}).text
    martin.post(f"{href}/liste", data={**fields_of(again), "mode": "remplacer"})
    assert "2 élèves" in text_of(martin, f"{href}/eleves")


def test_columns_in_doubt_are_asked_and_remembered_for_the_next_file(site: Site, martin: TestClient, href: str) -> None:
    content = "Kind;Vorname;Stufe\nLovelace;Ada;9\n"
    asked = martin.post(f"{href}/liste", files={"fichier": ("a.csv", content.encode("utf-16"))})
    assert asked.status_code == 422
    assert "Quelle colonne est quoi" in asked.text
    assert asked.text.count('<select name="colonne"') == 3
    text = re.search(r'<textarea name="texte" hidden>\n(.*?)</textarea>', asked.text, re.S)
    assert text
    by_hand = {"texte": unescape(text[1]), "colonne": ["nom", "prenom", ""], "premiere": "2", "lu": "utf-16"}
    shown = martin.post(f"{href}/liste", data=by_hand).text
    assert "1 ajout" in shown
    assert martin.post(f"{href}/liste", data={**by_hand, **fields_of(shown)}).status_code == 303
    shown = martin.post(f"{href}/liste", data={"texte": "Kind;Vorname;Stufe\nTuring;Alan;9\n"}).text
    assert "comme vous l’avez dit la dernière fois" in shown
    assert "Alan Turing" in shown
    other = person(site, Role.teacher, "M. Durand").browser(site)
    made = other.post("/classes", data={"name": "PSI", "module": "l20"}).headers["location"]
    assert other.post(f"{made}/liste", data={"texte": "Kind;Vorname;Stufe\nTuring;Alan;9\n"}).status_code == 422


def test_accents_are_read_again_as_the_teacher_says(martin: TestClient, href: str) -> None:
    content = "nom;prenom\nŒuvrard;Ana\n".encode("mac_roman")
    shown = martin.post(f"{href}/liste", files={"fichier": ("a.csv", content)}).text
    assert "Les accents sont lus comme écrits par Windows, mais" in shown
    text = re.search(r'<textarea name="texte" hidden>\n(.*?)</textarea>', shown, re.S)
    assert text
    again = martin.post(f"{href}/liste", data={"texte": unescape(text[1]), "lu": "cp1252", "accents": "mac_roman"}).text
    assert "Ana Œuvrard" in again


def test_a_list_of_several_classes_is_shown_by_class(martin: TestClient, href: str) -> None:
    other = martin.post("/classes", data={"name": "PCSI", "module": "l20"}).headers["location"]
    listed = {"texte": "Classe;Nom;Prénom\nMPSI <2>;Lovelace;Ada\nPCSI;Turing;Alan\nPSI;Hopper;Grace\n"}
    shown = martin.post(f"{href}/liste", data=listed).text
    assert "<h2>PCSI</h2>" in shown
    assert "1 ligne de « PSI »" in shown
    martin.post(f"{href}/liste", data=fields_of(shown))
    assert "Alan Turing" in text_of(martin, f"{other}/eleves")
    chosen = martin.post(f"{href}/liste", data={**listed, "lu": "utf-8", "valeur": "PSI", "ici": "oui"}).text
    assert "Grace Hopper" in chosen
    assert "<h2>PCSI</h2>" not in chosen
