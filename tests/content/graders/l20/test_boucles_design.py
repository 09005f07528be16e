"""The design of l20/boucles: places told apart, walks and traps as they are meant, thresholds found when they exist."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from graders.core.code.bench import Bench
from graders.core.code.runner import Runner
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.boucles import calibration, family, lookalikes, scenes, walks
from graders.l20.boucles.calibration import Outcome as Ending
from graders.l20.boucles.places import module_map, module_pool
from tests.support.quick import some


def test_shifted_scans_are_those_of_the_lidar() -> None:
    """What the grader obtains by rolling a scan, a student sees by asking the lidar at the pose that is shown."""
    pool = module_pool(5)
    walk = walks.draw_walk(np.random.default_rng(5), pool, with_noise=False, strict=False)
    source = "def scan_de(pose):\n    return lidar(pose)\n"
    program = LOCAL.open(source.encode(), KitSettings(world.MODULE, {"libres": module_map(), "seed": 1}))
    for pose, scan in zip(walk.poses, walk.scans, strict=True):
        np.testing.assert_allclose(program.call("scan_de", pose).value, scan, atol=1e-9)


def test_walks_keep_what_the_contract_says_of_them() -> None:
    for seed in range(8):
        walk = walks.draw_walk(np.random.default_rng(seed), module_pool(seed), with_noise=True, strict=False)
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
        walk = walks.draw_trap(np.random.default_rng(seed), module_pool(seed), statistic, name)
        i = walk.queries[0]
        away = np.abs(statistic(walk.scans) - statistic(walk.scans[i : i + 1]))[: i - walks.GAP + 1]
        same = walk.same_place(i)[0]
        assert np.min(np.delete(away, same)) < away[same] / 2.0
        assert walks.separable(walk)


def spectrum(scans: Floats) -> Floats:
    return np.abs(np.fft.rfft(scans, axis=1))


def statistics(scans: Floats) -> Floats:
    return np.stack([scans.mean(axis=1), scans.std(axis=1), scans.min(axis=1), scans.max(axis=1)], axis=1)


def quartiles(scans: Floats) -> Floats:
    return np.percentile(scans, (0, 25, 50, 75, 100), axis=1).T


def boxes(bins: int) -> Callable[[Floats], Floats]:
    return lambda scans: np.array([np.histogram(scan, bins, (0.0, world.RANGE))[0] for scan in scans], dtype=float)


def norm(describe: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    return lambda scans: np.linalg.norm(describe(scans), axis=1)


#: The number that is compared where the signatures should be, by what a look-alike is for.
NUMBERS: dict[str, Callable[[Floats], Floats]] = {
    "mean": lambda scans: scans.mean(axis=1),
    "std": lambda scans: scans.std(axis=1),
    "longest": lambda scans: scans.max(axis=1),
    "shortest": lambda scans: scans.min(axis=1),
    "median": lambda scans: np.median(scans, axis=1),
    "span": lambda scans: np.ptp(scans, axis=1),
    "sum of squares": norm(lambda scans: scans),
    "first harmonic": lambda scans: spectrum(scans)[:, 1],
    "last harmonic": lambda scans: spectrum(scans)[:, -1],
    "largest harmonic": lambda scans: spectrum(scans)[:, 1:].max(axis=1),
    "norm of the spectrum": norm(spectrum),
    "sum of the spectrum": lambda scans: spectrum(scans).sum(axis=1),
    "sum of both sides": lambda scans: np.abs(np.fft.fft(scans, axis=1)).sum(axis=1),
    "norm without the mean": norm(lambda scans: spectrum(scans)[:, 1:]),
    "norm of the power": norm(lambda scans: spectrum(scans) ** 2),
    "norm of four statistics": norm(statistics),
    "sum of four statistics": lambda scans: statistics(scans).sum(axis=1),
    "sum of mean and std": lambda scans: statistics(scans)[:, :2].sum(axis=1),
    "norm of the quartiles": norm(quartiles),
    "sum of the quartiles": lambda scans: quartiles(scans).sum(axis=1),
    "first lag": lambda scans: (scans * np.roll(scans, 1, axis=1)).sum(axis=1),
    **{f"norm of {bins} boxes": norm(boxes(bins)) for bins in (10, 12, 20)},
}


#: Distances, not of a number, that mistaken programs compute from a scan (36,) to others (m, 36).
MISTAKEN: dict[str, Callable[[Floats, Floats], Floats]] = {
    "one rank": lambda a, b: np.abs(np.sort(b) - np.sort(a)).min(axis=1),
    "one amplitude": lambda a, b: np.abs(spectrum(b) - spectrum(a[None])).min(axis=1),
    "no longer, once sorted": lambda a, b: np.abs((np.sort(b) - np.sort(a)).max(axis=1)),
    "no shorter, once sorted": lambda a, b: np.abs((np.sort(a) - np.sort(b)).max(axis=1)),
    "no stronger": lambda a, b: np.abs((spectrum(b) - spectrum(a[None])).max(axis=1)),
    "no weaker": lambda a, b: np.abs((spectrum(a[None]) - spectrum(b)).max(axis=1)),
    **{f"one more in some of {n} boxes": partial(lambda of, a, b: (of(b) - of(a[None])).max(axis=1), boxes(n))
       for n in (10, 12)},
    **{f"one less in some of {n} boxes": partial(lambda of, a, b: (of(a[None]) - of(b)).max(axis=1), boxes(n))
       for n in (10, 12)},
    "lower": lambda a, b: np.maximum((np.sort(b) - np.sort(a)).max(axis=1), (spectrum(b) - spectrum(a[None])).max(1)),
    "higher": lambda a, b: np.maximum((np.sort(a) - np.sort(b)).max(axis=1), (spectrum(a[None]) - spectrum(b)).max(1)),
}  # fmt: skip


@pytest.mark.parametrize("again", range(len(lookalikes.HERE)))
def test_each_lookalike_is_as_near_by_what_it_is_for_and_twice_farther_by_the_family(again: int) -> None:
    walk = lookalikes.lookalikes(again)
    asked, same = walk.scans[walk.queries[0]], walk.scans[:1]
    assert walk.same_place(walk.queries[0]) == [0]
    assert walks.separable(walk, 2.0)
    assert walks.mistakes_fail(walk)
    for j, (purpose, _, _) in enumerate(lookalikes.OTHERS, start=1):
        if purpose in NUMBERS:
            number = NUMBERS[purpose]
            other, again_there = (abs(float((number(z) - number(asked[None]))[0])) for z in (walk.scans[[j]], same))
        else:
            other, again_there = (float(MISTAKEN[purpose](asked, z)[0]) for z in (walk.scans[[j]], same))
        assert other <= again_there, purpose


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
