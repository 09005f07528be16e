"""The French of the interface has none of the turns that were settled against (`server/docs/dev/french.md`)."""

from __future__ import annotations

import re

import pytest

from server.base.files import ROOT

#: Each with the reason or the phrase to write instead.
TICS = {
    r"[.>:] ?Qui (?:enseigne|arrive|compose)|(?:de|pour|à) qui (?:arrive|n’a|a |enseigne)": "« les enseignants qui… »",
    r"n’y entre plus|n’y paraît|rien ne s’y change|rien n’en est": "a subject, and a verb that says what happens",
    r"[Mm]ots (?:à choisir|choisis)": "« niveaux »",
    r"\b[Bb]illets?\b": "« fiche de connexion »",
    r">Faire (?:ce groupe|une adresse)": "« créer »",
    r"[.>] Qui (?!est bloqué|a |voir)[a-zé’ ]+ (?:en |y |ne |le |sort|voit)": "« les élèves qui… »",
    r"\bne se défait pas|\bCela se défait": "« cette action est définitive », « vous pourrez… »",
    r"(?:Reportée|suit) d’elle-même": "« automatiquement »",
    r"par un incident de notre côté": "« à cause d’une erreur du serveur »",
    r">(?:Ne rien changer|Y mettre|En retirer|Dessiner ce que cela donne|Redessiner)<": "the trade’s verb on a button",
    r"[Dd]ire un mot|\bmots? déjà dits": "« écrire », « messages envoyés »",
    r"phrases? gardées?|redite": "« phrases types », « utilisée »",
    r"nulle part —": "« aucun »",
    r"L’ont (?:encore|eue|surmontée)": "« Encore », « Au total », « Corrigée »",
    r"pas encore rendus? aux élèves": "students hand in (« rendre »), teachers publish (« publier »)",
    r"À rendre avant": "« date limite »",
    r"jour commencé": "« jour de retard entamé »",
    r"d’ailleurs que de": "« depuis un autre site »",
    r"Emporter les notes": "« exporter »",
    r"[Dd]emain matin": "« Après la séance », « La semaine »",
    r"\b\d{1,2}:\d{2}\b": "« 18 h 05 » (`school_time.format_hour`)",
}
TEMPLATES = sorted(path for path in (ROOT / "templates").rglob("*.*") if path.suffix in {".html", ".txt"})
#: Where times are not of French texts: ISO, as a form's field holds it, and a screen of figures.
CLOCKS = {"server/base/school_time.py", "server/cli/top.py"}


@pytest.mark.parametrize("tic", TICS)
def test_no_template_has_a_turn_that_was_settled_against(tic: str) -> None:
    found = [
        f"{path.name}: {match[0]}" for path in TEMPLATES for match in re.finditer(tic, path.read_text(encoding="utf-8"))
    ]
    assert not found, TICS[tic]


def test_times_are_written_in_one_form() -> None:
    found = [
        f"{path}: {line.strip()}"
        for source in sorted((ROOT / "server").rglob("*.py"))
        if (path := source.relative_to(ROOT).as_posix()) not in CLOCKS and "node_modules" not in path
        for line in source.read_text(encoding="utf-8").splitlines()
        if "%H:%M" in line or re.search(r"\{[^{}]*hour[^{}]*\}:\{", line)
    ]
    assert not found, "« 18 h 05 », by `school_time.format_hour`"
