"""What readers are told after a replay is what happens in it: each right answer, and each number of its why."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from graders.scene.packing import SceneError
from graders.scene.prediction import Prediction
from graders.typography import french
from server.base.errors import Invalid
from server.replays.service import Replays

#: Of each replay with the settings of its question, or with others: what the scene says, and what is told of it.
HOLDS = [
    ("lidar", {}, "22 ne touchent rien avant 4 cases", "22 des 36 rayons"),
    ("filtre-grille", {}, "la croyance a 4 bosses", "la croyance a 4 bosses"),
    ("filtre-grille", {}, "À partir du pas 7, il n'en reste qu'une", "À partir du pas 7, il ne reste qu'une bosse"),
    ("filtre-grille", {}, "C'est la bonne", "c'est la bonne"),
    ("mcl", {}, "n'a pas été retrouvé", "aucun scan n'en fera naître"),
    ("mcl", {}, "l'erreur est de 5,99 cases", "l'erreur est encore de 6 cases"),
    ("mcl", {"enlevement": "20", "injection": "5"}, "il est retrouvé 12 pas plus tard", "retrouvé 12 pas après"),
    ("occupation", {}, "se trompe de 2,0 cases et de 8°", "se trompe de 2 cases et de 8°"),
    ("occupation", {}, "s'y trompe sur 18,8 %", "19 % sont fausses"),
    ("occupation", {"poses": "vraies"}, "s'y trompe sur 2,2 %", "contre 2 %"),
    ("banane", {}, "La moyenne du nuage est à 1,87 case", "La moyenne est à 1,87 case"),
    ("banane", {}, "le nuage se courbe", "le nuage se courbe en arc"),
    ("banane-mesuree", {}, "un grand écart-type de 0,65 m", "la croyance exacte, 0,65 m"),
    ("banane-mesuree", {}, "L'EKF place la sienne à 2,00 m de là, et annonce 0,46 m", "L'EKF annonce 0,46 m"),
    ("banane-mesuree", {}, "à 2,39 m de sa moyenne, NEES 50,8", "à 2,39 m de son centre, et le NEES vaut 50,8"),
    ("banane-mesuree", {}, "et annonce 1,56 m", "L'UKF annonce 1,56 m"),
    ("banane-mesuree", {}, "et annonce 0,68 m", "Le nuage annonce 0,68 m"),
    ("trois-gestes", {}, "σ_{1} = 2,83 et σ_{2} = 1,41", "de 2,83 et de 1,41"),
    ("icp", {}, "en 28 tours", "après 28 tours"),
    ("icp", {}, "89,1° de la vraie", "à 89° de la bonne"),
    ("graphe", {}, "du vrai trajet de 1,80 case", "de 1,8 à 7 cases"),
    ("graphe", {}, "l'écart est de 7,05 cases", "de 1,8 à 7 cases"),
    ("graphe", {"fausse": "1", "noyau": "dcs"}, "l'écart est de 0,50 case", "tombe à 0,5 case"),
    ("a-etoile", {"rayon": "0.25"}, "un chemin de 19,2 cases", "le chemin fait 19,2 cases"),
    ("a-etoile", {}, "un chemin de 31,5 cases", "le chemin fait 31,5 cases"),
]
HEAVY = {"mcl", "occupation"}


def by_scene() -> Mapping[tuple[str, tuple[tuple[str, str], ...]], list[tuple[str, str]]]:
    found: dict[tuple[str, tuple[tuple[str, str], ...]], list[tuple[str, str]]] = {}
    for name, settings, happens, told in HOLDS:
        found.setdefault((name, tuple(settings.items())), []).append((happens, told))
    return found


@pytest.mark.parametrize(
    ("scene", "pairs"),
    [
        pytest.param(scene, pairs, id="-".join((scene[0], *dict(scene[1]))), marks=marks)
        for scene, pairs in by_scene().items()
        for marks in [[pytest.mark.slow] if scene[0] in HEAVY else []]
    ],
)
def test_what_is_told_is_what_happens(
    scene: tuple[str, tuple[tuple[str, str], ...]], pairs: list[tuple[str, str]]
) -> None:
    name, settings = scene
    script = Replays().find("l20", name)
    assert script.prediction is not None
    summary = " ".join(script.run(script.read(settings or script.prediction.settings.items()))["summary"])
    asked = french(f"{script.prediction.question} {script.prediction.why}")
    for happens, told in pairs:
        assert french(happens) in summary
        assert french(told) in asked


def test_every_replay_has_its_question_and_every_question_is_held() -> None:
    assert {name for name, *_ in HOLDS} == set(Replays().names("l20"))


ANSWERS = (("a", "Un"), ("b", "Deux"))


@pytest.mark.parametrize(
    ("answers", "right"),
    [
        (ANSWERS[:1], "a"),
        ((*ANSWERS, ("a", "Trois")), "a"),
        (ANSWERS, "c"),
        ((*ANSWERS, ("C d", "Trois")), "a"),
        (tuple((f"a{k}", "Un") for k in range(7)), "a0"),
    ],
)
def test_a_malformed_question_is_refused(answers: tuple[tuple[str, str], ...], right: str) -> None:
    with pytest.raises(SceneError):
        Prediction("Quoi ?", answers, right, "Ainsi.")


def test_a_question_is_refused_whose_settings_the_replay_does_not_have() -> None:
    with pytest.raises(Invalid):
        Replays().find("l20", "lidar").read({"vitesse": "3"}.items())
