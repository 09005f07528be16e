"""The three filters on one crescent: what the page says of them, and that the honest ones are told so."""

from __future__ import annotations

import re

import numpy as np

from tests.support.replays import cells, layer, scene, unpacked


def mean_nees(**settings: object) -> list[float]:
    told = next(one for one in scene("banane-mesuree", **settings)["summary"] if "NEES moyen" in one)
    return [float(one.replace(",", ".")) for one in re.findall(r"([\d,]+) pour", told)]


def test_the_tangent_is_overconfident_where_the_crescent_bends_and_not_where_it_is_straight() -> None:
    bent, straight = mean_nees(), mean_nees(cap=5)
    assert bent[0] > 20.0
    assert max(bent[1:]) < 5.0
    assert all(1.4 < one < 3.0 for one in straight)


def test_a_curve_above_the_dashes_is_a_filter_that_is_too_sure() -> None:
    chart = scene("banane-mesuree")["charts"][0]
    curves = {one["label"]: np.array(one["y"], dtype=float) for one in chart["series"]}
    honest = next(curve for label, curve in curves.items() if "honnête" in label)
    assert np.all(np.diff(honest) < 0.0)
    assert abs(honest[20] - 100 * np.exp(-2.0)) < 0.1
    assert np.all(curves["EKF"][20:] > honest[20:] + 10.0)
    assert np.mean(np.abs(curves["particules"] - honest)) < 8.0


def test_from_the_beacon_on_its_way_two_pieces_of_the_crescent_are_left() -> None:
    body = scene("banane-mesuree", balise="0,5,0")
    across = cells(layer(body["frames"][6]["layers"], "grid")).max(axis=0) > 0.25
    assert np.sum(np.diff(across.astype(int)) == 1) == 2
    assert len(unpacked(layer(body["frames"][7]["layers"], "points")["weights"])) == 500
