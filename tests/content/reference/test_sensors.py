"""Sensor models: total probability by quadrature, EM on samples of known origin, fields by brute force."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import kstest, truncexpon, truncnorm

from reference.errors import InvalidArgumentError
from reference.se2 import compose
from reference.sensors.beam import BeamModel, BeamSensor, plain_densities
from reference.sensors.beam_learning import learn_beam_model, responsibilities
from reference.sensors.likelihood_field import LikelihoodField
from reference.sensors.rays import thin_scan
from reference.world.grid_map import GridMap
from reference.world.raycast import cast_scans
from reference.world.scan import Scan

MODEL = BeamModel(max_range=8.0, hit=0.6, short=0.2, beyond=0.05, random=0.15, sigma=0.3, rate=0.7)


def room() -> GridMap:
    """6 m by 4 m of 0.1 m cells, walls of two cells, a pillar, turned and moved in the world."""
    free = np.zeros((40, 60), dtype=bool)
    free[2:-2, 2:-2] = True
    free[10:16, 20:26] = False
    return GridMap.from_free(free, 0.1, (1.0, -2.0, 0.4))


def scan_from(grid_map: GridMap, pose: np.ndarray, beams: int = 30, max_range: float = 8.0) -> Scan:
    cells = grid_map.poses_to_cells(pose[None, :])
    ranges = cast_scans(grid_map.free, cells, beams, max_range / grid_map.resolution)[0] * grid_map.resolution
    return Scan.full_turn(np.minimum(ranges, max_range), max_range)


@pytest.mark.parametrize("expected", [0.4, 3.0, 7.8, 8.0])
def test_the_total_probability_is_one(expected: float) -> None:
    """Density over [0, max_range[ plus the mass at max_range; the kinks are given to the quadrature."""
    below = quad(lambda z: math.exp(MODEL.log_density(z, expected)), 0.0, 8.0 - 1e-12, points=[expected], limit=200)[0]
    assert below + math.exp(MODEL.log_density(8.0, expected)) == pytest.approx(1.0, abs=1e-7)


def test_each_cause_has_the_density_of_scipy() -> None:
    z, expected = np.linspace(0.05, 7.9, 40), 5.0
    hit, short, beyond, random = MODEL.cause_densities(z, expected)
    assert np.allclose(hit, truncnorm.pdf(z, -5.0 / 0.3, np.inf, loc=5.0, scale=0.3))
    assert np.allclose(short, truncexpon.pdf(z, 5.0 * 0.7, scale=1 / 0.7))
    assert not beyond.any()
    assert np.allclose(random, 1 / 8.0)
    assert np.allclose(np.exp(MODEL.log_density(z, expected)), 0.6 * hit + 0.2 * short + 0.15 * random)


@pytest.mark.parametrize("expected", [1.0, 7.9, 8.0])
def test_samples_are_drawn_from_the_model(expected: float) -> None:
    """The share at full range, and the law of the shorter ones by Kolmogorov and Smirnov."""
    n = 20_000
    drawn = MODEL.sample(np.full(n, expected), np.random.default_rng(3))
    at_end = math.exp(MODEL.log_density(8.0, expected))
    assert abs(np.mean(drawn == 8.0) - at_end) < 5.0 * math.sqrt(at_end * (1 - at_end) / n)
    fine = np.linspace(0.0, 8.0, 20_001)[:-1]
    density = np.exp(MODEL.log_density(fine + 2e-4, expected))
    law = np.concatenate([[0.0], np.cumsum(density)])
    test = kstest(drawn[drawn < 8.0], lambda z: np.interp(z, np.append(fine, 8.0), law / law[-1]))
    assert test.pvalue > 1e-4


def test_em_finds_the_mixture_that_the_ranges_were_drawn_from() -> None:
    rng = np.random.default_rng(11)
    expected = rng.uniform(0.5, 8.0, 10_000)
    ranges = MODEL.sample(expected, rng)
    fit = learn_beam_model(ranges, expected, BeamModel(max_range=8.0, sigma=1.0, rate=2.0))
    assert fit.converged
    assert np.allclose(fit.model.shares, MODEL.shares, atol=0.015)
    assert fit.model.sigma == pytest.approx(0.3, rel=0.03)
    assert fit.model.rate == pytest.approx(0.7, rel=0.12)
    # A likelihood ratio: twice the gain over the truth follows chi2 with 5 degrees of freedom.
    gain = fit.log_likelihoods[-1] - np.sum(MODEL.log_density(ranges, expected))
    assert -0.1 < gain < 13.0


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_em_never_lowers_the_likelihood(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = replace(MODEL, **dict(zip(("hit", "short", "beyond", "random"), rng.dirichlet(np.ones(4)), strict=True)))
    expected = np.minimum(rng.uniform(0.2, 9.0, 200), 8.0)
    fit = learn_beam_model(truth.sample(expected, rng), expected, BeamModel(max_range=8.0, sigma=0.8), rounds=15)
    assert np.all(np.diff(fit.log_likelihoods) >= -1e-8)
    assert fit.model.shares.sum() == pytest.approx(1.0)


def test_responsibilities_name_the_cause() -> None:
    due = responsibilities(MODEL, np.array([5.0, 0.2, 8.0]), np.array([5.0, 5.0, 5.0]))
    assert np.argmax(due, axis=0).tolist() == [0, 1, 2]
    assert np.allclose(due.sum(axis=0), 1.0)


def test_a_stray_beam_kills_a_gaussian_particle_but_not_one_of_the_mixture() -> None:
    """Course 2: somebody stands one metre before the wall, twenty sigmas off."""
    narrow = replace(MODEL, sigma=0.05)
    pure = replace(narrow, hit=1.0, short=0.0, beyond=0.0, random=0.0)
    assert pure.log_density(4.0, 5.0) - pure.log_density(5.0, 5.0) < -190.0
    assert narrow.log_density(4.0, 5.0) - narrow.log_density(5.0, 5.0) > -6.0


def test_n_copies_of_a_beam_are_n_times_too_sure_and_tempering_mends_it() -> None:
    """Course 2: log odds of two poses grow with the number of beams that say the same."""
    grid_map = room()
    poses = np.array([[3.0, 0.0, 0.5], [3.1, 0.1, 0.5]])
    scan = scan_from(grid_map, poses[0], 12)
    doubled = Scan(np.repeat(scan.ranges, 30), np.repeat(scan.angles, 30), scan.max_range)
    for full, tempered in (
        (LikelihoodField(grid_map), LikelihoodField(grid_map, power=1 / 30)),
        (BeamSensor(grid_map, MODEL), BeamSensor(grid_map, MODEL, power=1 / 30)),
    ):
        odds = -np.diff(full.log_likelihood(poses, scan))
        assert odds > 0.0
        assert -np.diff(full.log_likelihood(poses, doubled)) == pytest.approx(30 * odds)
        assert -np.diff(tempered.log_likelihood(poses, doubled)) == pytest.approx(odds)


def test_the_field_is_the_density_of_the_nearest_wall_by_brute_force() -> None:
    grid_map, rng = room(), np.random.default_rng(5)
    field = LikelihoodField(grid_map, sigma=0.25, hit=0.8, random=0.2, max_range=8.0, power=0.5)
    walls = grid_map.to_world(np.argwhere(grid_map.occupied)[:, ::-1] + 0.5)
    poses = np.column_stack([rng.uniform(-1.0, 8.0, (40, 2)), rng.uniform(-3.0, 3.0, 40)])
    ranges = np.where(rng.random(17) < 0.2, 8.0, rng.uniform(0.1, 4.0, 17))
    scan = Scan.full_turn(ranges, 8.0)
    expected = np.zeros(40)
    for i, pose in enumerate(poses):
        for z, angle in zip(scan.ranges, scan.angles, strict=True):
            if z < 8.0:
                end = compose(pose, [z * math.cos(angle), z * math.sin(angle), 0.0])[:2]
                centre = grid_map.to_world(np.floor(grid_map.to_cells(end)) + 0.5)
                distance = np.min(np.hypot(*(walls - centre).T)) if grid_map.contains(end) else math.inf
                hit = math.exp(-0.5 * (distance / 0.25) ** 2) / (0.25 * math.sqrt(2 * math.pi))
                expected[i] += 0.5 * math.log(0.8 * hit + 0.2 / 8.0)
    assert np.allclose(field.log_likelihood(poses, scan), expected, atol=1e-9)


@pytest.mark.parametrize("away", [0.0, 0.3, 3.0, 7.0, 30.0, 1e4, 1e30])
@pytest.mark.parametrize("max_range", [0.5, 2.0, 8.0, 50.0, 1e9])
def test_wherever_beams_end_off_the_map_the_field_is_noise(away: float, max_range: float) -> None:
    """From on the map and off it, by scans that reach as far as the field's and further, cell by cell."""
    rng, shape = np.random.default_rng(int(max_range)), (40, 60)
    # Walls up to the very edge: a beam taken for one of the next row would be told.
    grid_map = GridMap.from_free(rng.random(shape) < 0.5, 0.1)
    field = LikelihoodField(grid_map, sigma=0.25, max_range=2.0)
    starts = rng.uniform(-away, away + np.array([6.0, 4.0]), (60, 2))
    poses = np.column_stack([starts, rng.uniform(-3.0, 3.0, 60)])
    scan = Scan.full_turn(rng.uniform(0.1, 1.0, 25) * 0.99 * max_range, max_range)
    angles = poses[:, 2] + scan.angles[:, None]
    columns = np.floor((poses[:, 0] + scan.ranges[:, None] * np.cos(angles)) / 0.1)
    rows = np.floor((poses[:, 1] + scan.ranges[:, None] * np.sin(angles)) / 0.1)
    inside = (columns >= 0) & (columns < shape[1]) & (rows >= 0) & (rows < shape[0])
    cells = np.where(inside, rows * shape[1] + columns, 0).astype(np.int64)
    logs = np.where(inside, field.log_field.ravel()[cells], math.log(0.1 / 2.0))
    assert np.allclose(field.log_likelihood(poses, scan), logs.sum(axis=0), atol=1e-9)


def test_a_beam_that_ends_by_one_rounding_before_a_cell_is_not_in_it() -> None:
    """However far down the map its row is."""
    free = np.ones((40, 60), dtype=bool)
    free[:, 1] = False
    field = LikelihoodField(GridMap.from_free(free))
    found = field.log_likelihood(np.array([[0.5, 37.5, 0.0]]), Scan.full_turn([0.5 - 2.0**-51], 8.0))
    assert found[0] == field.log_field[37, 0] != field.log_field[37, 1]


def test_no_pose_has_no_likelihood() -> None:
    assert LikelihoodField(room()).log_likelihood(np.zeros((0, 3)), Scan.full_turn([1.0, 2.0], 8.0)).shape == (0,)


@pytest.mark.parametrize("seed", range(3))
def test_the_true_pose_is_the_likeliest_of_many(seed: int) -> None:
    grid_map, rng = room(), np.random.default_rng(seed)
    cells = rng.permutation(np.argwhere(grid_map.free))[:200]
    poses = grid_map.poses_to_world(np.column_stack([cells[:, ::-1] + 0.5, rng.uniform(-3.0, 3.0, 200)]))
    scan = scan_from(grid_map, poses[0])
    for sensor in (LikelihoodField(grid_map, sigma=0.1), BeamSensor(grid_map, MODEL)):
        assert np.argmax(sensor.log_likelihood(poses, scan)) == 0


def test_the_beam_sensor_sums_beams_cast_one_by_one() -> None:
    grid_map = room()
    poses = np.array([[3.0, 0.0, 0.5], [4.0, 0.5, -2.0]])
    perfect = scan_from(grid_map, poses[0], 9)
    scan = Scan(perfect.ranges * 0.97, perfect.angles, perfect.max_range)
    expected = np.array([scan_from(grid_map, pose, 9).ranges for pose in poses])
    found = BeamSensor(grid_map, MODEL).log_likelihood(poses, scan)
    assert np.allclose(found, MODEL.log_density(scan.ranges, expected).sum(axis=1))


def test_beams_that_were_not_measured_weigh_no_pose() -> None:
    """31 of them would make the middle of a hall e^26 times likelier, if they were free ways to the maximum."""
    grid_map, rng = room(), np.random.default_rng(8)
    cells = rng.permutation(np.argwhere(grid_map.free))[:20]
    poses = grid_map.poses_to_world(np.column_stack([cells[:, ::-1] + 0.5, rng.uniform(-3.0, 3.0, 20)]))
    scan = scan_from(grid_map, poses[0], 31)
    lost = rng.random(31) < 0.4
    gaps = Scan.from_sensor(np.where(lost, math.nan, scan.ranges), scan.angles, scan.max_range)
    blind = Scan.from_sensor(np.full(31, math.nan), scan.angles, scan.max_range)
    for sensor in (LikelihoodField(grid_map), BeamSensor(grid_map, MODEL)):
        alone = sensor.log_likelihood(poses, scan.select_beams(~lost))
        np.testing.assert_array_equal(sensor.log_likelihood(poses, gaps), alone)
        assert not sensor.log_likelihood(poses, blind).any()


def test_a_way_that_is_free_as_far_as_a_short_lidar_sees_is_no_hit_there() -> None:
    grid_map = GridMap.from_free(np.ones((40, 40), dtype=bool), 0.5)
    scan = Scan.full_turn([2.0] * 8, 2.0)
    found = BeamSensor(grid_map, MODEL).log_likelihood(np.array([[10.0, 10.0, 0.0]]), scan)
    assert found[0] == pytest.approx(8 * math.log(MODEL.hit + MODEL.beyond))


def test_a_scan_that_hit_nothing_says_nothing_to_a_field() -> None:
    field = LikelihoodField(room())
    assert field.log_likelihood(np.zeros((3, 3)), Scan.full_turn([8.0, 8.0], 8.0)).tolist() == [0.0, 0.0, 0.0]


@given(st.integers(1, 400), st.integers(1, 60))
def test_thinned_scans_keep_beams_evenly(beams: int, count: int) -> None:
    scan = Scan.full_turn(np.linspace(0.0, 1.0, beams), 1.0)
    kept = thin_scan(scan, count)
    assert len(kept) == min(beams, count)
    steps = np.diff(np.rint(kept.angles * beams / (2 * np.pi)))
    assert steps.size == 0 or steps.max() - steps.min() <= 1


def test_input_without_meaning_is_named() -> None:
    grid_map, pose = room(), np.zeros((1, 3))
    scan, empty = Scan.full_turn([1.0, 2.0], 8.0), Scan.full_turn([], 8.0)
    for argument, call in (
        ("hit, short, beyond, random", lambda: replace(MODEL, hit=0.9)),
        ("sigma", lambda: replace(MODEL, sigma=0.0)),
        ("rate", lambda: replace(MODEL, rate=math.nan)),
        ("ranges", lambda: MODEL.log_density([9.0], [1.0])),
        ("expected", lambda: MODEL.log_density([1.0], [math.nan])),
        ("ranges", lambda: plain_densities(MODEL, [math.nan], [1.0])),
        ("ranges", lambda: learn_beam_model([], [], MODEL)),
        ("ranges", lambda: learn_beam_model([1.0], [1.0, 2.0], MODEL)),
        ("start", lambda: learn_beam_model([1.0], [8.0], replace(MODEL, hit=1.0, short=0.0, beyond=0.0, random=0.0))),
        ("scan", lambda: LikelihoodField(grid_map).log_likelihood(pose, empty)),
        ("scan", lambda: BeamSensor(grid_map, MODEL).log_likelihood(pose, empty)),
        ("poses_world", lambda: LikelihoodField(grid_map).log_likelihood(pose * math.nan, scan)),
        ("power", lambda: LikelihoodField(grid_map, power=0.0)),
        ("power", lambda: BeamSensor(grid_map, MODEL, power=2.0)),
        ("sigma", lambda: LikelihoodField(grid_map, sigma=-1.0)),
        ("hit, random", lambda: LikelihoodField(grid_map, random=0.0)),
        ("count", lambda: thin_scan(scan, 0)),
    ):
        with pytest.raises(InvalidArgumentError) as refusal:
            call()
        assert refusal.value.argument == argument
