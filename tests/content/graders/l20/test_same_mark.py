"""Same code, same mark: what a program gets does not depend on the seed."""

from __future__ import annotations

import pytest

from tests.content.graders.l20.boucles_styles import submission
from tests.content.graders.l20.test_names_that_hold import BOUCLES, COMB, KABSCH, PREDIRE, SLAM
from tests.support.quick import one_in
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with

POSES = "l20/poses"
SEEDS = range(2026, 2030)


def mistake(exercise: str, name: str) -> str:
    return next(m.source for m in CODE[exercise].misconceptions if m.id == name)


RAW = model_with(BOUCLES, "signature(scans[j]) - reference", "scans[j] - scans[i]")
HALF_A_TURN = "np.abs(np.exp(-1j * np.pi * np.outer(np.arange(36), np.arange(36)) / 36) @ scan)"
NORMS, ONE_SIDED = "abs(np.linalg.norm(a) - np.linalg.norm(b))", "np.max(b - a)"
FROM_THE_EVENEST = "np.roll(scan, -np.argmin(np.abs(scan - np.roll(scan, 1))))"
SPECTRUM = "np.abs(np.fft.rfft(scan))"
LAST_TOOTH_AT_ONE = model_with(COMB, "dents = u + np.arange(N) / N", "dents = np.linspace(u, 1, N)")
PI = "import math\nPI = 3.14\n" + model_with(
    POSES, "np.pi - (np.pi - angle) % (2 * np.pi)", "PI - (PI - angle) % (2 * PI)"
)


@pytest.mark.parametrize(
    ("exercise", "source"),
    one_in(
        6,
        [
            (BOUCLES, submission("np.correlate(scan, scan, 'full')[35:]")),
            (BOUCLES, submission(HALF_A_TURN)),
            (BOUCLES, RAW),
            (BOUCLES, mistake(BOUCLES, "premier_seulement")),
            (BOUCLES, mistake(BOUCLES, "premier_indice_oublie")),
            (BOUCLES, mistake(BOUCLES, "ecarts_signes")),
            (BOUCLES, submission("np.array([np.median(scan)])")),
            (BOUCLES, submission("np.sort(scan)", NORMS)),
            (BOUCLES, submission(SPECTRUM, NORMS)),
            (BOUCLES, submission("np.sort(scan)", ONE_SIDED)),
            (BOUCLES, submission(SPECTRUM, ONE_SIDED)),
            (BOUCLES, submission("np.sort(scan)", "np.min(np.abs(a - b))")),
            (BOUCLES, submission(FROM_THE_EVENEST)),
            (COMB, LAST_TOOTH_AT_ONE),
            (COMB, mistake(COMB, "indice_suivant")),
            (POSES, model_with(POSES, "np.pi - (np.pi - angle) % (2 * np.pi)", "np.arcsin(np.sin(angle))")),
            (POSES, model_with(POSES, "ramener(tb - ta)", "tb - ta")),
            (KABSCH, mistake(KABSCH, "correction_colonne_de_r")),
            (KABSCH, mistake(KABSCH, "angle_modulo_pi")),
            (
                COMB,
                model_with(
                    COMB, "def n_eff(poids):\n    return ", "def n_eff(poids):\n    return int(", "**2)\n", "**2))\n"
                ),
            ),
            (POSES, PI),
            (PREDIRE, mistake(PREDIRE, "croyance_oubliee")),
            (PREDIRE, mistake(PREDIRE, "carre_oublie")),
            (PREDIRE, mistake(PREDIRE, "ecrasement")),
            (PREDIRE, model_with(PREDIRE, "np.sum((scan_obs - z) ** 2)", "(scan_obs[0] - z[0]) ** 2")),
            (SLAM, mistake(SLAM, "difference_non_ramenee")),
            (SLAM, mistake(SLAM, "angles_jamais_ramenes")),
        ],
    ),
)
def test_the_same_checks_fail_whatever_the_seed(exercise: str, source: str) -> None:
    first, *others = [failed(checked(exercise, source, seed).verdict) for seed in SEEDS]
    assert first
    assert all(found == first for found in others)
