"""Replay 4: maps hold what was seen; true poses make a better one than drifting odometry."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.support.replays import cells, layer, scene


def last_map(**settings: Any) -> np.ndarray:
    return cells(layer(scene("occupation", **settings)["frames"][-1]["layers"], "grid"))


def scores(**settings: Any) -> dict[str, list[float]]:
    series = scene("occupation", **settings)["charts"][0]["series"]
    return {one["color"]: one["y"] for one in series}


def test_knowledge_grows_and_true_poses_make_the_better_map() -> None:
    true, drifting = scores(poses="vraies"), scores(poses="odometrie")
    for found in (true, drifting):
        assert found["measure"][0] < 40
        assert found["measure"][-1] > 70
    assert true["alert"][-1] < 4
    assert drifting["alert"][-1] > 3 * true["alert"][-1]
    assert scores(poses="odometrie", derive=0) == scores(poses="vraies", derive=0)


def test_the_gap_is_the_difference_of_the_two_maps() -> None:
    gap = last_map(poses="ecart")
    expected = (last_map(poses="odometrie") - last_map(poses="vraies") + 1) / 2
    np.testing.assert_allclose(gap, expected, atol=0.03)


def test_the_scans_do_not_depend_on_the_poses_that_are_believed() -> None:
    true, drifting = (scene("occupation", poses=mode)["frames"] for mode in ("vraies", "odometrie"))
    assert layer(true[0]["layers"], "rays") == layer(drifting[0]["layers"], "rays")
    where = [layer(frame["layers"], "pose", color="truth")["at"] for frame in true]
    assert where == [layer(frame["layers"], "pose", color="truth")["at"] for frame in drifting]


def test_unknown_cells_are_half_way() -> None:
    first = cells(layer(scene("occupation", poses="vraies", portee=3)["frames"][0]["layers"], "grid"))
    assert np.mean(np.abs(first - 0.5) < 0.02) > 0.8
    assert first.min() < 0.35
    assert first.max() > 0.65
