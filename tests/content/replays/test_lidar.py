"""Replay 1: the rays are those of the reference, and of the kit that students have."""

from __future__ import annotations

import runpy

import numpy as np
import pytest

from reference.world.raycast import cast_scans
from server.base.files import ROOT
from tests.support.replays import cells, layer, scene, unpacked

KIT = runpy.run_path(str(ROOT / "curriculum/l20/kit/l20.py"))


@pytest.mark.parametrize("pose", ["11.5,8.2,0.35", "3.5,3.5,-2.0", "20.1,13.2,3.0"])
@pytest.mark.parametrize("reach", [4, 24])
def test_rays_stop_where_the_reference_says(pose: str, reach: int) -> None:
    body = scene("lidar", pose=pose, portee=reach, rayons=48)
    at = layer(body["over"], "pose", drag="pose")["at"]
    rays = layer(body["layers"], "rays")
    lengths = np.linalg.norm(unpacked(rays["ends"]) - at[:2], axis=1)
    expected = cast_scans(KIT["libres"], [at], 48, reach)[0]
    np.testing.assert_allclose(lengths, expected, atol=2e-3)
    np.testing.assert_array_equal(unpacked(rays["hits"]) > 0.5, expected < reach)
    np.testing.assert_allclose(body["charts"][0]["series"][0]["y"], expected, atol=5e-3)
    assert rays["until"][-1] == len(expected) == len(body["frames"])


def test_the_map_is_that_of_the_kit() -> None:
    walls = layer(scene("lidar")["layers"], "grid")
    np.testing.assert_array_equal(cells(walls) > 0.5, ~KIT["libres"])


def test_noise_is_shown_beside_the_exact_scan() -> None:
    series = scene("lidar", bruit=0.5, rayons=180)["charts"][0]["series"]
    by_color = {one["color"]: np.array(one["y"]) for one in series}
    exact, read = by_color["truth"], by_color["measure"]
    assert 0.3 < np.std((read - exact)[exact < 9]) < 0.7


def test_a_robot_put_in_a_wall_stands_beside_it() -> None:
    for pose in ("7.5,1.5,0.0", "0,0,0", "24,16,0", "4.0,13.0,1.0"):
        x, y, _ = layer(scene("lidar", pose=pose)["over"], "pose")["at"]
        assert KIT["libres"][int(y), int(x)]
        wanted = [float(part) for part in pose.split(",")[:2]]
        assert np.hypot(x - wanted[0], y - wanted[1]) < 2.0
