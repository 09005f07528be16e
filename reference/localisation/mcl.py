"""Monte Carlo localisation: where a robot is in a known map, from its odometry and a lidar, without a first guess.

The particle filter over poses, with what localisation adds to it: poses drawn anew when the robot seems lost (random
injection, augmented MCL), as many particles as the belief needs (KLD-sampling), and the cloud that weighs most.

Sources: Dellaert, Fox, Burgard, Thrun, "Monte Carlo Localization for Mobile Robots" (1999); Thrun, Burgard, Fox,
"Probabilistic Robotics" (2005), tables 8.2 to 8.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.filters.bayes import reweight
from reference.filters.particles import ParticleFilter
from reference.filters.resampling import multinomial_resampling, systematic_resampling
from reference.localisation.kld_sampling import KldSampling
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry
from reference.localisation.pose_clusters import Cluster, find_clusters
from reference.sensors.rays import ScanLikelihood
from reference.world.grid_map import GridMap
from reference.world.scan import Scan

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class InjectionRule:
    """How many particles are drawn anew, on the free cells, at each resampling.

    Each is the pick of `tries` poses drawn evenly: the likelier for the present scan, the more often. One try is plain
    random injection; many are the sensor resetting of Lenser and Veloso (2000), which finds the robot much sooner. The
    share is `always`, or more when the scans get less likely than they used to be:

        w_slow += slow (w - w_slow),  w_fast += fast (w - w_fast),  share = 1 - w_fast / w_slow                (1)

    w is the likelihood of the scan, averaged over particles, and geometrically over the beams that hit something: the
    book averages the products, which swing by tens of orders of magnitude. slow = fast = 0 leaves `always` alone.
    Raises InvalidArgumentError unless 0 <= slow <= fast <= 1, 0 <= always < 1 and tries >= 1.
    """

    slow: float = 0.05
    fast: float = 0.5
    always: float = 0.0
    tries: int = 1

    def __post_init__(self) -> None:
        if not 0.0 <= self.slow <= self.fast <= 1.0:
            raise InvalidArgumentError("slow", f"{self.slow} is not between 0 and fast = {self.fast}, at most 1")
        if not 0.0 <= self.always < 1.0:
            raise InvalidArgumentError("always", f"{self.always} is not a share below one")
        if self.tries < 1:
            raise InvalidArgumentError("tries", f"{self.tries} draws give no pose")


@dataclass
class LikelihoodAverages:
    """The running averages of (1), none before the first scan."""

    slow: float | None = None
    fast: float | None = None

    def update_and_share(self, likelihood: float, rule: InjectionRule) -> float:
        """Take in one likelihood; the share of particles to draw anew."""
        if self.slow is None or self.fast is None:
            self.slow = self.fast = likelihood
        self.slow += rule.slow * (likelihood - self.slow)
        self.fast += rule.fast * (likelihood - self.fast)
        return max(rule.always, 1.0 - self.fast / self.slow) if self.slow > 0.0 else rule.always


class LidarModel:
    """What particles need to know of a robot with odometry and a lidar in a map: a SampledModel."""

    state_angles = np.array([False, False, True])

    def __init__(self, sensor: ScanLikelihood, motion: OdometryNoise) -> None:
        self.sensor, self.motion = sensor, motion

    def sample_motion(self, states: Floats, control: Floats, rng: np.random.Generator) -> Floats:
        return sample_odometry(states, control, self.motion, rng)

    def log_likelihood(self, states: Floats, measurement: Scan) -> Floats:
        return self.sensor.log_likelihood(states, measurement)


class MonteCarloLocalization(ParticleFilter[Scan]):
    """A BayesFilter over poses (n, 3) of the world: controls are moves T_before_after (3,), measurements scans.

    The particles at the start come from `uniform_poses`, from `likely_poses`, or from around a known pose. `threshold`
    as for ParticleFilter; `kld`, when given, chooses the number of particles at each resampling; `injected` tells how
    many the last correction drew anew.

    Raises InvalidArgumentError; corrections raise ImpossibleMeasurementError when no particle can have seen the scan,
    which cannot happen with a sensor model that allows for noise.
    """

    def __init__(
        self,
        grid_map: GridMap,
        sensor: ScanLikelihood,
        poses_world: ArrayLike,
        rng: np.random.Generator,
        *,
        motion: OdometryNoise | None = None,
        injection: InjectionRule | None = None,
        kld: KldSampling | None = None,
        threshold: float = 0.5,
    ) -> None:
        super().__init__(LidarModel(sensor, motion or OdometryNoise()), poses_world, rng, threshold=threshold)
        self.grid_map, self.sensor, self.injection, self.kld = grid_map, sensor, injection, kld
        self.averages, self.injected = LikelihoodAverages(), 0

    def correct(self, measurement: Scan) -> float:
        """Weigh the particles by the scan; resample if N_eff is low or if poses are to be injected."""
        evidence, self.injected = self.weigh(measurement), 0
        share = self._injection_share(evidence, measurement)
        if share > 0.0 or self.is_degenerate:
            self.resample()
            self._inject_particles(share, measurement)
        return evidence

    def resample(self) -> None:
        """Draw particles by their weights, as many as there are, or as KLD-sampling asks for."""
        self.states = self._draw_particles() if self.kld is None else self._draw_by_kld(self.kld)
        self.weights = np.full(len(self.states), 1.0 / len(self.states))

    def _inject_particles(self, share: float, scan: Scan) -> None:
        """Replace each particle by a pose drawn anew with probability `share`."""
        lost = self.rng.random(len(self.states)) < share
        self.injected = int(np.count_nonzero(lost))
        if self.injection is not None and self.injected > 0:
            self.states[lost] = likely_poses(
                self.grid_map, self.sensor, scan, self.injected, self.rng, self.injection.tries
            )

    def clusters(self) -> list[Cluster]:
        """The clouds of particles, heaviest first: two in a symmetrical corridor."""
        return find_clusters(self.states, self.weights)

    def _injection_share(self, evidence: float, scan: Scan) -> float:
        if self.injection is None or not (hits := int(np.count_nonzero(scan.hit_mask))):
            return 0.0
        return self.averages.update_and_share(float(np.exp(evidence / hits)), self.injection)

    def _draw_particles(self) -> Floats:
        return self.states.take(self.scheme(self.weights, self.rng, None).ancestors, axis=0)

    def _draw_by_kld(self, kld: KldSampling) -> Floats:
        """Independent draws, as many as KLD-sampling asks for."""
        ancestors = self.rng.permutation(multinomial_resampling(self.weights, self.rng, kld.most).ancestors)
        drawn = self.states[ancestors]
        return np.asarray(drawn[: kld.count_needed_poses(drawn)])


def likely_poses(
    grid_map: GridMap, sensor: ScanLikelihood, scan: Scan, count: int, rng: np.random.Generator, tries: int = 40
) -> Floats:
    """Poses (count, 3) of the world where a robot that sees the scan may be: its belief, had it known nothing before.

    `count` x `tries` poses are drawn evenly on the free cells and `count` of them kept, by their likelihood. Raises
    InvalidArgumentError, and ImpossibleMeasurementError when none can have seen the scan.
    """
    candidates = uniform_poses(grid_map, count * tries, rng)
    if tries == 1:
        return candidates
    even = np.full(len(candidates), 1.0 / len(candidates))
    weights = reweight(even, sensor.log_likelihood(candidates, scan)).weights
    return np.asarray(candidates[systematic_resampling(weights, rng, count).ancestors])


def uniform_poses(grid_map: GridMap, count: int, rng: np.random.Generator) -> Floats:
    """Poses (count, 3) of the world drawn evenly on the free cells, with any heading.

    Raises InvalidArgumentError for a map without a free cell.
    """
    cells = np.flatnonzero(grid_map.free)
    if cells.size == 0:
        raise InvalidArgumentError("grid_map", "has no free cell")
    y, x = np.divmod(rng.choice(cells, size=count), grid_map.shape[1])
    corners = np.column_stack([x, y, np.zeros(count)])
    return grid_map.poses_to_world(corners + np.array([1.0, 1.0, 2.0 * np.pi]) * rng.random((count, 3)))
