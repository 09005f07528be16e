"""The design of l20/boucles: places told apart, walks and traps as they are meant, thresholds found when they exist."""

from __future__ import annotations

import numpy as np
import pytest

from graders.core.code.bench import Bench, Runner
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings
from graders.l20 import world
from graders.l20.boucles import calibration, family, scenes, walks
from graders.l20.boucles.calibration import Outcome as Ending
from graders.l20.boucles.places import module_map, module_pool
from tests.support.quick import some


def test_shifted_scans_are_those_of_the_lidar() -> None:
    """What the grader obtains by rolling a scan, a student sees by asking the lidar at the pose that is shown."""
    pool = module_pool(5)
    walk = walks.draw_walk(np.random.default_rng(5), pool, with_noise=False)
    source = "def scan_de(pose):\n    return lidar(pose)\n"
    program = LOCAL.open(source.encode(), KitSettings(world.MODULE, {"libres": module_map(), "seed": 1}))
    for pose, scan in zip(walk.poses, walk.scans, strict=True):
        np.testing.assert_allclose(program.call("scan_de", pose).value, scan, atol=1e-9)


def test_walks_keep_what_the_contract_says_of_them() -> None:
    for seed in range(8):
        walk = walks.draw_walk(np.random.default_rng(seed), module_pool(seed), with_noise=True)
        assert np.all(np.abs(walk.poses[:, 2]) <= np.pi)
        assert np.all(np.abs(walk.poses[:, :2] % 1.0 - 0.5) >= 0.09)
        assert np.all((walk.scans >= 0.0) & (walk.scans <= world.RANGE))
        for i in some(walk.queries):
            assert len(walk.same_place(i)) == 2
            assert i - walks.GAP not in walk.same_place(i)


@pytest.mark.parametrize("name", scenes.TRAPS)
def test_in_a_trap_the_other_place_is_nearer_by_the_shared_number(name: str) -> None:
    statistic = scenes.TRAPS[name]
    for seed in range(10):
        walk = walks.draw_trap(np.random.default_rng(seed), module_pool(seed), statistic)
        i = walk.queries[0]
        away = np.abs(statistic(walk.scans) - statistic(walk.scans[i : i + 1]))[: i - walks.GAP + 1]
        same = walk.same_place(i)[0]
        assert np.min(np.delete(away, same)) < away[same] / 2.0
        assert walks.separable(walk)


def test_one_threshold_is_found_when_there_is_one_and_only_then() -> None:
    """The search against a function whose distances are known: found between them, mixed when they cross."""
    pool = module_pool(2)
    places = np.array([0, 1, 2, 3, *range(4, 13), 0])
    walk = walks.seen(np.random.default_rng(0), pool, places, (13,), noise=0.0)
    endings = {
        (1e-9, 2e-9): Ending.FOUND,
        (3e7, 4e7): Ending.FOUND,
        (0.0, 1e-20): Ending.FOUND,
        (0.0, 0.0): Ending.ALWAYS,
        (5.0, 4.0): Ending.MIXED,
        (5.0, 5.0): Ending.MIXED,
        (float("inf"), 1.0): Ending.NEVER,
        (float("inf"), float("inf")): Ending.NEVER,
        (1.0, -1.0): Ending.ALWAYS,
    }
    for (same, other), ending in endings.items():
        source = f"""
def candidats_boucle(scans, i, seuil):
    inf = float("inf")
    near = [np.array_equal(np.sort(scan), np.sort(scans[i])) for scan in scans[:4]]
    return [j for j, same in enumerate(near) if ({same} if same else {other}) <= seuil]
"""
        kit = world.kit(np.random.default_rng(0))
        bench = Bench("essai", Runner(LOCAL, source.encode(), kit), np.random.default_rng(0), kit)
        assert calibration.calibrate(bench, walk).outcome is ending, (same, other)


def test_the_family_is_invariant_and_tells_places_apart() -> None:
    scans = module_pool(3).scans[:12]
    for name, describe in some(family.DESCRIPTORS.items()):
        np.testing.assert_allclose(describe(np.roll(scans, 7, axis=1)), describe(scans), atol=1e-7, err_msg=name)
        for distance in some(family.DISTANCES.values()):
            away = distance(describe(scans), describe(scans))
            assert np.all(np.diag(away) <= 1e-6)
