"""One problem, one interface, every incarnation: what is exact, what converges to it, and Theorem 1 by brute force."""

import itertools
import math

import numpy as np
import pytest

from reference.errors import InvalidArgumentError
from reference.filters.bayes import BayesFilter, ImpossibleMeasurementError
from reference.filters.corridor import Corridor
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.histogram import HistogramFilter
from reference.filters.kalman import KalmanFilter
from reference.filters.particles import ParticleFilter
from reference.filters.unscented import UnscentedKalmanFilter, UnscentedParameters
from reference.localisation.grid_filter import COMMANDS, GridFilter, GridWorld, possible_landings

CORRIDOR = Corridor()
STEPS = 12
START, START_SIGMA = 4.0, 1.0


def journey(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Controls (n, 1) and the ranges (n, 1) to the end wall that a simulated robot measures."""
    rng = np.random.default_rng(seed)
    controls = rng.uniform(0.3, 1.2, (STEPS, 1))
    positions = rng.normal(START, START_SIGMA) + np.cumsum(
        controls + rng.normal(0.0, CORRIDOR.motion_sigma, (STEPS, 1))
    )
    return controls, (CORRIDOR.length - positions + rng.normal(0.0, CORRIDOR.range_sigma, STEPS))[:, None]


def follow(robot: BayesFilter[np.ndarray, np.ndarray], seed: int) -> float:
    """The whole journey; the log evidence of all its measurements."""
    total = 0.0
    for control, measurement in zip(*journey(seed), strict=True):
        robot.predict(control)
        total += robot.correct(measurement)
    return total


def kalman() -> KalmanFilter:
    return KalmanFilter(CORRIDOR.range_model(), [START], [[START_SIGMA**2]])


def histogram(cell: float) -> HistogramFilter[np.ndarray]:
    edges = np.arange(-4.0, 24.0 + cell / 2, cell)
    centres = 0.5 * (edges[1:] + edges[:-1])
    return HistogramFilter(CORRIDOR.range_model(), edges, np.exp(-0.5 * ((centres - START) / START_SIGMA) ** 2))


def particles(count: int, seed: int) -> ParticleFilter[np.ndarray]:
    rng = np.random.default_rng(seed)
    return ParticleFilter(CORRIDOR.range_model(), rng.normal(START, START_SIGMA, (count, 1)), rng)


@pytest.mark.parametrize("seed", range(4))
def test_kalman_is_what_conditioning_the_whole_history_gives(seed: int) -> None:
    """Theorem 1 for Gaussians: all positions and measurements at once, one joint law, conditioned in one go."""
    controls, measurements = journey(seed)
    lower = np.tril(np.ones((STEPS, STEPS)))
    mean = START + np.cumsum(controls)
    spread = START_SIGMA**2 + CORRIDOR.motion_sigma**2 * lower @ lower.T
    seen = spread + CORRIDOR.range_sigma**2 * np.eye(STEPS)
    surprise = CORRIDOR.length - measurements[:, 0] - mean
    robot = kalman()
    evidence = follow(robot, seed)
    assert robot.mean[0] == pytest.approx(mean[-1] + spread[-1] @ np.linalg.solve(seen, surprise), abs=1e-10)
    assert robot.covariance[0, 0] == pytest.approx(
        spread[-1, -1] - spread[-1] @ np.linalg.solve(seen, spread[-1]), abs=1e-10
    )
    joint = -0.5 * (surprise @ np.linalg.solve(seen, surprise) + np.linalg.slogdet(2 * np.pi * seen)[1])
    assert evidence == pytest.approx(joint, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("spread", [None, UnscentedParameters(alpha=0.3), UnscentedParameters(kappa=1.0, beta=0.0)])
def test_extended_and_unscented_are_kalman_where_the_problem_is_linear(
    seed: int, spread: UnscentedParameters | None
) -> None:
    exact, model = kalman(), CORRIDOR.range_model()
    evidence = follow(exact, seed)
    extended = ExtendedKalmanFilter(model, [START], [[START_SIGMA**2]])
    assert follow(extended, seed) == pytest.approx(evidence, abs=1e-9)
    assert np.allclose(extended.mean, exact.mean, atol=1e-12)
    unscented = UnscentedKalmanFilter(model, [START], [[START_SIGMA**2]], spread)
    assert follow(unscented, seed) == pytest.approx(evidence, abs=1e-8)
    assert np.allclose(unscented.mean, exact.mean, atol=1e-9)
    assert np.allclose(unscented.covariance, exact.covariance, atol=1e-9)


def test_histogram_converges_to_kalman_with_the_square_of_the_cell() -> None:
    exact = kalman()
    evidence = follow(exact, 5)
    errors = []
    for cell in (0.4, 0.2, 0.1):
        robot = histogram(cell)
        off = abs(follow(robot, 5) - evidence)
        errors.append([abs(robot.mean[0] - exact.mean[0]), abs(robot.covariance[0, 0] - exact.covariance[0, 0]), off])
    coarse, middle, fine = np.array(errors)
    assert fine.max() < 3e-2
    assert np.all(coarse[1:] / middle[1:] > 3.0)
    assert np.all(middle[1:] / fine[1:] > 3.0)


def test_particles_converge_to_kalman_with_the_root_of_their_number() -> None:
    exact = kalman()
    evidence = follow(exact, 6)
    scatter = []
    for count in (100, 1600):
        robots = [particles(count, seed) for seed in range(30)]
        off = np.array([follow(robot, 6) for robot in robots]) - evidence
        means = np.array([robot.mean[0] for robot in robots]) - exact.mean[0]
        assert abs(means.mean()) < 5.0 * means.std() / math.sqrt(30)
        scatter.append([np.sqrt(np.mean(means**2)), np.sqrt(np.mean(off**2))])
    # Sixteen times more particles: four times less scatter, give or take what 30 runs can tell.
    ratios = np.array(scatter[0]) / np.array(scatter[1])
    assert np.all((ratios > 2.5) & (ratios < 6.5))


def test_the_evidence_of_particles_is_unbiased() -> None:
    """The mean over runs of exp(log evidence) is the true evidence: a property of the whole algorithm."""
    exact = follow(kalman(), 7)
    ratios = np.exp([follow(particles(200, seed), 7) - exact for seed in range(150)])
    assert abs(ratios.mean() - 1.0) < 4.0 * ratios.std() / math.sqrt(ratios.size)


def brute_force(world: GridWorld, sigma: float, commands: list[tuple[int, int]], scans: list[np.ndarray]) -> np.ndarray:
    """Every path of the robot, its joint probability with the measurements, added up by where it ends."""
    free = [(int(y), int(x)) for y, x in np.argwhere(world.free)]
    result = np.zeros(world.free.shape)
    for start, *choices in itertools.product(free, *[range(len(possible_landings(*command))) for command in commands]):
        probability, (y, x) = 1.0 / len(free), start
        for command, scan, choice in zip(commands, scans, choices, strict=True):
            outcome = possible_landings(*command)[choice]
            target = (y + outcome.dy, x + outcome.dx)
            y, x = target if world.is_free(target) else (y, x)
            densities = np.exp(-((scan - world.scans[y, x]) ** 2) / (2 * sigma**2)) / (sigma * math.sqrt(2 * math.pi))
            probability *= outcome.probability * np.prod(densities)
        result[y, x] += probability
    return result


def test_theorem_1_the_recursion_is_bayes_rule_on_whole_paths() -> None:
    rng, sigma = np.random.default_rng(1), 0.8
    free = np.ones((3, 4), dtype=bool)
    free[1, 1] = False
    world = GridWorld.from_free_cells(free, 6.0)
    commands = [COMMANDS[1], COMMANDS[3], COMMANDS[1], COMMANDS[4]]
    scans = [world.scans[2, 2] + rng.normal(0.0, sigma, 4) for _ in commands]
    robot = GridFilter(world, sigma)
    evidence = 0.0
    for command, scan in zip(commands, scans, strict=True):
        robot.predict(command)
        evidence += robot.correct(scan)
    joint = brute_force(world, sigma, commands, scans)
    assert evidence == pytest.approx(math.log(joint.sum()), abs=1e-10)
    assert np.allclose(robot.belief, joint / joint.sum(), atol=1e-13)


def test_moments_of_a_grid_belief_are_those_of_its_cells() -> None:
    rng = np.random.default_rng(2)
    world = GridWorld.from_free_cells(np.ones((4, 6)), 6.0)
    robot = GridFilter(world, 0.5)
    robot.belief = rng.dirichlet(np.ones(24)).reshape(4, 6)
    y, x = np.indices((4, 6)) + 0.5
    points = np.column_stack([x.ravel(), y.ravel()])
    assert np.allclose(robot.mean, robot.belief.ravel() @ points)
    assert np.allclose(robot.covariance, np.cov(points.T, aweights=robot.belief.ravel(), bias=True))


def door_filters() -> tuple[HistogramFilter[bool], ParticleFilter[bool]]:
    rng, model = np.random.default_rng(4), CORRIDOR.door_model()
    return (
        HistogramFilter(model, np.linspace(0.0, CORRIDOR.length, 401)),
        ParticleFilter(model, rng.uniform(0.0, CORRIDOR.length, (20_000, 1)), rng),
    )


def share_near(robot: HistogramFilter[bool] | ParticleFilter[bool], place: float) -> float:
    """The probability to be within a metre of a place."""
    if isinstance(robot, HistogramFilter):
        return float(robot.belief[np.abs(robot.centres - place) < 1.0].sum())
    return float(robot.weights[np.abs(robot.states[:, 0] - place) < 1.0].sum())


def test_one_door_seen_is_as_many_bumps_as_doors_and_a_second_one_tells_which() -> None:
    """Doors at 3, 7 and 15 m: only from the first one does a step of 4 m lead to another."""
    for robot in door_filters():
        robot.correct(True)
        assert all(0.2 < share_near(robot, door) < 0.35 for door in CORRIDOR.doors)
        robot.predict(np.array([4.0]))
        robot.correct(True)
        assert share_near(robot, 7.0) > 0.7
        assert robot.mean[0] == pytest.approx(door_mean(), abs=0.15)


def door_mean() -> float:
    robot = door_filters()[0]
    robot.correct(True)
    robot.predict(np.array([4.0]))
    robot.correct(True)
    return float(robot.mean[0])


def test_a_histogram_loses_no_probability_at_its_ends() -> None:
    robot = HistogramFilter(CORRIDOR.range_model(), np.linspace(0.0, 1.0, 11))
    robot.predict([50.0])
    assert robot.belief.sum() == pytest.approx(1.0)
    assert robot.belief[-1] == pytest.approx(1.0)


class _Blind:
    """A sensor for which everything is impossible."""

    state_angles = np.zeros(1, dtype=bool)

    def sample_motion(self, states: np.ndarray, control: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return states + control

    def log_likelihood(self, states: np.ndarray, measurement: float) -> np.ndarray:
        return np.full(len(states), -np.inf)


def test_an_impossible_measurement_is_refused_and_the_belief_kept() -> None:
    rng = np.random.default_rng(0)
    line = HistogramFilter(_Blind(), [0.0, 1.0, 2.0])
    cloud = ParticleFilter(_Blind(), rng.random((5, 1)), rng)
    for robot in (line, cloud):
        before = robot.mean
        with pytest.raises(ImpossibleMeasurementError) as refusal:
            robot.correct(1.0)
        assert refusal.value.argument == "measurement"
        assert robot.mean == before


def test_a_measurement_that_is_no_number_is_refused_and_the_belief_kept() -> None:
    for robot in (kalman(), histogram(0.5), particles(20, 0)):
        before = robot.mean
        with pytest.raises(InvalidArgumentError) as refusal:
            robot.correct(np.array([math.nan]))
        assert refusal.value.argument == "measurement"
        assert not isinstance(refusal.value, ImpossibleMeasurementError)
        assert robot.mean == before


def test_a_measurement_too_unlikely_for_any_float_still_corrects() -> None:
    """The density at 500 standard deviations underflows; the belief goes where it is least unlikely."""
    robot = particles(100, 0)
    robot.predict([0.0])
    nearest = robot.states.max()
    assert robot.correct(np.array([CORRIDOR.length - 250.0])) < -1e5
    assert robot.mean[0] == pytest.approx(nearest)


def test_resampling_waits_for_the_threshold() -> None:
    never = particles(200, 1)
    never.threshold = 0.0
    always = particles(200, 1)
    always.threshold = 1.0
    for robot in (never, always):
        robot.correct([CORRIDOR.length - START])
    assert 1.0 < never.effective_sample_size < 200.0
    assert always.effective_sample_size == pytest.approx(200.0)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("mean", lambda m: KalmanFilter(m, [0.0, 1.0], [[1.0]])),
        ("mean", lambda m: KalmanFilter(m, [math.nan], [[1.0]])),
        ("covariance", lambda m: KalmanFilter(m, [0.0], [[-1.0]])),
        ("covariance", lambda m: KalmanFilter(m, [0.0], [[math.nan]])),
        ("control", lambda m: KalmanFilter(m, [0.0], [[1.0]]).predict([math.nan])),
        ("control", lambda m: KalmanFilter(m, [0.0], [[1.0]]).predict([1.0, 2.0])),
        ("measurement", lambda m: KalmanFilter(m, [0.0], [[1.0]]).correct([math.inf])),
        ("measurement", lambda m: ExtendedKalmanFilter(m, [0.0], [[1.0]]).correct([1.0, 2.0])),
        ("measurement", lambda m: UnscentedKalmanFilter(m, [0.0], [[1.0]]).correct([math.nan])),
        ("states", lambda m: ParticleFilter(m, np.empty((0, 1)), np.random.default_rng(0))),
        ("states", lambda m: ParticleFilter(m, [[math.nan]], np.random.default_rng(0))),
        ("threshold", lambda m: ParticleFilter(m, [[0.0]], np.random.default_rng(0), threshold=2.0)),
        ("edges", lambda m: HistogramFilter(m, [0.0, 0.0])),
        ("belief", lambda m: HistogramFilter(m, [0.0, 1.0, 2.0], [0.0, 0.0])),
        ("alpha", lambda m: UnscentedParameters(alpha=0.0)),
        ("p_right", lambda m: Corridor(p_right=1.0)),
        ("length", lambda m: Corridor(length=-1.0)),
    ],
)
def test_input_without_meaning_is_named(argument: str, call: object) -> None:
    with pytest.raises(InvalidArgumentError) as refusal:
        call(CORRIDOR.range_model())  # type: ignore[operator]
    assert refusal.value.argument == argument
