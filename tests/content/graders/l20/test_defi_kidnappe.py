"""l20/defi_kidnappe: filters that sow elsewhere find the robot again, others do not; what failed is named and drawn."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.loops import ClosedLoop, ClosedLoopRun
from graders.core.code.runner import Runner
from graders.core.code.running import run_checks
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from graders.l20 import journeys, world
from graders.l20.defi_kidnappe import runs
from graders.l20.defi_kidnappe.replays import REPLAYS
from graders.plotting import counterexample
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import failed, named, verdict_of

GRADER = CODE["l20/defi_kidnappe"]
verdict = partial(verdict_of, GRADER.exercise)
HONEST = sorted((GRADER.folder / "specimens/ok").glob("*.py"))
(LOOP,) = (check for check in GRADER.checks if isinstance(check, ClosedLoop))
STEPS = tuple(check for check in GRADER.checks if not isinstance(check, ClosedLoop))


def played(source: bytes, number: int, seed: int) -> tuple[ClosedLoopRun, Rejection | None]:
    """One run, and why it failed if it did."""
    bench = Bench(LOOP.id, Runner(LOCAL, source, world.STILL), np.random.default_rng(seed), world.STILL)
    run = ClosedLoopRun(number, bench)
    try:
        with bench.run_with_kit(LOOP.kit(bench, number)) as run.bench:
            LOOP.play(run)
    except Rejection as lost:
        return run, lost
    return run, None


def failing(source: str, seed: int) -> set[str]:
    """The checks of a few steps that fail."""
    kit = GRADER.kit(stream(seed, "kit"))
    runner = Runner(LOCAL, source.encode(), kit)
    found = run_checks(STEPS, runner, kit, seed)
    runner.close()
    return {finding.result.id for finding in found if not finding.passed}


def test_a_filter_that_always_sows_as_many_anew_passes_the_steps() -> None:
    """The statement gives no size to the clouds of the steps but this one."""
    least = 60
    assert f"{least} particules au moins" in (PROJECT / "curriculum/l20/exercices/defi_kidnappe/enonce.md").read_text()
    wary = GRADER.solution.replace(
        "    particules, poids = un_pas", f"    assert len(poids) >= {least}\n    particules, poids = un_pas"
    )
    assert wary != GRADER.solution
    assert not failing(wary, 2)


def test_the_solution_passes_its_steps_and_finds_the_robot_on_film() -> None:
    assert not failing(GRADER.solution, 2)
    run, lost = played(GRADER.solution.encode(), 0, 1)
    assert lost is None
    assert run.film is not None
    assert len(json.dumps(run.film)) < 64_000
    scene = REPLAYS["kidnappe"](run.film).wire()
    assert "réussi" in scene["summary"][0]
    assert any(mark["label"] == "enlèvement" for mark in scene["charts"][0]["marks"])


@pytest.mark.parametrize(("added", "most", "refused"), [(500, 10**9, True), (100, 900, False)])
def test_a_cloud_that_grows_must_stay_below_the_most_to_the_end_of_a_run(added: int, most: int, refused: bool) -> None:
    source = GRADER.solution.replace(
        "    return particules, poids\n\n\ndef estimer",
        f"    if len(poids) < {most}:\n"
        f"        particules = np.vstack([particules, initialiser({added})])\n"
        "        poids = np.full(len(particules), 1 / len(particules))\n"
        "    return particules, poids\n\n\ndef estimer",
    )
    assert source != GRADER.solution
    assert ("forme" in failing(source, 2)) is refused


@pytest.mark.parametrize("name", ["sans_injection", "injectees_sans_poids", "produit_qui_s_annule"])
def test_mistakes_of_the_challenge_are_named_without_a_loop(name: str) -> None:
    source = next(m.source for m in GRADER.misconceptions if m.id == name)
    found = verdict(source, 4)
    assert named(found) == name
    assert "enlevement" in failed(found)


UNWEIGHTED = """
def estimer(particules, poids):
    gaps = np.hypot(*(particules[:, None, :2] - particules[None, :, :2]).transpose(2, 0, 1))
    near = gaps[(gaps < 0.7).sum(axis=1).argmax()] < 0.7
    x, y, heading = particules[near].T
    return np.array([x.mean(), y.mean(), np.angle(np.exp(1j * heading).sum())])
"""


def test_an_estimate_that_counts_particles_and_not_weights_is_refused_and_named() -> None:
    """Its own steps return equal weights, so that it finds the robot all the same."""
    found = verdict(GRADER.solution + UNWEIGHTED, 2)
    assert failed(found) == {"estimer_poids"}
    assert named(found) == "estimation_sans_poids"


SOWN_FIRST = """
def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    x, y, cap = particules.T
    dx, dy, turn = (u + rng.normal(0, [0.08, 0.08, 0.05], (n, 3))).T
    cap = cap + turn
    after = np.column_stack([x + dx * np.cos(cap) - dy * np.sin(cap), y + dx * np.sin(cap) + dy * np.cos(cap), cap])
    after[rng.choice(n, n // 10, replace=False)] = initialiser(n // 10)
    gaps = np.minimum(np.abs(lidar_lot(after, 36) - scan), 2.0).sum(axis=1)
    w = poids * np.exp(gaps.min() - gaps)
    return after[rng.choice(n, n, p=w / w.sum())], np.full(n, 1.0 / n)
"""


def test_a_turn_before_the_move_is_named_in_a_filter_that_sows_before_it_weighs() -> None:
    assert named(verdict(GRADER.solution + SOWN_FIRST, 2)) == "tourne_avant_d_avancer"


def test_a_heading_without_noise_is_seen_among_particles_that_are_sown_anew() -> None:
    """One drawn noise for two of three numbers: the poses sown near the heap do not hide it."""
    frozen = GRADER.solution.replace("BRUIT = np.array([0.05, 0.05, 0.03])", "BRUIT = np.array([0.05, 0.05, 0.0])")
    assert frozen != GRADER.solution
    assert "dispersion" in failing(frozen, 2)


@pytest.mark.slow
def test_every_way_of_every_mistake_is_refused_and_named() -> None:
    assert GRADER.prober is not None
    for edit in some(GRADER.prober.model.edits):
        source = edit.apply(GRADER.prober.model.text)
        assert source is not None
        found = verdict(source, 1)
        assert failed(found), edit
        assert named(found) == edit.id, edit


@pytest.mark.parametrize("theme", THEMES)
def test_a_robot_that_is_not_found_is_told_and_drawn(theme: str) -> None:
    """The filter of l20/mcl follows the robot, and loses it for good."""
    plain = (GRADER.folder.parent / "mcl/specimens/ok/simple_precision.py").read_bytes()
    run, lost = played(plain, 0, 0)
    assert lost is not None
    assert "n'est pas retrouvé" in lost.message
    assert lost.figure is not None
    assert counterexample(GRADER.exercise, lost.figure, theme=theme).startswith(b"<?xml")
    assert run.film is not None
    assert run.film["lost"] is not None


def test_the_robot_is_carried_far_and_its_wheels_do_not_know() -> None:
    for number in (0, runs.RUNS - 1):
        journey = runs.carried_away(number)
        assert len(journey) == runs.BEFORE + runs.AFTER
        strides = np.hypot(*np.diff(journey.truth[:, :2], axis=0).T)
        assert strides[runs.BEFORE] > runs.CARRIED - journeys.STRIDE
        assert np.delete(strides, runs.BEFORE).max() < journeys.STRIDE + 1e-9
        assert np.hypot(*journey.moves[:, :2].T).max() < journeys.STRIDE + 0.4


@pytest.mark.slow
@pytest.mark.parametrize("path", HONEST, ids=lambda path: path.stem)
def test_honest_filters_find_the_robot(path: Path) -> None:
    """Fewer than one grading in a thousand refuses them: by the chance of each run, over as many draws as are made."""
    draws = 12
    chances = [
        min(float(np.mean([played(path.read_bytes(), k, seed)[1] is None for seed in range(draws)])), 1 - 0.5 / draws)
        for k in range(LOOP.runs)
    ]
    law = np.array([1.0])
    for chance in chances:
        law = np.convolve(law, [1.0 - chance, chance])
    assert law[: LOOP.needed].sum() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("path", HONEST, ids=lambda path: path.stem)
def test_honest_filters_pass_the_checks_of_a_few_steps(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    assert not any(failing(source, seed) for seed in range(30))
