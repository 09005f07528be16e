"""Replay 7: A* finds what Dijkstra finds, its ways keep clear of walls, and a robot too wide is told so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.replays import cells, layer, scene, unpacked

FINE = 3


def path(**settings: Any) -> np.ndarray:
    return unpacked(layer(scene("a-etoile", **settings)["over"], "polyline")["at"])


def length(points: np.ndarray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def explored(**settings: Any) -> int:
    grid = next(one for one in scene("a-etoile", **settings)["layers"] if one.get("palette") == "order")
    return int(np.count_nonzero(cells(grid)))


@pytest.mark.parametrize("goal", ["20.5,2.5,0", "12.5,12.5,0", "3.5,14.0,0", "22.0,14.0,0"])
@pytest.mark.parametrize("price", [0, 3, 20])
def test_a_star_costs_what_dijkstra_costs_and_looks_at_less(goal: str, price: int) -> None:
    settings = {"but": goal, "prudence": price}
    summary = " ".join(scene("a-etoile", **settings)["summary"])
    assert "coûte le moins possible" in summary
    assert explored(**settings) <= explored(**settings, methode="dijkstra")
    if price == 0:
        assert length(path(**settings)) == pytest.approx(length(path(**settings, methode="dijkstra")), abs=0.01)


def test_a_weight_looks_at_less_and_costs_more() -> None:
    counts = [explored(methode=name) for name in ("dijkstra", "a-etoile", "pondere2", "pondere5")]
    assert counts == sorted(counts, reverse=True)
    assert "% de plus que le meilleur" in " ".join(scene("a-etoile", methode="pondere5")["summary"])


@pytest.mark.parametrize("radius", [0, 0.25, 0.5, 0.75, 1.0])
def test_the_way_is_connected_and_keeps_the_radius(radius: float) -> None:
    body = scene("a-etoile", rayon=radius)
    walls = next(one for one in body["layers"] if one.get("palette") == "walls")
    blocked = cells(walls) > 0.5
    points = path(rayon=radius)
    assert np.abs(np.diff(points, axis=0)).max() < 1.01 / FINE
    columns, rows = np.floor(points * FINE).astype(int).T
    assert not blocked[rows, columns].any()
    away = np.array(body["charts"][0]["series"][0]["y"])
    assert away.min() >= radius - 0.5 / FINE
    assert len(away) == len(points)


def test_a_wide_robot_goes_round_and_a_wider_one_nowhere() -> None:
    assert length(path(rayon=0.75)) > 1.3 * length(path(rayon=0.5))
    body = scene("a-etoile", rayon=1.5)
    assert not body["charts"]
    assert "aucun passage" in body["summary"][0]


def test_cheaper_walls_are_passed_nearer() -> None:
    near, far = (np.array(scene("a-etoile", prudence=p)["charts"][0]["series"][0]["y"]) for p in (0, 20))
    assert near.min() < far.min()
