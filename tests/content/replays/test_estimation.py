"""Replays 5 and 6: the errors of ICP never grow, those of the graph fall, and a false closure is resisted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.replays import layer, scene, unpacked


def gaps(**settings: Any) -> np.ndarray:
    return np.array(scene("icp", **settings)["charts"][0]["series"][0]["y"])


@pytest.mark.parametrize(
    "settings",
    [{}, {"rotation": 120}, {"rotation": -180, "dx": 4}, {"intrus": 40}, {"intrus": 40, "elagage": 1}, {"bruit": 0.3}],
)
def test_the_error_of_icp_never_grows(settings: dict[str, Any]) -> None:
    found = gaps(**settings)
    assert np.all(np.diff(found) <= 5e-4 * found[:-1] + 1e-9)  # four digits are sent
    assert found[-1] < found[0]


def test_icp_ends_well_from_near_and_in_a_local_minimum_from_afar() -> None:
    assert "bon" in " ".join(scene("icp")["summary"])
    assert "minimum local" in " ".join(scene("icp", rotation=180)["summary"])
    ends = scene("icp")["charts"][1]["series"][0]
    by_angle = dict(zip(ends["x"], ends["y"], strict=True))
    assert by_angle[0] < 4
    assert by_angle[180] > 90


@pytest.mark.parametrize("rotation", [45, 60, -120])
def test_the_chart_of_all_starts_ends_where_the_animation_does(rotation: int) -> None:
    body = scene("icp", rotation=rotation)
    ends = body["charts"][1]["series"][0]
    reached = layer(body["frames"][-1]["layers"], "pose")["at"][2]
    away = np.degrees(abs(np.angle(np.exp(1j * (reached - 0.4)))))
    assert dict(zip(ends["x"], ends["y"], strict=True))[rotation] == pytest.approx(away, abs=0.2)


@pytest.mark.parametrize("settings", [{}, {"rotation": 45}])
def test_what_icp_tells_is_what_its_chart_shows(settings: dict[str, Any]) -> None:
    found = [f"{gaps(**settings)[k]:.2f} case".replace(".", ",") for k in (0, -1)]
    told = scene("icp", **settings)["summary"][0].replace("\xa0", " ").replace("\u202f", " ")
    assert f"passe de {found[0]} à {found[1]}" in told


def test_keeping_the_shortest_pairs_resists_intruders() -> None:
    settings = {"intrus": 40, "rotation": 15, "dx": 0.5, "dy": 0.5}
    poses = [
        np.array(layer(scene("icp", **settings, elagage=kept)["frames"][-1]["layers"], "pose")["at"]) for kept in (0, 1)
    ]
    away = [np.hypot(*(pose - [11.4, 3.9, 0.4])[:2]) for pose in poses]
    assert away[1] < away[0] / 2


def test_pairs_join_the_points_that_are_shown() -> None:
    body = scene("icp")
    blue = unpacked(layer(body["layers"], "points")["at"])
    for frame in body["frames"]:
        points = unpacked(layer(frame["layers"], "points")["at"])
        pairs = unpacked(layer(frame["layers"], "segments", color="measure")["at"])
        np.testing.assert_allclose(pairs[:, :2], points, atol=2e-3)
        assert np.abs(pairs[:, None, 2:] - blue).max(axis=2).min(axis=1).max() < 2e-3
    away = np.linalg.norm(pairs[:, None, 2:] - points, axis=2)
    assert away.shape[0] == len(points)


def costs(**settings: Any) -> np.ndarray:
    return np.array(scene("graphe", **settings)["charts"][0]["series"][0]["y"])


def errors(**settings: Any) -> np.ndarray:
    return np.array(scene("graphe", **settings)["charts"][1]["series"][0]["y"])


@pytest.mark.parametrize("draw", [0, 1, 2, 3])
def test_the_graph_comes_to_agree(draw: int) -> None:
    found = costs(tirage=draw, fermetures=10)
    assert np.all(np.diff(found) <= 1e-3 * found[:-1])
    assert found[-1] < found[0] / 5
    assert errors(tirage=draw, fermetures=10)[-1] < errors(tirage=draw, fermetures=10)[0]


def test_without_a_closure_nothing_moves() -> None:
    body = scene("graphe", fermetures=0)
    first, last = (unpacked(layer(body["frames"][k]["layers"], "polyline")["at"]) for k in (0, -1))
    np.testing.assert_allclose(first, last, atol=2e-3)


@pytest.mark.parametrize("draw", [1, 2, 3])
def test_a_false_closure_bends_the_map_unless_a_kernel_resists(draw: int) -> None:
    plain = errors(tirage=draw, fausse=1, fermetures=6)
    robust = errors(tirage=draw, fausse=1, fermetures=6, noyau="dcs")
    assert plain[-1] > 3.0
    assert robust[-1] < 1.0
    assert robust[-1] == pytest.approx(errors(tirage=draw, fermetures=6, noyau="dcs")[-1], abs=0.05)
    last = scene("graphe", tirage=draw, fausse=1, noyau="dcs")["frames"][-1]
    assert layer(last["layers"], "segments", color="alert")["dashed"]


def test_the_seen_points_follow_the_poses() -> None:
    frames = scene("graphe")["frames"]
    seen = [unpacked(layer(frame["layers"], "points", color="ink")["at"]) for frame in frames]
    assert len({len(points) for points in seen}) == 1
    np.testing.assert_array_equal(seen[0], seen[1])  # closures are shown before anything moves
    assert np.abs(seen[-1] - seen[1]).max() > 0.3
