"""l20/defi_amers: H and b against finite differences, any honest road to the optimum passes, mistakes are named."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats
from graders.l20.defi_amers import asked, maps, optimum, system
from graders.l20.defi_amers.replays import REPLAYS
from graders.plotting import counterexample
from tests.support.quick import THEMES, only, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, judgement_of, named, verdict_of

GRADER = CODE["l20/defi_amers"]
graded = partial(judgement_of, GRADER.exercise)
verdict = partial(verdict_of, GRADER.exercise)

SYSTEM_CHECKS = {"systeme_aretes", "systeme_exemples", "systeme_hasard", "systeme_tours"}
SPECIMENS = {one.path.stem: one.path.read_text(encoding="utf-8") for one in GRADER.specimens()}
HONEST = sorted(one.path.stem for one in GRADER.specimens() if one.outcome is Outcome.OK)
#: Quick, and as unlike as can be: numeric, recursive, in the other convention.
FEW = ("differences_finies", "recursif_generateur", "autre_convention")


def whitened(one: maps.Map, state: Floats) -> Floats:
    """All errors of a map, written here anew from the statement, so that chi2 is their sum of squares."""
    poses, landmarks = state[: one.poses.size].reshape(-1, 3), state[one.poses.size :].reshape(-1, 2)
    errors = []
    for i, j, z, omega in (*one.edges, *one.sightings):
        x, y, theta = poses[i]
        target = poses[j] if len(z) == 3 else landmarks[j]
        away = (target[0] - x + 1j * (target[1] - y)) * np.exp(-1j * theta) - complex(z[0], z[1])
        turn = [np.angle(np.exp(1j * (target[2] - theta - z[2])))] if len(z) == 3 else []
        errors.append(np.linalg.cholesky(omega).T @ [away.real, away.imag, *turn])
    return np.concatenate(errors)


def state_of(one: maps.Map) -> Floats:
    return np.concatenate([one.poses.ravel(), one.landmarks.ravel()])


@pytest.mark.parametrize("drawn", [asked.systems, asked.random_systems, asked.wrapping_systems])
def test_h_and_b_are_those_of_finite_differences(drawn: object) -> None:
    for one in some(drawn(np.random.default_rng(5))):  # type: ignore[operator]
        state, step = state_of(one), 1e-6
        columns = [
            (whitened(one, state + step * d) - whitened(one, state - step * d)) / (2 * step) for d in np.eye(len(state))
        ]
        J = np.column_stack(columns)
        H, b = one.system
        np.testing.assert_allclose(H, J.T @ J, atol=1e-6 * np.abs(H).max())
        np.testing.assert_allclose(b, J.T @ whitened(one, state), atol=1e-5)


@pytest.mark.parametrize("drawn", [asked.exact, asked.shared, asked.weighted, asked.turning])
def test_the_optimum_is_that_of_scipy(drawn: object) -> None:
    for one in some(drawn(np.random.default_rng(8))):  # type: ignore[operator]
        state = state_of(one)
        found = least_squares(lambda free, m=one, s=state: whitened(m, np.concatenate([s[:3], free])), state[3:])
        poses, landmarks = one.optimum
        assert 2.0 * found.cost == pytest.approx(one.chi2(poses, landmarks), abs=1e-8)
        np.testing.assert_allclose(found.x[one.poses.size - 3 :], landmarks.ravel(), atol=1e-4)


def test_maps_settle_well_before_the_last_iteration() -> None:
    for drawn in (asked.exact, asked.shared, asked.weighted, asked.turning, asked.tours):
        for one in drawn(np.random.default_rng(3)):
            assert maps.settles(one)
            assert all(any(j == seen[1] for seen in one.sightings) for j in range(len(one.landmarks)))


@pytest.mark.parametrize("name", only(FEW, HONEST))
def test_honest_styles_pass(name: str) -> None:
    assert failed(verdict(SPECIMENS[name], 4)) == set()


def edited(old: str, new: str) -> str:
    assert old in GRADER.solution
    return GRADER.solution.replace(old, new)


STYLES = {
    "the landmark's frame": ("amer_dans_le_monde", "return position - z,", "return amer - pose[:2] - z,"),
    "landmarks first": ("indices_des_amers", "3 * n + 2 * j, 3 * n + 2 * j + 2", "2 * j, 2 * j + 2"),
    "written over": ("blocs_ecrases", "H[lignes, colonnes] +=", "H[lignes, colonnes] ="),
    "held in the system": ("jauge_dans_le_systeme", "    return H, b\n", "    return H[3:, 3:], b[3:]\n"),
    "landmarks left": ("amers_immobiles", "a += pas[3 * n :].reshape(-1, 2)", "pass"),
    "no gauge": ("jauge_libre", "pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])", "pas = np.linalg.solve(H, -b)"),
    "away": ("signe_du_pas", "np.linalg.solve(H[3:, 3:], -b[3:])", "np.linalg.solve(H[3:, 3:], b[3:])"),
    "one step": ("une_seule_iteration", "range(n_iter)", "range(1)"),
    "in place": (
        "tableaux_ecrases",
        "x, a = np.array(poses, dtype=float), np.array(amers, dtype=float)",
        "x, a = poses, amers",
    ),
    "not wrapped": ("difference_non_ramenee", "ramener(xj[2] - xi[2] - z[2])", "xj[2] - xi[2] - z[2]"),
}


#: Of the others the names are asked in the slow suite.
NAMED = ("in place",)


@pytest.mark.parametrize("style", only(NAMED, STYLES))
def test_a_mistake_is_named_in_another_program_than_the_model(style: str) -> None:
    name, old, new = STYLES[style]
    assert named(verdict(edited(old, new), 6)) == name


def test_a_system_of_the_wrong_kind_is_told_what_is_missing() -> None:
    one = asked.systems(np.random.default_rng(0))[0]
    found = system.judge(one, one.system[0])
    assert found is not None
    assert "deux choses" in found.message
    assert found.cause is Outcome.INVALID_OUTPUT


def test_what_comes_back_in_other_forms_is_read() -> None:
    one = asked.random_systems(np.random.default_rng(1))[0]
    H, b = one.system
    for got in ((H, -b), [H.tolist(), b[:, None]], (H * (1 + 5e-5), b)):
        assert system.judge(one, got) is None
    for got in ((H * (1 + 5e-4), b), (H, b + 0.2), (H[3:, 3:], b[3:]), (b, H), (2 * H, 2 * b), H, None, (H, b, 0)):
        assert system.judge(one, got) is not None


def test_hostile_maps_are_refused_without_an_error_of_ours() -> None:
    one = asked.shared(np.random.default_rng(1))[0]
    huge = np.full((2, 3), 1e300)
    for got in (
        None,
        3,
        "x",
        (one.poses, None),
        (huge, one.landmarks),
        (one.poses * np.nan, one.landmarks),
        [[1], [2, 3]],
    ):
        assert optimum.judge(one, got) is not None


def test_systems_are_not_blamed_for_a_wrong_iteration_nor_the_reverse() -> None:
    one_step = checked(GRADER.exercise, edited("range(n_iter)", "range(1)"), 3).verdict
    assert failed(one_step)
    assert failed(one_step).isdisjoint(SYSTEM_CHECKS)
    own = (
        GRADER.solution
        + "\n\njuste = systeme\n\n"
        + "def systeme(*donnees):\n    H, b = juste(*donnees)\n    return H / 2, b / 2\n"
    )
    assert failed(checked(GRADER.exercise, own, 3).verdict) == SYSTEM_CHECKS


def test_counterexamples_are_small() -> None:
    source = edited("a += pas[3 * n :].reshape(-1, 2)", "pass")
    found = checked(GRADER.exercise, source, 3, simplified=True).verdict
    check = next(c for c in found.checks if c.id == "partage")
    assert check.counterexample is not None
    assert check.counterexample.inputs["poses"] == [[0, 0, 0], [2, 0, 0]]
    assert "amer 0 vu de 0" in check.message


def test_the_example_of_the_statement_is_right() -> None:
    one = asked.line(7.0)
    poses, landmarks = one.optimum
    np.testing.assert_allclose(poses, [[0, 0, 0], [3, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(landmarks, [[6, 0]], atol=1e-9)
    assert [one.solution.chi2[0], one.solution.chi2[-1]] == pytest.approx([9, 3])
    np.testing.assert_allclose(one.system[0][6:, 6:], 2 * np.eye(2))


def test_the_solution_gets_full_marks_and_the_film_shows_iterations_and_where_they_go_wrong() -> None:
    judged = graded(GRADER.solution, 1)
    assert judged.verdict.outcome is Outcome.OK
    right = judged.films["tour"]
    replay = REPLAYS[right["kind"]](json.loads(json.dumps(right)))
    assert "Vous y êtes" in replay.wire()["summary"][1]
    source = edited("np.linalg.solve(H[3:, 3:], -b[3:])", "np.linalg.solve(H[3:, 3:], b[3:])")
    wrong = checked(GRADER.exercise, source, 1).films["tour"]
    away = REPLAYS[wrong["kind"]](json.loads(json.dumps(wrong)))
    assert away.charts[0].marks
    assert "ici" in away.frames[1].caption


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = checked(GRADER.exercise, edited("return position - z,", "return amer - pose[:2] - z,"), 1).figures
    for check in ("systeme_exemples", "partage")[theme == "light" :]:
        data = json.loads(json.dumps(figures[check]))
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


FREE = """

def slam_amers(poses, amers, aretes, observations, n_iter=10):
    x, a = np.array(poses, dtype=float), np.array(amers, dtype=float)
    for _ in range(n_iter):
        H, b = systeme(x, a, aretes, observations)
        step = np.linalg.lstsq(H, -b, rcond=1e-9)[0]
        x, a = x + step[: x.size].reshape(-1, 3), a + step[x.size :].reshape(-1, 2)
    back = poses[0] - x[0]
    x[0] = poses[0]
{}
    x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x, a
"""


@pytest.mark.parametrize(
    ("rest", "name"),
    [
        ("    x[1:], a = x[1:] + back, a + back[:2]", "carte_detachee"),
        ("    pass", "carte_detachee"),
        ("    x[1:] += back", "amers_mal_remis"),
    ],
)
def test_a_free_map_put_back_without_its_turn_is_named(rest: str, name: str) -> None:
    assert named(verdict(GRADER.solution + FREE.format(rest), 1)) == name
