"""The page of groups, and an assignment given to some of them: what each member is shown."""

from __future__ import annotations

import pytest

from server.assignments.models import Assignment
from server.classes.models import ClassRole, Membership
from server.identity.models import Role
from tests.desk.test_assignments import GOOD, School, read
from tests.support.classes import new_class, person, seat
from tests.support.service import Site


@pytest.fixture
def school(site: Site) -> School:
    martin, ada, bob = person(site, Role.teacher, "Mme Martin"), person(site, name="Ada"), person(site, name="Bob")
    made = new_class(site.database, martin.account)
    seat(site.database, made, ada.account)
    seat(site.database, made, bob.account)
    return School(site, made, martin.browser(site), ada, bob)


def test_a_group_is_made_and_an_assignment_given_to_it_alone(school: School) -> None:
    page, martin = f"{school.href}/groupes", school.martin
    assert "Cette classe n’a pas encore de groupe." in read(martin, page)
    refused = martin.post(page, data={"action": "liste", "nom": "Reprise", "noms": "Ada\nZoé"})
    assert refused.status_code == 422
    assert "Ces lignes ne désignent aucun élève de la classe : « Zoé »." in refused.text
    assert "Ada\nZoé</textarea>" in refused.text, "nothing typed is lost"
    assert martin.post(page, data={"action": "liste", "nom": "Reprise", "noms": "Ada"}).status_code == 303
    assert "Reprise 1 élève" in read(martin, page)

    form = martin.get(f"{school.href}/devoirs/nouveau?groupe=Reprise").text
    assert '<input type="checkbox" name="groupe" value="Reprise" checked>' in form
    href = school.give(donne_a="groupes", groupe="Reprise")
    assert "pour Reprise · 0 sur 1 élève" in read(martin, href)
    assert "pour Reprise" in read(martin, f"{school.href}/devoirs")
    assert "Se <repérer>" in read(school.ada.browser(school.site), school.href)
    bob = school.bob.browser(school.site)
    assert "Se <repérer>" not in read(bob, school.href)
    for path in (f"{href}/copie", f"{href}/pourquoi"):
        assert bob.get(path).status_code == 404
    api = f"/api/v1{href.replace('/devoirs/', '/assignments/')}"
    assert school.site.client.get(api, headers=school.bob.headers).status_code == 404
    assert school.site.client.get(api, headers=school.ada.headers).json()["groups"] is None
    carnet = read(martin, f"{school.href}/carnet")
    assert "pour Reprise" in carnet
    assert "non concerné" in carnet
    mark = f"{href.replace('/devoirs/', f'/carnet/{school.bob.id}/')}"
    assert "donné à d’autres groupes" in read(martin, mark)
    decided = martin.post(mark, data={"action": "decider", "etat": "zero"})
    assert decided.status_code == 422, "what does not concern a student gets no mark"
    assert "ajoutez d’abord l’élève au groupe « Reprise »" in decided.text


def test_a_form_with_a_group_ticked_but_the_whole_class_chosen_is_for_the_whole_class(school: School) -> None:
    school.martin.post(f"{school.href}/groupes", data={"action": "liste", "nom": "A", "noms": "Ada"})
    school.give(donne_a="", groupe="A")
    (given,) = school.stored(Assignment)
    assert given.groups == ()
    refused = school.martin.post(f"{school.href}/devoirs", data=GOOD | {"donne_a": "groupes", "groupe": "B"})
    assert refused.status_code == 422
    assert "Personne n’est dans le groupe « B »." in refused.text
    empty = school.martin.post(f"{school.href}/devoirs", data=GOOD | {"donne_a": "groupes"})
    assert empty.status_code == 422, "no group ticked is nobody, not everybody"


def test_groups_are_dealt_renamed_and_dissolved(school: School) -> None:
    page, martin = f"{school.href}/groupes", school.martin
    dealt = {"action": "hasard", "nom": "TP", "combien": "2"}
    assert "de 2 à 30" in martin.post(page, data=dealt | {"combien": "deux"}).text
    assert martin.post(page, data=dealt).status_code == 303
    groups = [row.groups for row in school.stored(Membership) if row.role == ClassRole.student]
    assert sorted(groups) == [["TP 1"], ["TP 2"]]
    assert martin.post(page, data={"action": "renommer", "groupe": "TP 1", "nom": "Lundi"}).status_code == 303
    school.give(donne_a="groupes", groupe="Lundi")
    refused = martin.post(page, data={"action": "dissoudre", "groupe": "Lundi"})
    assert refused.status_code == 422
    assert "Le groupe « Lundi » sert encore : devoir « Se &lt;repérer&gt; »." in refused.text
    assert martin.post(page, data={"action": "dissoudre", "groupe": "TP 2"}).status_code == 303
    assert martin.post(page, data={"action": "dissoudre", "groupe": "TP 2"}).status_code == 404


def test_a_student_is_found_in_the_gradebook_by_a_part_of_the_name(school: School) -> None:
    for number in range(12):
        seat(school.site.database, school.made, person(school.site, name=f"Élève {number:02d}").account, groups=["TP1"])
    page = f"{school.href}/carnet"
    assert "14 élèves" in read(school.martin, page)
    found = read(school.martin, f"{page}?q=eleve+03&groupe=TP1")
    assert "1 élève du groupe TP1" in found
    shown = school.martin.get(f"{page}?q=eleve+03").text
    assert '<th scope="row">Élève 03</th>' in shown
    assert '<th scope="row">Élève 04</th>' not in shown
    assert 'name="groupe" value="TP1"' in school.martin.get(f"{page}?q=x&groupe=TP1").text
    assert "Aucun élève ne correspond." in read(school.martin, f"{page}?q=zoé")


def test_a_pair_is_formed_on_the_pages_and_both_are_told(school: School) -> None:
    """Before what is sent, the page says for whom it counts."""
    refused = school.martin.post(f"{school.href}/devoirs", data=GOOD | {"rendu_a": "2", "mode": "test"})
    assert "Un contrôle se compose seul" in refused.text
    href = school.give(rendu_a="2", equipes_par_eleves="oui")
    martin, ada, bob = school.martin, school.ada.browser(school.site), school.bob.browser(school.site)
    assert "2 élèves n’ont pas encore de binôme" in read(martin, href)
    wrong = martin.post(f"{href}/equipes", data={"action": "former", "noms": "Ada ; Zoé"})
    assert wrong.status_code == 422
    assert "« Zoé »" in wrong.text
    assert "Ada ; Zoé</textarea>" in wrong.text, "nothing typed is lost"

    own = f"{href}/mon-equipe"
    assert "vous rendez ce devoir seul" in read(ada, own)
    assert ada.post(own, data={"action": "proposer", "eleve": str(school.bob.id)}).status_code == 303
    assert "Ada Accepter" in read(bob, own)
    assert bob.post(own, data={"action": "accepter", "eleve": str(school.ada.id)}).status_code == 303
    for browser, partner in ((ada, "Bob"), (bob, "Ada")):
        assert f"Vous rendez ce devoir avec {partner}" in read(browser, school.href)
        assert f"compte pour vous et {partner}" in read(browser, "/l20/exercices/poses")
    assert "Ada, Bob" in read(martin, f"{href}/equipes")
    assert "Ada, Bob" in read(martin, f"{href}/equipes?q=BÔB+ada"), "accents and case aside"
    assert "Personne ne correspond" in read(martin, f"{href}/equipes?q=ada+zoé")
    smaller = martin.post(f"{href}/modifier", data=GOOD | {"rendu_a": "1"})
    assert smaller.status_code == 422
    assert "gardez au moins 2" in smaller.text
    again = ada.post(own, data={"action": "proposer", "eleve": str(school.bob.id)})
    assert again.status_code == 409
    assert "Vous êtes déjà 2" in again.text
    assert ada.post(own, data={"action": "quitter"}).status_code == 303
    assert "Vous avez envoyé ensemble" in read(bob, own) or "Avant : avec Ada" in read(bob, own)
