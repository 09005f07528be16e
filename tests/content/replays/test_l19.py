"""The replays of L19: what readers are told is what happens, and what happens is what the filters say."""

from __future__ import annotations

import numpy as np
import pytest

from curriculum.l19.rejeux import balises, coherence, rail
from graders.scene.prediction import Prediction
from graders.typography import french
from reference.filters.scalar import mean_nees_band
from tests.support.replays import REPLAYS, layer, scene_of, unpacked

#: Of each replay with the settings of its question, or with others: what the scene says, and what is told of it.
HOLDS = [
    ("rail", {}, "de 1,51 m à 0,47 m", "de 1,51 m à 0,47 m"),
    ("rail", {}, "Le palier est à 0,29 m", "il se pose à 0,29 m"),
    ("balises", {}, "de 1,00 m à 0,20 m", "de 1,00 m à 0,20 m"),
    ("balises", {}, "en travers, il vaut encore 1,00 m", "il reste de 1,00 m"),
    ("balises", {}, "il vaut 0,38 m dans la pire direction", "que de 0,38 m dans sa pire direction"),
    ("coherence", {}, "le filtre bien réglé annonce 0,29 m, avec un gain de 0,33", "de 0,29 : son gain tombe de 0,33"),
    ("coherence", {}, "Le vôtre annonce 0,17 m, avec un gain de 0,11", "Il annonce 0,17 m"),
    ("coherence", {}, "l'erreur quadratique moyenne est de 0,28 m", "montent de 0,28 à 0,39 m"),
    ("coherence", {}, "son erreur est de 0,39 m, et son NEES moyen vaut 5,18", "Son NEES moyen vaut 5,18"),
]  # fmt: skip
#: What captions and the séance have one try, and what is then said.
TRIED = [
    ("rail", {"impose": "1"}, "fois moins"),
    ("rail", {"pas": "0"}, "tend vers zéro"),
    ("balises", {"depart": "3", "balise": "6,1,0"}, "se croit trop sûr"),
    ("coherence", {"pas": "1"}, "Rien ne le distingue"),
    ("coherence", {"pas": "1", "mesure": "0.3"}, "trop sûr de lui"),
    ("coherence", {"pas": "1", "mesure": "2"}, "doute trop"),
    ("coherence", {"pas": "1", "pente": "0.2"}, "trop sûr de lui"),
    ("coherence", {"pas": "3", "pente": "0.2"}, "Rien ne le distingue"),
]


def summary(name: str, settings: dict[str, str]) -> str:
    return " ".join(scene_of("l19", name, settings)["summary"])


@pytest.mark.parametrize(("name", "settings", "happens", "told"), HOLDS)
def test_what_is_told_is_what_happens(name: str, settings: dict[str, str], happens: str, told: str) -> None:
    asked = REPLAYS.find("l19", name).prediction
    assert isinstance(asked, Prediction)
    assert french(happens) in summary(name, settings)
    assert french(told) in french(f"{asked.question} {asked.why}")


@pytest.mark.parametrize(("name", "settings", "said"), TRIED)
def test_what_one_is_asked_to_try(name: str, settings: dict[str, str], said: str) -> None:
    assert french(said) in summary(name, settings)


def test_every_replay_has_its_question_held() -> None:
    assert {name for name, *_ in HOLDS} == set(REPLAYS.replay_names("l19"))


def test_no_imposed_gain_ends_with_less_doubt_than_kalman_s() -> None:
    def last(**settings: str) -> float:
        return float(scene_of("l19", "rail", settings)["charts"][0]["series"][0]["y"][-1])

    best = last()
    assert all(last(impose="1", gain=f"{gain:.2f}") > best - 1e-9 for gain in np.arange(0.0, 1.01, 0.05))


def test_the_bell_under_the_eye_has_the_announced_width() -> None:
    body = scene_of("l19", "rail", {})
    announced = body["charts"][0]["series"][0]["y"]
    areas = []
    for frame, sigma in zip(body["frames"], announced, strict=True):
        bell = unpacked(layer(frame["layers"], "polyline", color="estimate")["at"])
        assert bell[-1, 0] - bell[0, 0] == pytest.approx(8 * sigma, abs=0.01)
        areas.append(np.trapezoid(bell[:, 1], bell[:, 0]))
    assert areas == pytest.approx([areas[0]] * len(areas), rel=0.02)


def test_the_arrow_under_the_rail_is_the_gain() -> None:
    body = scene_of("l19", "rail", {})
    gains = body["charts"][1]["series"][1]["y"]
    for frame, gain in zip(body["frames"][2::2], gains, strict=True):
        whole = unpacked(layer(frame["layers"], "segments", color="measure")["at"])[0]
        part = unpacked(layer(frame["layers"], "segments", color="estimate")["at"])[0]
        assert part[2] - part[0] == pytest.approx(gain * (whole[2] - whole[0]), abs=2e-3)


def test_the_band_of_the_chart_is_that_of_fifty_runs() -> None:
    levels = [level["y"] for level in scene_of("l19", "coherence", {})["charts"][0]["levels"]]
    low, high = mean_nees_band(coherence.RUNS)
    assert levels == pytest.approx([low, high], abs=1e-3)


def test_honest_filters_are_rarely_accused() -> None:
    verdicts = [summary("coherence", {"pas": "1", "tirage": str(seed)}) for seed in range(20)]
    assert sum("Rien ne le distingue" in one for one in verdicts) >= 18


def test_the_extended_filter_is_honest_where_it_doubts_little() -> None:
    nees = []
    for seed in range(8):
        (series,) = scene_of("l19", "balises", {"balises": "3", "depart": "0.4", "tirage": str(seed)})["charts"][1][
            "series"
        ]
        nees += series["y"][1::2]
    assert np.mean(nees) == pytest.approx(2.0, abs=0.5)


def test_steps_are_counted_as_the_charts_count_them() -> None:
    assert len(scene_of("l19", "rail", {})["frames"]) == 2 * rail.STEPS + 1
    assert len(scene_of("l19", "balises", {})["frames"]) == 2 * balises.STEPS + 2
