"""A class in its first five minutes: made, projected, joined from a phone, filled from a list, its slips printed."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

import pytest

from server.cli import main
from tests.contract.browser.conftest import EXERCISE, NewVisit, Visit, sync_api
from tests.contract.browser.test_accessibility import check
from tests.contract.browser.test_story import WRONG

expect = sync_api.expect
LIST = "nom;prenom;email;groupe\nLovelace;Ada;;TP1\nTuring;Alan;;TP2\nMauvais;Un;zut;\n"


def fill(visitor: Visit, fields: dict[str, str], button: str) -> None:
    for label, text in fields.items():
        visitor.page.get_by_label(label, exact=True).fill(text)
    visitor.page.locator("main").get_by_role("button", name=button).click()


def creates(visitor: Visit, name: str) -> None:
    """A class of the module whose exercises these tests send to."""
    visitor.page.get_by_label("Module", exact=True).select_option("l20")
    fill(visitor, {"Nom de la classe": name}, "Créer la classe")


def teacher(visit: NewVisit, login: str) -> Visit:
    """Somebody who has an account, made a teacher's on the command line."""
    visitor = visit(expected="422")
    visitor.page.goto(visitor.server.address + "/inscription")
    secret = "une phrase assez longue"
    fields = {"Nom affiché": "Mme Martin", "Identifiant ou adresse électronique": login, "Mot de passe": secret}
    fill(visitor, fields, "Créer le compte")
    assert main(["admin", "role", login, "teacher", "--data", visitor.server.data]) == 0
    return visitor


@pytest.mark.slow
def test_a_class_in_five_minutes(visit: NewVisit) -> None:
    martin = teacher(visit, "martin-classe")
    page = martin.page
    page.goto(martin.server.address + "/classes")
    check(martin, "classes")
    creates(martin, "MPSI 2")
    expect(page.get_by_role("heading", level=1)).to_have_text("MPSI 2")
    home, code = page.url.removesuffix("/eleves"), page.locator(".join-code").inner_text()
    assert re.fullmatch(r"[A-Z]{4}-[A-Z]{4}", code)
    check(martin, "an empty class")

    page.get_by_role("link", name="Projeter le code").click()
    expect(page.locator(".join-code")).to_have_text(code)
    check(martin, "the wall")

    ada = visit(width=390, height=844)
    ada.page.goto(ada.server.address + "/classes")
    fill(ada, {"Code de la classe": code.lower()}, "Continuer")
    check(ada, "joining")
    fill(ada, {"Prénom": "Ada", "Nom": "Lovelace"}, "Rejoindre la classe")
    expect(ada.page.get_by_role("link", name="Aller aux exercices")).to_be_visible()
    check(ada, "a member's class")

    list_and_slips(martin, visit, home)
    something_to_do(martin, ada, home)
    marks_and_log(martin, home)
    at_the_door(martin, visit, home, code)


def marks_and_log(martin: Visit, home: str) -> None:
    """A mark is set for somebody who has sent nothing, and a column copied; the log tells it."""
    page = martin.page
    page.goto(f"{home}/carnet")
    check(martin, "the gradebook")
    page.get_by_role("row", name="Ada Lovelace").locator("td a").first.click()
    assignment = urlsplit(page.url).path.rpartition("/")[2]
    check(martin, "a mark")
    page.get_by_text("Modifier la note").first.click()
    page.get_by_label("Motif", exact=True).first.fill("Repris à l’oral.")
    page.get_by_label("Points, sur 20").first.fill("12,5")
    page.get_by_role("button", name="Donner ces points").first.click()
    expect(page.locator(".mark-override")).to_contain_text("12,5 / 20")
    page.goto(f"{home}/carnet?colonne={assignment}")
    expect(page.get_by_label("valeurs")).to_have_value(re.compile("^12,5\n|\n12,5$"))
    page.get_by_role("button", name="Copier").click()
    page.goto(f"{home}/journal")
    expect(page.locator(".log tbody")).to_contain_text("Repris à l’oral.")
    check(martin, "the log")


def list_and_slips(martin: Visit, visit: NewVisit, home: str) -> None:
    page = martin.page
    page.goto(f"{home}/liste")
    check(martin, "the list's form")
    page.get_by_label("Collez la liste").fill(LIST)
    page.get_by_role("button", name="Voir ce qui changerait").click()
    expect(page.locator(".lead")).to_contain_text("1 ajout, 1 changement, 0 sortie")
    check(martin, "the preview")
    page.get_by_role("button", name="Ajouter à la classe").click()
    expect(page.get_by_role("heading", name="2 élèves")).to_be_visible()
    check(martin, "a class")
    page.get_by_role("link", name="TP1").click()
    expect(page.get_by_role("checkbox")).to_have_count(1)
    page.get_by_role("checkbox", name="Choisir Ada Lovelace").check()
    page.get_by_label("Groupe", exact=True).fill("SLAM")
    page.get_by_role("button", name="Ajouter au groupe").click()
    expect(page.get_by_role("link", name="SLAM (1)")).to_be_visible()

    page.get_by_role("button", name="Voir les billets à imprimer").click()
    expect(page.locator(".slip")).to_have_count(1)
    check(martin, "slips")
    code = page.locator(".slip-code").inner_text()
    alan = visit()
    alan.page.goto(alan.server.address + "/nouveau-mot-de-passe")
    fill(alan, {"Code du billet, comme ABCD-EFGH": code}, "Continuer")
    fill(alan, {"Nouveau mot de passe": "encore une phrase longue"}, "")
    alan.page.goto(home)
    expect(alan.page.get_by_role("link", name="Aller aux exercices")).to_be_visible()


def something_to_do(martin: Visit, ada: Visit, home: str) -> None:
    """An assignment with its line, an exemption, what a student and their teacher with their eyes see of it."""
    page = martin.page
    page.goto(f"{home}/devoirs/nouveau")
    check(martin, "the form of an assignment")
    page.get_by_label("Titre").fill("Se repérer")
    page.get_by_role("checkbox").first.check()
    page.get_by_label("Date limite").fill("2031-03-23T18:00")
    page.get_by_role("radio", name="pénalité par jour de retard").check()
    page.get_by_label("Points sur 20 perdus").fill("2,5")
    page.get_by_role("button", name="Afficher le barème de retard").click()
    expect(page.locator("svg.late-line")).to_have_attribute("aria-label", re.compile("coûte 2,5 points"))
    page.get_by_role("button", name="Donner ce devoir").click()
    check(martin, "an assignment")
    page.get_by_role("link", name="Aménagements").click()
    page.get_by_role("checkbox", name="Ada Lovelace").check()
    page.get_by_label("Date limite").fill("2031-03-30T02:30")
    page.get_by_role("button", name="Accorder").click()
    expect(page.get_by_role("alert")).to_contain_text("il n’est jamais 2 h 30 ce jour-là")
    page.get_by_label("Date limite").fill("2031-03-30T03:30")
    page.get_by_role("button", name="Accorder").click()
    check(martin, "exemptions")
    page.get_by_role("row").get_by_role("link", name="Ada Lovelace").click()
    check(martin, "why a date is what it is")
    page.get_by_role("link", name="Voir comme cet élève").click()
    expect(page.locator(".watched")).to_contain_text("comme Ada Lovelace")
    check(martin, "a class as a student sees it")
    ada.page.goto(home)
    expect(ada.page.locator(".devoir-dates time").first).to_have_text(re.compile(r"^dimanche 30 mars 2031 à 3\sh\s30"))
    check(ada, "what a student is to do")


def at_the_door(martin: Visit, visit: NewVisit, home: str, code: str) -> None:
    page = martin.page
    page.goto(f"{home}/reglages")
    check(martin, "settings")
    page.get_by_label("Valider chaque inscription").check()
    page.get_by_role("button", name="Enregistrer", exact=True).click()
    bob = visit()
    bob.page.goto(f"{bob.server.address}/rejoindre/{code}")
    fill(bob, {"Prénom": "Bob", "Nom": "Noyce"}, "Demander à entrer")
    expect(bob.page.locator(".notice")).to_contain_text("attend l’accord")
    page.goto(home)
    check(martin, "a board with somebody at the door")
    page.get_by_role("link", name="1 demande d’entrée").click()
    check(martin, "a class with somebody at its door")
    page.get_by_role("button", name="Accepter").click()
    expect(page.get_by_role("heading", name="3 élèves")).to_be_visible()


@pytest.mark.slow
def test_what_is_said_of_work(visit: NewVisit) -> None:
    """A remark on a line, without a script's help; its answer; what axe says of each page where it stands."""
    martin = teacher(visit, "martin-messages")
    page, address = martin.page, martin.server.address
    page.goto(address + "/classes")
    creates(martin, "MPSI 3")
    home, code = page.url.removesuffix("/eleves"), page.locator(".join-code").inner_text()
    ada = visit(width=390, height=844)
    ada.page.goto(f"{address}/rejoindre/{code}")
    fill(ada, {"Prénom": "Ada", "Nom": "Lovelace"}, "Rejoindre la classe")
    ada.open()
    ada.submit(WRONG)
    ada.submit(WRONG + "\nx = 1\n")

    page.goto(f"{home}/eleves")
    page.get_by_role("link", name="Ada Lovelace").click()
    check(martin, "a student")
    page.goto(f"{page.url}/{EXERCISE.removeprefix('/').replace('/exercices', '')}")
    expect(page.locator(".side-added code").last).to_be_visible()
    check(martin, "a student's attempts")
    page.locator(".people tbody th a").first.click()
    page.get_by_role("link", name="Commenter la ligne 1", exact=True).click()
    check(martin, "an attempt, a line chosen")
    fill(martin, {"Votre remarque": "Pourquoi ?"}, "Commenter")
    expect(page.locator(".lines .thread")).to_contain_text("Pourquoi ?")

    ada.page.reload()
    ada.page.locator(".told-news a").click()
    check(ada, "a thread")
    fill(ada, {"Votre réponse": "Je ne sais pas."}, "Répondre")
    page.goto(f"{home}/questions")
    expect(page.locator(".questions li")).to_contain_text("Ada Lovelace")
    check(martin, "questions")
    page.get_by_role("link", name="Écrire à plusieurs élèves").click()
    page.get_by_role("button", name="Choisir").click()
    check(martin, "a word to say")
