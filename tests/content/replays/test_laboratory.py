"""The replay of the real place: what was measured there, loops that are accepted, refused and false."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.support.replays import scene, unpacked


def error(**settings: object) -> float:
    """The last one told, in metres."""
    found = re.search(r"(\d+,\d+) m", str(scene("laboratoire", **settings)["summary"][-1]))
    assert found
    return float(found[1].replace(",", "."))


def test_each_step_of_the_practical_work_comes_to_what_its_page_says() -> None:
    told = {"odometrie": 10.82, "etalonnee": 0.81, "recalages": 0.21, "graphe": 0.10}
    assert {mode: error(poses=mode) for mode in told} == pytest.approx(told, abs=0.015)


def test_false_loops_are_worse_than_none() -> None:
    """What the page says, and the explanation of the prediction."""
    errors = [error(poses="graphe", ecart=allowed) for allowed in ("0", "0.6", "1.0", "1.2", "2.2")]
    assert errors == pytest.approx([0.21, 0.10, 0.16, 0.30, 0.54], abs=0.015)
    assert scene("laboratoire", ecart="0")["summary"][0] == "Aucune boucle acceptée sur 23."
    assert scene("laboratoire", ecart="0")["frames"][-1]["caption"].endswith("Aucune boucle acceptée sur 23.")
    assert scene("laboratoire", ecart="2.2")["summary"][0] == "23 boucles acceptées sur 23, dont 7 fausses."
    assert scene("laboratoire")["summary"][0] == "16 boucles acceptées sur 23, dont aucune fausse."


def test_loops_are_drawn_as_they_are_met() -> None:
    frames = scene("laboratoire", ecart="1.0")["frames"]
    assert sum(layer["kind"] == "segments" for layer in frames[40]["layers"]) == 3
    captions = [frame["caption"] for frame in frames]
    assert "boucle" not in captions[40]
    assert captions[-1].endswith("18 boucles acceptées sur 23.")
    assert "boucle" not in scene("laboratoire", poses="recalages")["frames"][-1]["caption"]


@pytest.mark.parametrize("poses", ["odometrie", "graphe"])
def test_nothing_is_cut_at_the_frame(poses: str) -> None:
    body = scene("laboratoire", poses=poses)
    x0, y0, x1, y1 = body["box"]
    layers = [*body["layers"], *body["frames"][-1]["layers"]]
    points = np.vstack([unpacked(layer["at"]) for layer in layers if layer["kind"] in ("points", "polyline")])
    assert np.all(points > [x0, y0])
    assert np.all(points < [x1, y1])


def test_settings_are_shown_only_where_they_act() -> None:
    conditions = {one["name"]: one.get("onlyWith") for one in scene("laboratoire")["parameters"]}
    assert conditions == {
        "trajet": None,
        "poses": {"trajet": ["tp"]},
        "ecart": {"trajet": ["tp"], "poses": ["graphe"]},
    }


def test_the_map_of_the_log_grows_beside_ours() -> None:
    body = scene("laboratoire")
    assert body["panels"] == ["Notre carte", "Celle du journal"]
    theirs = next(layer for layer in body["layers"] if layer["kind"] == "points")
    assert np.all(np.diff(theirs["until"]) > 0)
    assert theirs["until"][-1] == len(unpacked(theirs["at"]))
    ours = [next(layer for layer in frame["layers"] if layer["kind"] == "points") for frame in body["frames"]]
    assert [len(unpacked(layer["at"])) for layer in ours] == theirs["until"]


def test_the_whole_log_is_mapped_beside_its_own_map() -> None:
    body = scene("laboratoire", trajet="entier")
    assert body["panels"] == ["Notre carte", "Celle du journal"]
    assert body["frames"][-1]["caption"].startswith("Scan 910")
    assert error(trajet="entier") == pytest.approx(0.09, abs=0.005)
    (drawn,) = [layer for layer in body["layers"] if layer["kind"] == "segments"]
    assert drawn["until"][0] == 0
    assert np.all(np.diff(drawn["until"]) >= 0)
