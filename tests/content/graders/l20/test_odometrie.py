"""l20/odometrie: honest styles pass on every seed, every catalogued mistake is named, figures draw."""

import itertools
import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.compare.comparison import are_close
from graders.l20.odometrie import cases
from graders.l20.odometrie.grader import right_spread, right_step
from graders.l20.odometrie.journey import START, TRACK, round_trip
from graders.plotting import counterexample
from reference.odometry import DifferentialDrive, integrate_poses
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, model_with, named, verdict_of

EXERCISE = "l20/odometrie"
GRADER = CODE[EXERCISE]
verdict = partial(verdict_of, EXERCISE)
edited = partial(model_with, EXERCISE)

SEEDS = range(2)


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8-sig").replace("from l20 import np as numpy", "numpy = np")


@pytest.mark.parametrize("seed", SEEDS)
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).score == 1.0


def test_the_starter_earns_nothing() -> None:
    starter = PROJECT / "curriculum/l20/exercices/odometrie/starter.py"
    found = verdict(starter.read_text(encoding="utf-8"), 1)
    assert found.score == 0.0
    assert named(found) is None, "who has not begun has made no mistake"


@pytest.mark.parametrize("path", some(sorted((GRADER.folder / "specimens/ok").glob("*.py")))[::3], ids=lambda p: p.stem)
def test_honest_styles_pass(path: Path) -> None:
    for seed in range(2):
        assert verdict(read(path), seed).score == 1.0


def test_what_is_right_is_the_formula_written_out() -> None:
    """By complex numbers for the pose, by a cloud of exact quadrature points for the deviation of a linear function."""
    for pose, left, right, track in cases.any_steps(np.random.default_rng(5)):
        half = (right - left) / track / 2.0
        z = complex(*pose[:2]) + (left + right) / 2.0 * np.exp(1j * (pose[2] + half))
        assert are_close(np.array([z.real, z.imag, pose[2] + 2.0 * half]), right_step(pose, left, right, track), 1e-12)
    for left, right, track in cases.any_spreads(np.random.default_rng(5)):
        turns = [(b * right - a * left) / track for a, b in itertools.product((-1.0, 1.0), repeat=2)]
        assert right_spread(left, right, track) == pytest.approx(np.std(turns), abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_steps_keep_what_the_statement_promises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert all(map(cases.stays, (*cases.simple_steps(rng), *cases.any_steps(rng))))
    assert all(map(cases.wraps, cases.turning_steps(rng)))


def test_the_journey_passes_the_back_both_ways() -> None:
    """An angle that is mended on one side alone is wrong on it, at every seed."""
    headings = integrate_poses(DifferentialDrive(TRACK), round_trip(), START)[:, 2]
    jumps = np.diff(headings)[np.abs(np.diff(headings)) > math.pi]
    assert jumps.min() < 0.0 < jumps.max()


@pytest.mark.parametrize(
    ("source", "name", "checks"),
    [
        (edited("cap = theta + dtheta / 2", "cap = theta"), "cap_du_debut", {"exemples", "quelconques", "trajet"}),
        (edited("ramener(theta + dtheta)", "theta + dtheta"), "angle_jamais_ramene", {"tours", "trajet"}),
        (edited("np.sqrt(sigma_g**2 + sigma_d**2)", "(sigma_g + sigma_d)"), "ecarts_types_ajoutes", {"sigma_exemples"}),
        (edited("np.sqrt(sigma_g**2 + sigma_d**2)", "1.7 * np.hypot(sigma_g, sigma_d)"), "facteur_constant", set()),
        (edited("ds = (ds_d + ds_g) / 2", "ds = abs((ds_d + ds_g) / 2)"), "marche_arriere", {"exemples"}),
        (edited("cap = theta + dtheta / 2", "cap = theta + 0.4 * dtheta"), "position_fausse", {"quelconques"}),
        (edited("L):\n    x, y, theta = pose", "L, deja=[]):\n    deja.append(pose)\n    x, y, theta = deja[-2:][0]"),
         "memoire", {"exemples", "trajet"}),
    ],
)  # fmt: skip
def test_a_mistake_is_refused_and_named(source: str, name: str, checks: set[str]) -> None:
    found = verdict(source, 3)
    assert named(found) == name
    assert checks <= failed(found)


def test_two_mistakes_are_both_told() -> None:
    both = edited("cap = theta + dtheta / 2", "cap = theta + dtheta", "(ds_d + ds_g) / 2", "ds_d + ds_g")
    diagnosis = verdict(both, 1).diagnosis
    assert diagnosis is not None
    assert "cap d'arrivée" in diagnosis.title
    assert "moyennés" in diagnosis.title


def test_a_name_is_not_given_to_what_only_resembles_it() -> None:
    """A slightly wrong length, in curves alone, is none of the mistakes that we know."""
    odd = edited("ds = (ds_d + ds_g) / 2", "ds = (ds_d + ds_g) / 2 * (1 - 0.01 * ((ds_d - ds_g) / L) ** 3)")
    assert named(verdict(odd, 2)) in (None, "position_fausse")


def test_the_counterexample_is_small() -> None:
    found = verdict(edited("cap = theta + dtheta / 2", "cap = theta"), 3).checks[0].counterexample
    assert found is not None
    assert found.inputs == {"pose": [0.0, 0.0, 0.0], "ds_g": 0.0, "ds_d": 1.0, "L": 1.0}


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    source = edited("cap = theta + dtheta / 2", "cap = theta")
    figures: dict[str, Any] = json.loads(json.dumps(checked(EXERCISE, source, 1).figures))
    for check in ("exemples", "trajet"):
        assert counterexample(EXERCISE, figures[check], theme=theme).startswith(b"<?xml")
