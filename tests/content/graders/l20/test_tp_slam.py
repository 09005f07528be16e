"""l20/tp_slam: part A of the practical work as a chain, on the simulated journey and on real scans."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest

from graders.core.code.runner import Runner
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from graders.core.contract.verdict import Verdict
from graders.l20.tp_slam import chain, journeys, maps, small
from graders.plotting import counterexample
from graders.scene.films import wire
from reference.calibration import calibrate_steps
from reference.occupancy import OccupancyGrid
from reference.se2 import relative, wrap_angle
from reference.world.scan import Scan
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import failed, judgement_of, named, verdict_of

GRADER = CODE["l20/tp_slam"]
verdict: Callable[[str, int], Verdict] = partial(verdict_of, GRADER.exercise)
EDITS = () if GRADER.prober is None else GRADER.prober.model.edits


@cache
def judged(name: str) -> Verdict:
    return verdict(next(one for one in GRADER.specimens() if one.path.stem == name).path.read_text(), 0)


@pytest.mark.slow
def test_the_solution_gets_full_marks_and_leaves_two_films() -> None:
    found = judgement_of(GRADER.exercise, GRADER.solution, 0)
    assert found.verdict.score == 1.0
    summaries = [" ".join(wire(GRADER.exercise, found.films[name], "Essai")["summary"]) for name in ("graphe", "intel")]
    assert "0,58 m" in summaries[0]
    assert "10,82 m" in summaries[1]


def test_the_odometry_of_the_laboratory_is_the_robots_own() -> None:
    """It errs by 0.04 rad a step, always the same way: 10.8 m of ATE, where three constants leave 0.8 m."""
    place = journeys.indoor()
    moves, truth = chain.steps_of(place.odometry), chain.steps_of(place.truth)
    missed = wrap_angle(moves[:, 2] - truth[:, 2])
    assert missed.mean() == pytest.approx(-0.040, abs=0.001)
    assert missed.std() == pytest.approx(0.040, abs=0.001)
    assert chain.ate(place.odometry, place.truth) == pytest.approx(10.82, abs=0.01)
    calibrated = calibrate_steps(moves, truth).correct(moves)
    assert chain.ate(journeys.added_up(calibrated), place.truth) == pytest.approx(0.78, abs=0.01)


def test_some_proposed_loops_are_false_and_the_others_outvote_them() -> None:
    """By their rough guesses alone: a third slides along a corridor, with the right heading."""
    place = journeys.indoor()
    missed = np.array([relative(relative(place.truth[a], place.truth[b]), guess) for a, b, guess in place.loops])
    false = np.hypot(missed[:, 0], missed[:, 1]) > 0.5
    assert (len(false), int(false.sum())) == (23, 7)
    assert np.abs(missed[:, 2]).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sans_rien_reprendre", "chemin_et_signature_autres"])
def test_honest_styles_pass(name: str) -> None:
    assert judged(name).score == 1.0
    measured = {check.id: check.message for check in judged(name).checks}
    assert measured["fermetures"].endswith("fermetures, et aucune fausse.")
    assert re.fullmatch(r"L’ATE passe de 0,\d\d m à 0,[01]\d m\.", measured["graphe"])
    assert measured["intel"].startswith("Vos ATE : 0,8")


@pytest.mark.slow
def test_a_stage_that_fails_costs_the_others_nothing() -> None:
    found = judged("boucles_sans_recalage")
    assert failed(found) == {"fermetures"}
    assert (named(found) or "").startswith("sans_confirmation")


@pytest.mark.parametrize("edit", some(EDITS), ids=lambda edit: edit.id)
def test_every_mistake_is_named(edit: object) -> None:
    assert GRADER.prober is not None
    model = GRADER.prober.model
    (mutant,) = model.combine([next(model.correct_versions())], [edit])
    runner = Runner(LOCAL, mutant.text.encode(), GRADER.kit(stream(1, "kit")))
    ids, *_ = GRADER.prober.recognise(runner, list(edit.functions), edit.functions)
    runner.close()
    assert ids == (edit.id,)


def test_the_true_poses_draw_a_map_that_passes() -> None:
    run = journeys.simulated()
    shape, corner = maps.frame()
    keys = range(0, len(run.truth), 8)
    grid = OccupancyGrid(np.zeros(shape), maps.SIDE, [*corner, 0.0])
    for k in keys:
        grid.integrate(Scan.full_turn(run.scans[k], 8.0), run.truth[k])
    poses = run.truth[list(keys)]
    free, walls, count = maps.scores(grid.log_odds, corner, poses, keys)
    assert min(free, walls) > 0.97
    assert count > 2 * maps.LEAST_FREE
    across = maps.scores(grid.log_odds[:, ::-1], corner, poses, keys)
    assert across[1] < maps.WALLS - 0.1


@pytest.mark.parametrize("theme", THEMES)
def test_figures_are_drawn(theme: str) -> None:
    a, pose = small.ROOM.tolist(), small.POSE.tolist()
    match = {"kind": "recalage", "a": a, "b": a, "wanted": pose, "got": [0, 0, 0], "start": pose}
    map_ = {
        "kind": "carte",
        "got": np.zeros(small.SHAPE).tolist(),
        "poses": [[0, 0], [1, 1]],
        "corner": [0, 0],
        "side": 0.5,
    }
    for data in (match, map_):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")
