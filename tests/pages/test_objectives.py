"""The page of one's own objectives: one proposal with its reason and its length, what stands, what fades, the end."""

from __future__ import annotations

import pytest

from tests.pages.test_notebook import Pupil
from tests.recall.test_two_minutes import age, confuse_and_mend
from tests.support.counting import Counted
from tests.support.service import Site

PAGE = "/l20/objectifs"


@pytest.fixture
def pupil(site: Site) -> Pupil:
    return Pupil(site, site.client)


def test_a_newcomer_is_told_where_to_begin(pupil: Pupil) -> None:
    page = pupil.read(PAGE)
    assert "Commencer : Séance 1" in page.replace("\xa0", " ").replace("\u202f", " ")
    assert "Objectif par objectif" not in page
    assert "Jusqu’au bout" in page


def test_one_proposal_has_its_reason_and_its_length(pupil: Pupil) -> None:
    pupil.send("poses", "x = 1  # rotation_oubliee\n")
    page = pupil.read(PAGE).replace("\xa0", " ").replace("\u202f", " ")
    proposal = page.split('id="maintenant"')[1].split("</section>")[0]
    assert proposal.count("<a ") == 1
    assert 'href="/l20/exercices/poses"' in proposal
    assert "Environ" in proposal
    assert "votre dernière erreur y était « La rotation est oubliée »" in proposal
    pupil.send("poses", "x = 2\n")
    pupil.client.post("/l20/chemin", data={"chemin": "chemins#s-le-chemin-lycee"})
    page = pupil.read(PAGE)
    assert "c’est la suite de votre chemin" in page.split('id="maintenant"')[1].split("</section>")[0]
    assert "1 sur 14" in page.replace("\xa0", " ").replace("\u202f", " ")
    assert "calcul_outils" not in page.split('id="bout"')[1], "not on the way to the end of this path"


def test_what_fades_is_told_by_its_objective_and_proposed_first(site: Site, pupil: Pupil) -> None:
    confuse_and_mend(site)
    assert "S’efface" not in pupil.read(PAGE)
    age(site, 3)
    page = pupil.read(PAGE)
    proposal = page.split('id="maintenant"')[1].split("</section>")[0]
    assert 'href="/deux-minutes"' in proposal
    assert "commence à s’effacer" in proposal
    assert page.count("S’efface&nbsp;:") == 1
    site.client.post("/deux-minutes/rappels", data={"rappels": "non"})
    assert "/deux-minutes" not in pupil.read(PAGE).split('id="maintenant"')[1].split("</section>")[0]


def test_home_computes_nothing_of_reminders_that_are_off(site: Site) -> None:
    confuse_and_mend(site)
    site.client.get("/")
    counts = []
    for choice in ("oui", "non"):
        site.client.post("/deux-minutes/rappels", data={"rappels": choice})
        with Counted(site.database) as counted:
            assert site.client.get("/").status_code == 200
        counts.append(len(counted.statements))
    assert counts[1] <= counts[0] - 2
