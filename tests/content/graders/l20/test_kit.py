"""The kit of module L20: what students may call, against a naive ray march, and the contract's edges."""

import math
from typing import Any

import numpy as np
import pytest

from graders.core.contract.local import kit_source
from graders.l20 import world


@pytest.fixture
def kit() -> Any:
    names: dict[str, Any] = {"__name__": "l20"}
    exec(compile(kit_source("l20"), "l20.py", "exec"), names)
    return names


def test_the_names_of_the_contract_are_there(kit: Any) -> None:
    found = kit["configurer"]()
    assert set(found) == {"np", "H", "W", "libres", "PORTEE_MAX", "rng", "lidar", "lidar_lot"}
    assert isinstance(found["rng"], np.random.Generator)
    assert found["libres"].shape == (found["H"], found["W"])
    assert found["libres"].dtype == bool


def march(libres: np.ndarray, x: float, y: float, angle: float, reach: float, step: float = 1e-3) -> float:
    """Walk along the ray by small steps: slow, and right to a step."""
    height, width = libres.shape
    for k in range(int(reach / step) + 1):
        column, row = math.floor(x + k * step * math.cos(angle)), math.floor(y + k * step * math.sin(angle))
        if not (0 <= row < height and 0 <= column < width) or not libres[row, column]:
            return k * step
    return reach


def test_rays_agree_with_a_naive_march(kit: Any) -> None:
    rng = np.random.default_rng(5)
    libres = world.random_map(rng, 10, 13)
    names = kit["configurer"](libres=libres, portee_max=6.0, seed=1)
    differing = 0
    for y, x in rng.permutation(world.free_cells(libres))[:25]:
        pose = (x + rng.uniform(0.1, 0.9), y + rng.uniform(0.1, 0.9), rng.uniform(-3, 3))
        scan = names["lidar"](pose, 8)
        marched = [march(libres, pose[0], pose[1], pose[2] + math.tau * k / 8, 6.0) for k in range(8)]
        differing += int(np.sum(np.abs(scan - marched) > 3e-3))
    assert differing <= 2  # a ray that clips a corner by less than a step may slip past the march


def test_one_scan_and_a_batch_are_the_same(kit: Any) -> None:
    rng = np.random.default_rng(2)
    poses = np.c_[rng.uniform(-2, 26, 200), rng.uniform(-2, 18, 200), rng.uniform(-3, 3, 200)]
    single = np.array([kit["lidar"](pose, 12) for pose in poses])
    assert np.abs(single - kit["lidar_lot"](poses, 12)).max() < 1e-9


def test_from_inside_a_wall_or_outside_every_ray_reads_zero(kit: Any) -> None:
    for pose in ((0.5, 0.5, 0.0), (-3.0, 2.0, 1.0), (1e6, -1e6, 0.0)):
        assert np.array_equal(kit["lidar"](pose, 5), np.zeros(5))
        assert np.array_equal(kit["lidar_lot"]([pose], 5), np.zeros((1, 5)))


def test_a_ray_that_hits_nothing_reads_the_range(kit: Any) -> None:
    names = kit["configurer"](libres=np.ones((40, 40), dtype=bool), portee_max=5.0, seed=1)
    assert np.array_equal(names["lidar"]((20.0, 20.0, 0.3), 7), np.full(7, 5.0))


def test_rays_turn_with_the_heading(kit: Any) -> None:
    scan = kit["lidar"]((4.3, 8.2, 0.0), 36)
    turned = kit["lidar"]((4.3, 8.2, 5 * math.tau / 36), 36)
    assert np.allclose(turned, np.roll(scan, -5))


def test_noise_is_drawn_from_the_seed_and_stays_in_range(kit: Any) -> None:
    scans = [kit["configurer"](seed=s)["lidar"]((4.5, 8.2, 0.0), 36, 0.3) for s in (1, 1, 2)]
    assert np.array_equal(scans[0], scans[1])
    assert not np.array_equal(scans[0], scans[2])
    assert scans[0].min() >= 0.0
    assert scans[0].max() <= 12.0


def test_noise_moves_what_a_ray_hit_and_leaves_the_range_of_those_that_hit_nothing(kit: Any) -> None:
    names = kit["configurer"](portee_max=5.0, seed=3)
    clean = names["lidar"]((4.5, 8.2, 0.0), 90)
    noisy = names["lidar"]((4.5, 8.2, 0.0), 90, 0.3)
    hit = clean < 5.0
    assert 10 < hit.sum() < 80
    assert np.array_equal(noisy[~hit], clean[~hit])
    assert (noisy[hit] != clean[hit]).mean() > 0.95


def test_the_map_of_the_student_cannot_move_the_walls_of_the_lidar(kit: Any) -> None:
    names = kit["configurer"](seed=1)
    before = names["lidar"]((4.5, 8.2, 0.0))
    names["libres"][:] = True
    assert np.array_equal(names["lidar"]((4.5, 8.2, 0.0)), before)


def test_the_module_map_is_one_piece_and_tells_its_cells_apart(kit: Any) -> None:
    from scipy import ndimage

    libres = kit["libres"]
    assert ndimage.label(libres)[1] == 1
    assert not libres[[0, -1]].any()
    assert not libres[:, [0, -1]].any()
    cells = world.free_cells(libres)
    scans = kit["lidar_lot"](np.c_[cells[:, 1] + 0.5, cells[:, 0] + 0.5, np.zeros(len(cells))], 4)
    assert len(np.unique(scans.round(6), axis=0)) > 0.85 * len(cells)
