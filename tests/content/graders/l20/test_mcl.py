"""l20/mcl: honest filters pass whatever they draw, mistakes are refused and named, runs are told, filmed and drawn."""

from __future__ import annotations

import json
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.loops import ClosedLoop, ClosedLoopRun
from graders.core.code.runner import Runner
from graders.core.code.running import run_checks
from graders.core.contract.local import LOCAL, initial_globals
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.streams import stream
from graders.l20 import journeys, world
from graders.l20.mcl import memory, probes, runs, steps
from graders.l20.mcl.replays import REPLAYS
from graders.l20.mcl.scenes import HALL_KIT
from graders.plotting import counterexample
from tests.support.quick import THEMES, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, failed, judgement_of, model_with, named, verdict_of

GRADER = CODE["l20/mcl"]
judgement = partial(judgement_of, GRADER.exercise)
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
model = partial(model_with, GRADER.exercise)
HONEST = sorted((GRADER.folder / "specimens/ok").glob("*.py"))
LOOPS = [check for check in GRADER.checks if isinstance(check, ClosedLoop)]


def mistake(name: str) -> str:
    return next(m.source for m in GRADER.misconceptions if m.id == name)


def test_the_solution_gets_full_marks_and_leaves_films() -> None:
    graded = judgement(GRADER.solution, 3)
    assert graded.verdict.score == 1.0
    assert set(graded.films) == {"suivi", "de_nulle_part"}
    for name, steps_made in (("suivi", runs.STEPS), ("de_nulle_part", runs.STEPS_FROM_NOWHERE)):
        film = graded.films[name]
        assert len(json.dumps(film)) < 64_000
        scene = REPLAYS["mcl"](film).wire()
        assert len(scene["frames"]) == steps_made + 1
        assert ("réussi" in scene["summary"][0]) is film["ok"]
    assert graded.films["suivi"]["ok"]


NAMED = ("rotation_oubliee", "bruit_partage", "cap_absent_du_lidar", "jamais_reechantillonne", "copies_oubliees")


@pytest.mark.parametrize("name", NAMED)
def test_mistakes_of_a_step_are_named_without_a_loop(name: str) -> None:
    found = verdict(mistake(name), 5)
    assert named(found) == name
    assert {"suivi", "de_nulle_part"} <= failed(found)
    told = next(check for check in found.checks if check.id == "suivi")
    assert told.message is not None
    assert "ne sont pas lancés" in told.message


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("(u + bruit).T", "(u + 12 * bruit).T", "un bruit bien plus grand"),
        ("c, s = np.cos(cap), np.sin(cap)", "c, s = 1.0, 0.0", "elles restent groupées"),
    ],
)
def test_particles_far_from_the_truth_are_put_down_to_noise_only_where_scattered(
    old: str, new: str, words: str
) -> None:
    told = next(check for check in checked_verdict(model(old, new), 5).checks if check.id == "dispersion")
    assert told.message is not None
    assert words in told.message


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_every_way_of_every_mistake_is_refused_and_named(seed: int) -> None:
    assert GRADER.prober is not None
    text = GRADER.prober.model.text
    for edit in some(GRADER.prober.model.edits):
        source = edit.apply(text)
        assert source is not None
        found = verdict(source, seed)
        assert failed(found), edit
        assert named(found) == edit.id, edit


@pytest.mark.slow
@pytest.mark.parametrize("path", HONEST, ids=lambda path: path.stem)
def test_honest_filters_pass_whatever_they_draw(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    assert [verdict(source, seed).score for seed in range(30)] == [1.0] * 30


def test_there_are_fifteen_honest_filters_at_least() -> None:
    assert len(HONEST) >= 15


def outcome_of(check: ClosedLoop, source: bytes, number: int, seed: int) -> bool:
    """Whether one run succeeds."""
    bench = Bench(check.id, Runner(LOCAL, source, world.STILL), np.random.default_rng(seed), world.STILL)
    try:
        with bench.run_with_kit(check.kit(bench, number)) as own:
            check.play(ClosedLoopRun(number, own))
    except Rejection:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("check", LOOPS, ids=lambda check: check.id)
@pytest.mark.parametrize("path", HONEST, ids=lambda path: path.stem)
def test_an_honest_filter_fails_a_loop_less_than_once_in_a_thousand(path: Path, check: ClosedLoop) -> None:
    """From how often each run succeeds; a run that always did may fail once in as many draws, for want of knowing."""
    draws, source = 20, path.read_bytes()
    chances = [
        np.clip(np.mean([outcome_of(check, source, k, seed) for seed in range(draws)]), 0.0, 1.0 - 0.5 / draws)
        for k in range(check.runs)
    ]
    assert unlucky(chances, check.needed) < 1e-3


def unlucky(chances: list[float], needed: int) -> float:
    """The probability that fewer than `needed` runs succeed, of runs with these chances."""
    law = np.array([1.0])
    for chance in chances:
        law = np.convolve(law, [1.0 - chance, chance])
    return float(law[:needed].sum())


def test_the_probability_of_bad_luck_is_the_binomial_one() -> None:
    assert unlucky([0.8] * 8, 6) == pytest.approx(stats.binom.cdf(5, 8, 0.8))


@pytest.mark.slow
@pytest.mark.parametrize("path", HONEST, ids=lambda path: path.stem)
def test_an_honest_filter_never_fails_a_check_of_one_step(path: Path) -> None:
    checks = tuple(check for check in GRADER.checks if not isinstance(check, ClosedLoop))
    found: Counter[str] = Counter()
    for seed in range(200):
        kit = GRADER.kit(stream(seed, "kit"))
        runner = Runner(LOCAL, path.read_bytes(), kit)
        found.update(f.result.id for f in run_checks(checks, runner, kit, seed) if not f.passed)
        runner.close()
    assert not found


# -- what is shown ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("theme", THEMES)
def test_what_failed_is_drawn(theme: str) -> None:
    graded = checked(GRADER.exercise, mistake("scan_a_l_envers"), 1)
    assert set(graded.figures) == {"pesee", "immobile"}
    picture = counterexample(GRADER.exercise, graded.figures["pesee"], theme=theme)
    assert picture.startswith(b"<?xml")


@pytest.mark.parametrize("theme", THEMES)
def test_a_lost_run_is_told_filmed_and_drawn(theme: str) -> None:
    """A filter that never corrects its places: the check of the run alone, on its first journey."""
    blind = model("    w = peser(nouvelles, poids, scan)", "    w = poids")
    (check,) = (loop for loop in LOOPS if loop.id == "suivi")
    bench = Bench(check.id, Runner(LOCAL, blind.encode(), world.STILL), np.random.default_rng(0), world.STILL)
    run = ClosedLoopRun(0, bench)
    with bench.run_with_kit(check.kit(bench, 0)) as run.bench, pytest.raises(Rejection) as lost:
        check.play(run)
    assert "le robot est en" in lost.value.message
    assert lost.value.figure is not None
    assert counterexample(GRADER.exercise, lost.value.figure, theme=theme).startswith(b"<?xml")
    assert run.film is not None
    assert run.film["lost"] is None or run.film["lost"] > 0
    assert "manqué" in REPLAYS["mcl"](run.film).wire()["summary"][0]


@pytest.mark.parametrize("held", [[0.2, 0.1, 0.0, 0.0], [0.2, 0.0, 0.3, 0.0], [0.0, 0.0, 0.0], [0.1, 0.0, 0.2]])
def test_the_step_that_lost_the_robot_is_after_the_last_that_held_it(held: list[float]) -> None:
    following = runs.Following(ClosedLoopRun(0, None), runs.tracking(0)[0], holding=held)  # type: ignore[arg-type]
    lost = following.lost_at
    assert (lost is None) == (held[-1] >= runs.SOME)
    if lost is not None:
        assert max(held[lost:], default=0.0) < runs.SOME
        assert lost == 0 or held[lost - 1] >= runs.SOME


def test_a_file_that_always_raises_is_told_by_its_exception() -> None:
    source = model("    x, y, cap = particules.T\n    theta", "    x, y = particules.T\n    theta")
    found = checked(GRADER.exercise, source, 1).verdict
    told = {check.id: check.message or "" for check in found.checks}
    assert found.outcome is Outcome.RUNTIME_ERROR
    assert "ValueError" in told["suivi"]
    assert told["suivi"].startswith("Essai 1, pas 1 : ")


# -- the scenes -------------------------------------------------------------------------------------------------------


def test_journeys_stay_on_free_cells_and_are_what_the_statement_says() -> None:
    errors = []
    for number in range(runs.RUNS):
        for journey in (runs.tracking(number)[0], runs.from_nowhere(number)):
            x, y = np.floor(journey.truth[:, :2]).astype(int).T
            assert journey.map.free[y, x].all()
            steps_made = np.hypot(*np.diff(journey.truth[:, :2], axis=0).T)
            assert np.all((np.abs(steps_made - journeys.STRIDE) < 1e-9) | (steps_made < 1e-9))
            cosine, sine = np.cos(journey.truth[:-1, 2]), np.sin(journey.truth[:-1, 2])
            dx, dy = np.diff(journey.truth[:, :2], axis=0).T
            errors.append(journey.moves[:, :2] - np.column_stack([cosine * dx + sine * dy, cosine * dy - sine * dx]))
    assert np.concatenate(errors).std(axis=0) == pytest.approx(journeys.MOVE_NOISE[:2], rel=0.15)


def test_places_along_the_hall_look_the_same() -> None:
    """What the trial of memory rests on: the kit's own lidar reads the same from both clouds, and only at the end of
    the hall something else."""
    scan = initial_globals(HALL_KIT)["lidar"]
    one, other = (scan((x, 4.0, 0.1)) for x in (memory.TWINS[0][0], memory.TWINS[1][0]))
    assert one == pytest.approx(other)
    assert np.count_nonzero(one < HALL_KIT.parameters["portee_max"]) > 3
    assert np.abs(scan((2.2, 4.0, 0.1)) - one).max() > 1.0


def test_only_the_order_of_the_rays_tells_the_heading_of_a_robot_that_turns_on_the_spot() -> None:
    scan = initial_globals(world.STILL)["lidar"]
    for there, elsewhere, move in steps.DOUBTS[-2:]:
        one, other = (scan(np.add(pose, move)) for pose in (there, elsewhere))
        assert move[:2] == (0.0, 0.0)
        assert np.sort(one) == pytest.approx(np.sort(other))
        assert np.abs(one - other).max() > 1.0


def test_the_quick_lidar_of_the_mutants_is_that_of_the_kit() -> None:
    rng = np.random.default_rng(0)
    poses = np.column_stack([rng.uniform(-1, 35, 300), rng.uniform(-1, 14, 300), rng.uniform(-4, 4, 300)])
    assert probes.hall_lidar(poses, 36) == pytest.approx(initial_globals(HALL_KIT)["lidar_lot"](poses, 36))


def test_a_fault_of_the_sandbox_in_a_step_stays_a_fault() -> None:
    """The observation of a trial says which fault there was, and hides none."""
    with pytest.raises(StudentFault):
        steps.well_formed(Bench("forme", Runner(LOCAL, b"def pas_mcl(*a):\n    return 1 / 0\n", world.STILL),
                                np.random.default_rng(0), world.STILL))  # fmt: skip


def test_the_heavier_half_copied_twice_is_no_resampling() -> None:
    """Between two clouds of equal size it does what a comb does; forty particles in 400 keep a fifth of the weight."""
    source = (GRADER.folder / "specimens/wrong_answer/moitie_la_plus_lourde_doublee.py").read_text()
    assert failed(checked_verdict(source, 3)) == {"memoire"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("y + rng.random(n)", "y + x - np.floor(x)", "x et y"),
        ("rng.uniform(-np.pi, np.pi, n)", "2 * np.pi * (x % 1)", "x et le cap"),
    ],
)
def test_coordinates_that_are_not_drawn_apart_are_refused(old: str, new: str, words: str) -> None:
    source = GRADER.solution
    drawn_first = "    x = x + rng.random(n)\n    return np.column_stack([x"
    for text, other in ((old, new), ("    return np.column_stack([x + rng.random(n)", drawn_first)):
        assert source.count(text) == 1
        source = source.replace(text, other)
    shown = checked_verdict(source, 3)
    assert "semer" in failed(shown)
    assert any(f"{words} ne sont pas tirés séparément" in check.message for check in shown.checks)
