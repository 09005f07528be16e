"""l20/tp_slam: part A of the practical work as a chain, on the simulated journey and on real scans."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.runner import Runner
from graders.core.code.running import FIGURE_ITEMS
from graders.core.compare.words import to_complete_jsonable
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from graders.core.contract.values import Value
from graders.core.contract.verdict import Verdict
from graders.l20.tp_slam import chain, journeys, maps, places, real, small
from graders.l20.tp_slam.replays import REPLAYS
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


def bench(answer: Value, failed: frozenset[str] = frozenset()) -> Any:
    """A bench on which every call gives the same answer, with the films that are left on it."""
    films: list[dict[str, Any]] = []
    return SimpleNamespace(
        call=lambda function, *args: answer,
        observe=lambda *args, **more: None,
        record_film=films.append,
        films=films,
        runner=Told(failed),
    )


@dataclass(frozen=True, eq=False)
class Told:
    failed: frozenset[str]
    reenacting: bool = False


def rejection(protocol: Callable[[Bench], None], answer: Value, failed: frozenset[str] = frozenset()) -> Rejection:
    with pytest.raises(Rejection) as refused:
        protocol(bench(answer, failed))
    return refused.value


def test_a_wrong_map_is_told_by_one_cell_in_words_and_drawn() -> None:
    right = OccupancyGrid(np.zeros(small.SHAPE), small.SIDE, [*small.CORNER, 0.0])
    right.integrate(Scan.full_turn(small.SCAN, 8.0), small.PLACES[0])
    upside_down = rejection(small.maps, right.log_odds[::-1])
    assert upside_down.message.startswith("Un scan de quatre rayons : la case (6, 2) (ligne, colonne) devrait être occ")
    assert upside_down.expected == "un log-odds positif dans la case (6, 2)"
    assert upside_down.got == "−0,847 dans la case (6, 2)"
    assert upside_down.figure is not None
    assert upside_down.figure["kind"] == "petite_carte"
    shape = rejection(small.maps, right.log_odds.T)
    assert (shape.expected, shape.got, shape.figure) == ("forme (12, 30)", "forme (30, 12)", None)


def test_a_wrong_graph_is_drawn_and_its_journey_filmed() -> None:
    """A small graph fails: what the whole journey comes to is looked at all the same."""
    assert rejection(small.graphs, small.CHAINED).message.startswith("Quatre poses, une boucle : la pose")
    both = small.then(small.graphs, lambda bench: None, shown=lambda bench: bench.record_film({"kind": "x"}))
    on = bench(small.CHAINED)
    with pytest.raises(Rejection):
        both(on)
    assert on.films == [{"kind": "x"}]


def test_a_film_of_what_is_not_judged_says_so() -> None:
    keys = [0, 5, 10]
    poses = journeys.simulated().truth[keys]
    data = {"kind": "chaine", "place": "simule", "keys": keys, "loops": [], "odometry": poses, "matched": poses}
    first, *_ = REPLAYS["chaine"]({**data, "solved": poses, "unjudged": True}).summary
    assert first.startswith("Ce qui échoue est le petit graphe")
    assert "petit graphe" not in " ".join(REPLAYS["chaine"]({**data, "solved": poses}).summary)


def test_inputs_by_hand_are_short_numbers() -> None:
    """They are copied to be tried at home: `0.020000000000000004` is no number that anyone has chosen."""
    for args in small.GRAPHS:
        for number in np.hstack([np.ravel(value) for value in (*args[:3], *(z for _, _, z in args[3]))]).tolist():
            assert len(repr(abs(number))) <= 6


def test_no_reading_of_a_walk_goes_beyond_the_reach_that_is_told() -> None:
    """A reading of 8 m sees nothing: one of 11 m would be read as a point by some, and by others not."""
    for walk in places.WALKS:
        assert walk.scans.max() <= places.REACH
        assert walk.scans.min() > 0.0


def test_the_real_place_is_not_judged_before_its_stages_pass() -> None:
    waiting = rejection(real.through_the_laboratory, None, frozenset({"graphe"}))
    assert waiting.neutral


def test_errors_of_two_orders_of_magnitude_are_shown_by_their_logarithms() -> None:
    place, found = journeys.indoor(), journeys.matched_indoor()
    first, matched = journeys.added_up(found.first), journeys.added_up(found.matches)
    begun = {"kind": "chaine", "place": "intel", "keys": [], "loops": [], "odometry": place.odometry, "matched": first}
    whole = {**begun, "before": first, "matched": matched, "solved": matched}
    replays = [REPLAYS["chaine"](data) for data in (begun, whole)]
    assert [len(replay.frames) for replay in replays] == [2, 5]
    assert [replay.charts[0].logarithmic for replay in replays] == [False, True]
    lowest = replays[1].charts[0].y_range[0]
    assert lowest is not None
    assert 0.0 < lowest < 0.2
    for replay in replays:
        x, y = place.odometry[:, 0], place.odometry[:, 1]
        view = replay.view
        assert view.x0 < x.min() <= x.max() < view.x1
        assert view.y0 < y.min() <= y.max() < view.y1
        assert "Inf" not in str(replay.wire())


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
    small_map = rejection(small.maps, np.ones(small.SHAPE)).figure
    graph = rejection(small.graphs, small.CHAINED).figure
    for data in (match, map_, small_map, graph):
        recorded = to_complete_jsonable(data, limit=FIGURE_ITEMS)
        assert counterexample(GRADER.exercise, recorded, theme=theme).startswith(b"<?xml")


@pytest.mark.parametrize("stage", ["matches", "loops"])
def test_what_the_course_lends_goes_with_its_key_poses(stage: str) -> None:
    """Whoever adds up turns has another number of key poses: lent matches or loops would not fit them."""
    course = chain._course()
    others = [*course.keys, course.keys[-1] + 1]
    matched = np.zeros((len(others) - 1, 3)) if stage == "loops" else None
    lent = chain.Chain(chain.Results(keys=others, matches=matched))
    keys, matches = lent.matched()
    assert len(matches) == len(keys) - 1
    assert len(keys) == len(others) - (stage == "matches")
    keys, matches, loops = lent.closed()
    assert (keys, len(matches), loops) == (course.keys, len(keys) - 1, course.loops)
    assert lent.borrowed
