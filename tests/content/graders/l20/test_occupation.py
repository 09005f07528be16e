"""l20/occupation: what every reading agrees on is judged, honest walks pass, mistakes are named, the map is filmed."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.l20.occupation import cases
from graders.l20.occupation.bearings import predicted_signs
from graders.l20.occupation.cells import told
from graders.l20.occupation.judge import INCREMENT, Integration, after, judge
from graders.l20.occupation.replays import REPLAYS
from graders.plotting import counterexample
from reference.occupancy import InverseSensorModel, OccupancyGrid
from reference.world.scan import Scan
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, judgement_of, named, verdict_of

GRADER = CODE["l20/occupation"]
graded = partial(judgement_of, GRADER.exercise)
verdict = partial(verdict_of, GRADER.exercise)
DRAWS = (
    cases.along_axes, cases.aslant, cases.at_the_range, cases.at_the_bounds, cases.over_the_edge, cases.whole_scans,
)  # fmt: skip

WALK = """
def vers_logodds(p):
    return np.log(p / (1 - p))

def vers_proba(l):
    return (1 + np.tanh(l / 2)) / 2

def integrer_scan(l, pose, scan, portee_max):
    l = l.copy()
    x, y, theta = pose
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        mur = None
        if z < portee_max:
            r = z + 1e-6
            mur = (int(np.floor(y + r * np.sin(a))), int(np.floor(x + r * np.cos(a))))
        vues = []
        for d in np.arange(0, min(z, portee_max), 0.05):
            case = (int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a))))
            if case not in vues and case != mur:
                vues.append(case)
        for i, j in vues:
            if 0 <= i < H and 0 <= j < W:
                l[i, j] -= 0.847
        if mur is not None and 0 <= mur[0] < H and 0 <= mur[1] < W:
            l[mur] += 0.847
    return np.clip(l, -5, 5)
"""


def edited(*changes: str) -> str:
    """The walk with texts replaced, each found in it."""
    source = WALK
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in source
        source = source.replace(old, new)
    return source


def reference(case: Integration, *, once_a_scan: bool, increment: float = INCREMENT) -> Any:
    grid = OccupancyGrid(case.l, model=InverseSensorModel(increment, -increment, once_a_scan=once_a_scan))
    grid.integrate(Scan.from_sensor(case.scan, 2.0 * np.pi * np.arange(len(case.scan)) / len(case.scan),
                                    case.portee_max), case.pose)  # fmt: skip
    return grid.log_odds


@pytest.mark.parametrize("once_a_scan", [False, True])
def test_the_reference_is_right_in_both_readings(once_a_scan: bool) -> None:
    """`reference.occupancy` knows nothing of the judge: it walks by crossings of lines, the judge by slabs."""
    for seed in range(2):
        for draw in DRAWS:
            for case in some(draw(np.random.default_rng(seed))):
                assert judge(case, reference(case, once_a_scan=once_a_scan, increment=0.847)) is None


def test_whatever_is_judged_is_a_fair_part_of_what_a_ray_meets() -> None:
    for seed in range(3):
        for draw in DRAWS[:5]:
            for case in some(draw(np.random.default_rng(seed))):
                seen = case.told
                assert seen.crossed.sum() >= 1
                assert not np.any(seen.crossed & seen.stopped)
                assert not np.any((seen.crossed | seen.stopped) & seen.untouched)
                changed = reference(case, once_a_scan=False) != case.l
                assert not np.any(changed & seen.untouched)
                assert np.count_nonzero(changed & ~(seen.crossed | seen.stopped | seen.either)) <= 1 + changed.sum() / 2


def test_what_a_ray_grazes_or_stands_on_is_not_judged() -> None:
    grid = told((5, 8), np.array([1.5, 2.5, np.pi / 4]), np.array([2.5]), 12.0)
    judged = grid.crossed | grid.stopped | grid.untouched | grid.either
    assert not judged[2, 1], "the robot's own cell"
    assert not judged[2, 2], "the ray goes through its very corner"
    assert not judged[3, 1]
    assert grid.crossed[3, 2]
    along = told((5, 8), np.array([1.5, 2.0, 0.0]), np.array([3.5]), 12.0)
    assert not np.any(along.crossed | along.stopped), "along a line of the grid, either side will do"


@pytest.mark.parametrize(("step", "walk"), one_in(2, [(1e-9, "0.03"), (0.05, "0.1")]))
def test_any_small_step_and_any_fine_walk_pass(step: float, walk: str) -> None:
    assert verdict(edited("0.05", walk, "1e-6", str(step)), 4).outcome is Outcome.OK


def test_the_solution_gets_full_marks() -> None:
    assert verdict(GRADER.solution, 1).outcome is Outcome.OK


@pytest.mark.parametrize("path", some(sorted((GRADER.folder / "specimens/ok").glob("*.py")))[::6], ids=lambda p: p.stem)
def test_honest_styles_pass(path: Path) -> None:
    found = verdict(path.read_text(encoding="utf-8"), 5)
    assert found.outcome is Outcome.OK, failed(found)


@pytest.mark.parametrize(
    ("source", "where"), one_in(3, [
        (edited("2 * np.pi * k / len(scan)", "2 * np.pi * k / 36"), "scan"),
        (edited("np.clip(l, -5, 5)", "np.clip(l, -5, 4.99)"), "bornes"),
        (edited("np.clip(l, -5, 5)", "l * (np.abs(l) <= 5)"), "bornes"),
        (edited("z < portee_max:", "z <= portee_max:"), "portee"),
        (edited("if case not in vues and case != mur", "if case not in vues"), ""),
        (edited("l[mur] += 0.847", "l[mur] += 0.85"), "axes"),
        (edited("0 <= i < H", "0 <= i < 5", "0 <= mur[0] < H", "0 <= mur[0] < 5"), "scan"),
        (edited("l = l.copy()", "l = np.array(libres, dtype=float) * 0"), "bornes"),
        (edited("l = l.copy()", "l = np.zeros((16, 24))"), "axes"),
        (edited("    return np.clip(l, -5, 5)", "        return np.clip(l, -5, 5)"), "scan"),
        (edited("(1 + np.tanh(l / 2)) / 2", "np.exp(l) / (1 + np.exp(l))"), "proba_extremes"),
        (edited("np.log(p / (1 - p))", "np.array([np.log(q / (1 - q)) for q in p])"), "logodds_nombres"),
        (edited("np.log(p / (1 - p))", "np.log(p / (1 - p)).ravel() if np.ndim(p) else np.log(p / (1 - p))"),
         "logodds_tableaux"),
        (edited("l = l.copy()", "l *= 1"), "arguments"),
    ]),
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_subtly_wrong_answers_are_rejected(source: str, where: str) -> None:
    """But one that is the lesson's own cell, where a ray stops within a cell: see the statement."""
    found = checked(GRADER.exercise, source, 0).verdict
    assert (where in failed(found)) if where else found.outcome is Outcome.OK


MISTAKES = [
    ("arret_sans_pas", edited("r = z + 1e-6", "r = z")),
    ("axes_echanges", edited("l[i, j] -= 0.847", "l[j, i] -= 0.847", "l[mur] +=", "l[mur[1], mur[0]] +=",
                                 "0 <= i < H and 0 <= j < W", "0 <= j < H and 0 <= i < W",
                                 "0 <= mur[0] < H and 0 <= mur[1] < W", "0 <= mur[1] < H and 0 <= mur[0] < W")),
    ("une_voix_par_pas", edited("case not in vues and case != mur", "case != mur")),
    ("sans_borne", edited("np.clip(l, -5, 5)", "l")),
    ("troncature", edited("np.floor(", "(")),
    ("flottants_seulement", "import math\n" + edited("np.log(p / (1 - p))", "math.log(p / (1 - p))")),
    ("sens_des_rayons", edited("theta + 2", "theta - 2")),
    ("cap_oublie", edited("theta + 2", "2")),
    ("pas_trop_grand", edited("0.05", "0.5")),
    ("portee_est_un_mur", edited("        if z < portee_max:", "        if True:")),
    ("indices_negatifs", edited("0 <= i < H and 0 <= j < W", "i < H and j < W",
                                    "0 <= mur[0] < H and 0 <= mur[1] < W", "mur[0] < H and mur[1] < W")),
    ("signes_echanges", edited("-= 0.847", "+= .847", "+= 0.847", "-= .847")),
    ("grille_oubliee", edited("l = l.copy()", "l = np.zeros((H, W))")),
    ("exponentielle_deborde", "import math\n" + edited("(1 + np.tanh(l / 2)) / 2",
                                                           "np.exp(l) / (np.exp(l) + 1)")),
    ("log_odds_ecretes", edited("(1 + np.tanh(l / 2)) / 2", "1 / (1 + np.exp(-np.clip(l, -6.0, 6.0)))")),
    ("signe_exponentielle", edited("(1 + np.tanh(l / 2)) / 2", "1 / (1 + np.exp(l))")),
]  # fmt: skip


@pytest.mark.parametrize(("name", "source"), one_in(4, MISTAKES))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_mistake_is_recognised_in_another_style(name: str, source: str) -> None:
    assert named(verdict(source, 2)) == name


def test_cells_that_are_updated_at_each_step_are_told_whatever_the_step() -> None:
    source = edited("case not in vues and case != mur", "case != mur", "0.05", "0.07")
    assert named(verdict(source, 2)) == "une_voix_par_pas"


def test_the_first_counterexample_is_one_ray_to_the_left() -> None:
    checks = checked(GRADER.exercise, edited("r = z + 1e-6", "r = z"), 3, simplified=True).verdict.checks
    found = next(c for c in checks if c.id == "axes")
    assert "le rayon s’y arrête" in found.message
    assert found.counterexample.expected == pytest.approx(
        {"(2, 2)": INCREMENT, "(2, 3)": -INCREMENT, "(2, 4)": -INCREMENT, "(2, 5)": -INCREMENT}
    )
    assert found.counterexample.got["(2, 2)"] == 0.0


def test_a_drawn_counterexample_is_brought_back_to_an_empty_grid() -> None:
    source = edited("l[mur] += 0.847", "l[mur] += 0.847 * (np.abs(theta) in (0, np.pi, np.pi / 2) or l.any() == 0)")
    checks = checked(GRADER.exercise, source, 2, simplified=True).verdict.checks
    found = next(c for c in checks if c.id == "bornes")
    assert found.counterexample is not None
    assert any("non nulles" in name for name in found.counterexample.inputs)


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    drawn = checked(GRADER.exercise, edited("theta + 2", "2"), 1).figures
    nothing = checked(GRADER.exercise, edited("return np.clip(l, -5, 5)", "return l[1:]"), 1).figures
    for data in json.loads(json.dumps((drawn["carte"], nothing["obliques"]))):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


def test_the_map_is_filmed_beside_that_which_is_expected() -> None:
    right = json.loads(json.dumps(graded(WALK, 1).films["carte"]))
    assert right["wrong"] is None
    assert len(json.dumps(right)) < 60_000
    body = REPLAYS[right["kind"]](right).wire()
    assert len(body["frames"]) == len(right["maps"])
    assert not any(body["charts"][0]["series"][0]["y"])
    wrong = json.loads(json.dumps(checked(GRADER.exercise, edited("theta + 2", "theta - 2"), 1).films["carte"]))
    assert wrong["wrong"] == 0
    body = REPLAYS[wrong["kind"]](wrong).wire()
    assert body["charts"][0]["marks"][0]["x"] == 1
    assert "s’écarte de la règle" in body["frames"][0]["caption"]


@pytest.mark.parametrize("answer", ["None", "1 / 0"])
def test_a_film_that_stops_is_told(answer: str) -> None:
    source = edited(
        "    return np.clip(l, -5, 5)", f"    return np.clip(l, -5, 5) if len(scan) < 36 or x < 10 else {answer}"
    )
    film = json.loads(json.dumps(checked(GRADER.exercise, source, 1).films["carte"]))
    assert film["wrong"] == len(film["maps"]) > 0
    assert "le film s’arrête là" in " ".join(REPLAYS["map"](film).wire()["summary"])


@pytest.mark.parametrize("value", [None, 3, "l", {}, [], [[1, 2], [3]], np.zeros((4, 8)), np.full((5, 8), np.inf),
                                   np.full((5, 8), 1e300), np.full((5, 8), 1j)])  # fmt: skip
def test_any_value_is_judged_without_an_exception(value: Any) -> None:
    case = next(iter(cases.along_axes(np.random.default_rng(0))))
    wrong = judge(case, value)
    assert wrong is not None
    assert wrong.mismatch.message.endswith(".")


def test_one_ray_is_worth_what_the_statement_says() -> None:
    first, again = (
        next(iter(cases.at_the_bounds(np.random.default_rng(0)))),
        cases.one_ray(cases.at(1.5, 2.5, 0.0), 3.5),
    )
    np.testing.assert_allclose(after(first)[2], 2.0 * after(again)[2])
    np.testing.assert_allclose(after(again)[2, 2:7] / INCREMENT, [-1, -1, -1, 1, 0])


SAMPLED = """
def integrer_scan(l, pose, scan, portee_max):
    \"\"\"Samples each ray; a wall wins over the rays that cross it in the same scan.\"\"\"
    x, y, theta = pose
    falls, rises = np.zeros(l.shape, bool), np.zeros(l.shape, bool)

    def mark(grid, r, a):
        i, j = int(np.floor(y + r * np.sin(a))), int(np.floor(x + r * np.cos(a)))
        if 0 <= i < l.shape[0] and 0 <= j < l.shape[1]:
            grid[i, j] = True

    for z, a in zip(scan, BEARINGS):
        for r in np.arange(0.0, min(z, portee_max), 0.02):
            mark(falls, r, a)
        if z < portee_max:
            mark(rises, z + 1e-6, a)
    return np.clip(l + 0.8473 * np.where(rises, 1.0, -1.0 * falls), -5, 5)
"""


@pytest.mark.parametrize(
    ("bearings", "name"),
    [
        ("theta + np.linspace(0, 2 * np.pi, len(scan))", "rayons_mal_repartis"),
        ("theta + 2 * np.pi * np.arange(1, len(scan) + 1) / len(scan)", "rayons_mal_repartis"),
        ("theta - np.pi + 2 * np.pi * np.arange(len(scan)) / len(scan)", "rayons_mal_repartis"),
        ("theta - 2 * np.pi * np.arange(len(scan)) / len(scan)", "sens_des_rayons"),
        ("theta + np.pi * np.arange(len(scan)) / len(scan)", "demi_tour_seulement"),
    ],
)
def test_wrong_bearings_are_named_whatever_happens_where_rays_meet(bearings: str, name: str) -> None:
    source = GRADER.solution + SAMPLED.replace("BEARINGS", bearings)
    assert named(verdict(source, 1)) == name


def test_the_right_bearings_predict_the_right_signs() -> None:
    case = Integration(np.zeros((7, 11)), np.array([3.5, 2.5, 0.2]), np.array([2.5, 1.5, 1.4, 2.2]), 12.0)
    signs, is_certain = predicted_signs(case, 0.5 * np.pi * np.arange(4))
    seen = case.told
    assert np.array_equal((signs > 0) & is_certain, seen.stopped & is_certain)
    assert np.array_equal((signs < 0) & is_certain, seen.crossed & is_certain)
    assert is_certain.sum() > 50
