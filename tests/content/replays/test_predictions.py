"""What readers are told after a replay is what happens in it: each right answer, and each number of its why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import label

from curriculum.l20.rejeux import filtre_grille
from graders.scene.packing import SceneError
from graders.scene.prediction import Placed, Prediction
from graders.typography import french
from server.base.errors import Invalid
from server.replays.service import ReplayLibrary
from tests.support.replays import cells, layer, scene, unpacked

#: Of each replay with the settings of its question, or with others: what the scene says, and what is told of it.
HOLDS = [
    ("lidar", {}, "22 ne touchent rien avant 4 cases", "22 des 36 rayons"),
    ("filtre-grille", {}, "la croyance a 4 bosses", "la croyance a 4 bosses ensuite"),
    ("filtre-grille", {}, "À partir du pas 7, il n'en reste qu'une", "À partir du pas 7, il ne reste qu'une bosse"),
    ("filtre-grille", {}, "C'est la bonne", "c'est la bonne"),
    ("mcl", {}, "n'a pas été retrouvé", "aucun scan n'en fera naître"),
    ("mcl", {}, "l'erreur est de 5,99 cases", "l'erreur est encore de 6 cases"),
    ("mcl", {"enlevement": "20", "injection": "5"}, "il est retrouvé 12 pas plus tard", "retrouvé 12 pas après"),
    ("occupation", {}, "se trompe de 2,0 cases et de 8°", "se trompe de 2 cases et de 8°"),
    ("occupation", {}, "s'y trompe sur 18,8 %", "19 % sont fausses"),
    ("occupation", {"poses": "vraies"}, "s'y trompe sur 2,2 %", "contre 2 %"),
    ("banane", {}, "La moyenne du nuage est à 1,87 case", "à 1,87 case de l'endroit que dit l'odométrie"),
    ("banane", {}, "le nuage se courbe", "le nuage se courbe en arc"),
    ("banane-mesuree", {}, "un grand écart-type de 0,65 m", "la croyance exacte, 0,65 m"),
    ("banane-mesuree", {}, "L'EKF place la sienne à 2,00 m de là, et annonce 0,46 m", "L'EKF annonce 0,46 m"),
    ("banane-mesuree", {}, "à 2,39 m de sa moyenne, NEES 50,8", "à 2,39 m de son centre, et le NEES vaut 50,8"),
    ("banane-mesuree", {}, "et annonce 1,56 m", "L'UKF annonce 1,56 m"),
    ("banane-mesuree", {}, "et annonce 0,68 m", "Le nuage annonce 0,68 m"),
    ("trois-gestes", {}, "σ_{1} = 2,83 et σ_{2} = 1,41", "de 2,83 et de 1,41"),
    ("icp", {}, "en 28 tours", "après 28 tours"),
    ("icp", {}, "89,1° de la vraie", "à 89° de la bonne"),
    ("laboratoire", {}, "18 boucles acceptées sur 23, dont 2 fausses", "deux fausses sont acceptées avec elles"),
    ("laboratoire", {}, "l’écart aux poses du journal est de 0,16 m", "Elle remonte à 0,16 m"),
    ("laboratoire", {"ecart": "1.2"}, "l’écart aux poses du journal est de 0,30 m", "l’erreur passe à 0,30 m"),
    ("boucles-a-la-main", {}, "Les boucles 1, 5 et 6 sont fausses", "Les boucles 1, 5 et 6 réclament plus d'un mètre"),
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
    ("case", "pairs"),
    [
        pytest.param(case, pairs, id="-".join((case[0], *dict(case[1]))), marks=marks)
        for case, pairs in by_scene().items()
        for marks in [[pytest.mark.slow] if case[0] in HEAVY else []]
    ],
)
def test_what_is_told_is_what_happens(
    case: tuple[str, tuple[tuple[str, str], ...]], pairs: list[tuple[str, str]]
) -> None:
    name, settings = case
    script = ReplayLibrary().find("l20", name)
    assert script.prediction is not None
    summary = " ".join(script.run(script.read(settings or script.prediction.settings.items()))["summary"])
    asked = french(f"{script.prediction.question} {script.prediction.why}")
    for happens, told in pairs:
        assert french(happens) in summary
        assert french(told) in asked


def test_every_replay_has_its_question_and_every_question_is_held() -> None:
    assert {name for name, *_ in HOLDS} == set(ReplayLibrary().replay_names("l20"))


def placed(name: str) -> tuple[Placed, dict[str, Any]]:
    """A replay's point to place, and its scene as the question plays it."""
    script = ReplayLibrary().find("l20", name)
    assert isinstance(script.prediction, Placed)
    return script.prediction, script.run(script.read(script.prediction.settings.items()))


def test_the_point_of_the_crescent_is_the_mean_of_its_particles() -> None:
    asked, body = placed("banane")
    cloud = unpacked(layer(body["frames"][-1]["layers"], "points")["at"])
    assert asked.spots[0] == pytest.approx(cloud.mean(axis=0), abs=0.006)
    x, y = (f"{one:.2f}".replace(".", ",") for one in asked.spots[0])
    assert f"x = {x} et y = {y}" in asked.why
    assert unpacked(layer(body["frames"][-1]["layers"], "polyline")["at"])[-1] == pytest.approx([12.0, 0.0], abs=1e-3)
    assert asked.distance_class("12,0") == "ailleurs", "where odometry puts it is not near"


def way(body: dict[str, Any]) -> NDArray[np.float64]:
    return unpacked(layer([*body["layers"], *body["over"]], "polyline", color="estimate")["at"])


def test_the_point_of_the_path_is_half_way_along_it() -> None:
    asked, body = placed("a-etoile")
    route = way(body)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])
    middle = [float(np.interp(along[-1] / 2, along, column)) for column in route.T]
    assert asked.spots[0] == pytest.approx(middle, abs=0.02)
    old = way(scene("a-etoile", rayon="0.25"))
    assert max(old[:, 1]) < asked.spots[0][1] - asked.near, "the old way is not near"
    x, y = (f"{one:.1f}".replace(".", ",") for one in asked.spots[0])
    assert f"x = {x} et y = {y}" in asked.why


def test_the_points_of_the_twin_rooms_are_the_tops_of_the_other_bumps() -> None:
    asked, body = placed("filtre-grille")
    frame = body["frames"][1]["layers"]
    belief, robot = cells(layer(frame, "grid")) ** 2, layer(frame, "pose")["at"]
    assert robot[:2] == [6.5, 4.5]
    found, count = label(belief > filtre_grille.BUMP * belief.max(), np.ones((3, 3)))
    tops = [np.unravel_index(np.where(found == k, belief, 0.0).argmax(), belief.shape) for k in range(1, count + 1)]
    there = {(float(column) + 0.5, float(row) + 0.5) for row, column in tops}
    near = min(there, key=lambda spot: np.hypot(spot[0] - robot[0], spot[1] - robot[1]))
    assert set(asked.spots) == there - {near}
    for x, y in asked.spots:
        assert f"({x} ; {y})".replace(".", ",") in asked.why


PLACE = Placed("Où ?", ((1.0, 2.0), (5.0, 2.0)), (0.0, 0.0, 8.0, 4.0), near=0.5, far=2.0, why="Là.")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1,2", "pres"), ("5.5,2", "pres"), ("3,2", "loin"), ("8,4", "ailleurs"), ("0,0", "ailleurs"),
        ("-1,2", None), ("1,2,3", None), ("", None), ("1;2", None), ("nan,2", None), ("1e0,2", None), ("bonne", None),
        ("99999,2", None), ("1.234,2", None), ("9,2", None), ("１,2", None),
    ],
)  # fmt: skip
def test_a_place_is_told_by_how_far_it_is_from_the_nearest(text: str, told: str | None) -> None:
    assert PLACE.distance_class(text) == told
    assert [name for name, _ in PLACE.answers] == ["pres", "loin", "ailleurs"]
    assert PLACE.answers[1][1] == "Entre 0,5 et 2 cases."


@pytest.mark.parametrize(
    "wrong", [{"near": 3.0}, {"near": 0.0}, {"spots": ()}, {"spots": ((9.0, 1.0),)}, {"box": (0.0, 0.0, 2.0, 4.0)}]
)
def test_a_place_that_cannot_be_asked_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(SceneError):
        replace(PLACE, **wrong)


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
        ReplayLibrary().find("l20", "lidar").read({"vitesse": "3"}.items())
