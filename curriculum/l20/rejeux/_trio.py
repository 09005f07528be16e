"""L'EKF, l'UKF et les particules, devant le même mouvement et la même mesure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.filters.banana import Banana
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.gaussian import GaussianBelief
from reference.filters.models import GaussianModel
from reference.filters.particles import ParticleFilter
from reference.filters.resampling import effective_sample_size
from reference.filters.unscented import UnscentedKalmanFilter, UnscentedParameters

Floats = NDArray[np.float64]

ADVANCE = 10.0
#: Moins de particules que cela comptent : le nuage ne dit plus rien de sa largeur.
COLLAPSED = 5.0
#: κ = 3 − n, pour n nombres incertains : trois et les deux bruits du mouvement, puis trois.
PREDICTING, CORRECTING = UnscentedParameters(beta=0.0, kappa=-2.0), UnscentedParameters(beta=0.0)


@dataclass(frozen=True, eq=False)
class Answer:
    """Ce qu'un filtre annonce d'une place : moyenne (2,), covariance (2, 2) ; `counting` particules comptent."""

    mean: Floats
    covariance: Floats
    counting: float = np.inf

    def nees(self, place: Floats) -> float:
        away = place - self.mean
        return float(away @ np.linalg.solve(self.covariance, away)) if self.counting >= COLLAPSED else np.nan

    @property
    def spread(self) -> float:
        """L'écart-type le long du grand axe."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1]))


@dataclass(frozen=True, eq=False)
class Trio:
    """Les trois filtres, après le mouvement ; chaque mesure repart d'eux."""

    banana: Banana
    model: GaussianModel
    cloud: Floats
    rng: np.random.Generator

    def predicted(self, part: float = 1.0) -> tuple[GaussianBelief, GaussianBelief]:
        """L'EKF et l'UKF après cette part du chemin."""
        start = np.zeros(3), np.diag([0.0, 0.0, self.banana.heading_sigma**2])
        ekf = ExtendedKalmanFilter(self.model, *start)
        ukf = UnscentedKalmanFilter(self.model, *start, PREDICTING)
        for belief in (ekf, ukf):
            belief.predict([part * ADVANCE, 0.0])
        return ekf, ukf

    def corrected(self, ekf: GaussianBelief, ukf: GaussianBelief, z: Floats) -> tuple[list[Answer], Floats]:
        """Les trois réponses après la mesure, et les poids des particules."""
        tangent = ExtendedKalmanFilter(self.model, ekf.mean, ekf.covariance)
        sigma = UnscentedKalmanFilter(self.model, ukf.mean, ukf.covariance, CORRECTING)
        sampled = ParticleFilter(self.model, self.cloud, self.rng, threshold=0.0)
        for belief in (tangent, sigma, sampled):
            belief.correct(z)
        counting = effective_sample_size(sampled.weights)
        particles = Answer(sampled.mean[:2], sampled.covariance[:2, :2], counting)
        return [of(tangent), of(sigma), particles], sampled.weights


def of(belief: GaussianBelief) -> Answer:
    return Answer(belief.mean[:2], belief.covariance[:2, :2])
