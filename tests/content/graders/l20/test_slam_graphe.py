"""l20/slam_graphe: any honest road to the optimum passes, mistakes are rejected and named in several styles."""

from __future__ import annotations

import json
import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.contract.outcomes import Outcome
from graders.plotting import counterexample
from graders.robotics.turned import is_detached_from_first, turn_about_first
from tests.support.quick import THEMES, one_in
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, failed, named, plain_verdict_of, verdict_of

GRADER = CODE["l20/slam_graphe"]
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
checks_of = partial(checked, GRADER.exercise)

ERROR_CHECKS = {"erreur_exemples", "erreur_hasard", "erreur_tours"}
GRAPH_CHECKS = {"chaine", "boucle", "poids", "demi_tour", "grande_boucle"}

SPECIMENS = {path.stem: path.read_text(encoding="utf-8") for path in (GRADER.folder / "specimens").glob("*/*.py")}
NUMERIC, VECTORS, COMPOSED = SPECIMENS["numerique_dense"], SPECIMENS["lots_numpy"], SPECIMENS["variete"]
SPARSE = SPECIMENS["creux_scipy"]


def edited(source: str, old: str, new: str) -> str:
    assert old in source
    return source.replace(old, new)


def misconception(name: str) -> str:
    return next(m.source for m in GRADER.misconceptions if m.id == name)


@pytest.mark.parametrize("seed", range(2))
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).outcome is Outcome.OK


GAUGE = "1e9 * np.eye(3)"
HONEST = {
    "forward differences of 1e-3": edited(NUMERIC, "h = 1e-6", "h = 1e-3"),
    "forward differences of 1e-8, weak prior": edited(edited(NUMERIC, "h = 1e-6", "h = 1e-8"), GAUGE, "np.eye(3)"),
    "prior of a million": edited(NUMERIC, GAUGE, "1e6 * np.eye(3)"),
    "half turn written -pi": edited(GRADER.solution, "np.pi - (np.pi - angle) % (2 * np.pi)", "-ramene(-angle)")
    + "\n\ndef ramene(angle):\n    return np.pi - (np.pi - angle) % (2 * np.pi)\n",
    "no early stop": edited(GRADER.solution, "break", "pass"),
    "stops at a thousandth": edited(GRADER.solution, "< 1e-10", "< 1e-4"),
    "little damping": edited(GRADER.solution, "H = J.T @ W @ J", "H = J.T @ W @ J + 1e-4 * np.eye(J.shape[1])"),
    "default set to None": edited(GRADER.solution, "n_iter=10):", "n_iter=None):\n    n_iter = n_iter or 10"),
    "many more iterations": edited(GRADER.solution, "range(n_iter)", "range(100)"),
    "composed steps, error by difference": edited(
        COMPOSED,
        "def derivee",
        """def erreur(a, b, m):
    e = vecteur(np.linalg.inv(Pose(*a).matrice()) @ Pose(*b).matrice()) - m
    e[2] = np.arctan2(np.sin(e[2]), np.cos(e[2]))
    return list(e)


def derivee""",
    ).replace("return np.stack([(f(h * v) - f(-h * v))", "return np.stack([(np.array(f(h * v)) - np.array(f(-h * v)))"),
}


@pytest.mark.parametrize("name", one_in(10, HONEST))
def test_honest_variants_pass(name: str) -> None:
    assert failed(verdict(HONEST[name], 4)) == set()


LEAST_SQUARES = SPECIMENS["scipy_least_squares"]
STYLES = {
    "residuals weighted by the whole weight": ("omega_mal_employee", edited(LEAST_SQUARES, "np.sqrt(om) @", "om @")),
    "residuals weighted by the fourth root": (
        "omega_mal_employee",
        edited(LEAST_SQUARES, "np.sqrt(om) @", "np.sqrt(np.sqrt(om)) @"),
    ),
    "sign of the step, numeric": ("signe_du_pas", edited(NUMERIC, "solve(H, -b)", "solve(H, b)")),
    "sign of the step, vectors": ("signe_du_pas", edited(VECTORS, "x -= np", "x += np")),
    "sign of the step, rounding otherwise": ("signe_du_pas", edited(VECTORS, "x -= np", "x += (1.0 + 1e-6) * np")),
    "weights ignored, numeric": (
        "omega_ignoree",
        edited(NUMERIC, "omega in aretes:", "_ in aretes:\n            omega = np.eye(3)"),
    ),
    "weights ignored, vectors": (
        "omega_ignoree",
        edited(VECTORS, "np.stack([a[3] for a in aretes])", "np.stack([np.eye(3) for a in aretes])"),
    ),
    "weights missing in H, sparse": ("omega_absente_de_h", edited(SPARSE, "J.T @ om @ J", "J.T @ J")),
    "closures left out, numeric": (
        "fermetures_ignorees",
        edited(
            NUMERIC,
            "e = erreur(x[i], x[j], z)\n",
            "e = erreur(x[i], x[j], z)\n            if j != i + 1:\n                continue\n",
        ),
    ),
    "error not wrapped, vectors": (
        "erreur_non_ramenee",
        edited(VECTORS, "e[:, 2] = np.angle(np.exp(1j * e[:, 2]))", "pass"),
    ),
    "error not wrapped in the other convention": (
        "erreur_non_ramenee",
        edited(
            NUMERIC,
            "a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(angle), np.cos(angle))",
            "a[1] + s * b[0] + c * b[1], angle",
        ),
    ),
    "one wrap of two, sparse": (
        "difference_non_ramenee",
        edited(SPARSE, "w(w(xj[2] - xi[2]) - z[2])", "w(xj[2] - xi[2]) - z[2]"),
    ),
    "angles left as they come, numeric": (
        "angles_jamais_ramenes",
        edited(NUMERIC, "        x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))\n", ""),
    ),
    "no gauge, numeric": ("jauge_libre", edited(NUMERIC, "H[:3, :3] += 1e9 * np.eye(3)", "pass")),
    "no gauge, smallest step": (
        "jauge_libre",
        edited(
            edited(NUMERIC, "H[:3, :3] += 1e9 * np.eye(3)", "pass"),
            "np.linalg.solve(H, -b)",
            "np.linalg.lstsq(H, -b, rcond=1e-9)[0]",
        ),
    ),
    "no gauge, sparse": ("jauge_libre", edited(SPARSE, "H[:3, :3] = H[:3, :3] + sp.eye(3)", "pass")),
    "derivative by the heading forgotten, vectors": (
        "jacobienne_sans_cap",
        edited(
            VECTORS,
            "[-c, -s, -s * d[:, 0] + c * d[:, 1]], [s, -c, -c * d[:, 0] - s * d[:, 1]]",
            "[-c, -s, o], [s, -c, o]",
        ),
    ),
    "one iteration, numeric": ("une_seule_iteration", edited(NUMERIC, "range(n_iter)", "range(1)")),
    "start given back": ("poses_de_depart", edited(NUMERIC, "    return x\n", "    return poses\n")),
    "written in place, numeric": ("poses_ecrasees", edited(NUMERIC, "x = poses.copy()", "x = poses")),
    "world frame, sparse": ("repere_du_monde", edited(SPARSE, "R.T @ (xj[:2] - xi[:2])", "(xj[:2] - xi[:2])")),
    "turned the wrong way, sparse": ("rotation_a_l_envers", edited(SPARSE, "R.T @", "R @")),
}


@pytest.mark.parametrize("style", one_in(5, STYLES))
def test_a_mistake_is_named_whatever_the_style(style: str) -> None:
    name, source = STYLES[style]
    found = plain_verdict_of(GRADER.exercise, source, 6)
    assert found.diagnosis is not None, failed(found)
    assert found.diagnosis.id == name


AFTER = """

right = gauss_newton

def gauss_newton(poses, aretes, n_iter=10):
    x = right(poses, aretes, n_iter)
    """
MIXED = """

right = erreur

def erreur(xi, xj, z):
    return right(xi, xj, z) if xi[0] > 0 else relatif(z, relatif(xi, xj))
"""
IN_ORDER = """

right = lineariser

def lineariser(poses, aretes):
    n = len(poses)
    return right(poses, [(k, k + 1, *a[2:]) if k < n - 1 else a for k, a in enumerate(aretes)])
"""
SHORT = """def erreur(xi, xj, z):
    return composer(inverse(z), composer(inverse(xi), xj))[:2]


def gauss_newton"""
SUBTLE = {
    "edges taken to come in order": ({"boucle"}, GRADER.solution + IN_ORDER),
    "a pose a thousandth away": (GRAPH_CHECKS, GRADER.solution + AFTER + "x[-1, 0] += 1e-3\n    return x\n"),
    "a heading a thousandth away": (GRAPH_CHECKS, GRADER.solution + AFTER + "x[-1, 2] += 1e-3\n    return x\n"),
    "all poses moved by a thousandth": (GRAPH_CHECKS, GRADER.solution + AFTER + "x[:, 1] += 1e-3\n    return x\n"),
    "flat": (GRAPH_CHECKS, GRADER.solution + AFTER + "return x.ravel()\n"),
    "first pose left out": (GRAPH_CHECKS, GRADER.solution + AFTER + "return x[1:]\n"),
    "nan": (GRAPH_CHECKS, GRADER.solution + AFTER + "return x * np.nan\n"),
    "angles in [0, 2 pi[": (
        {"demi_tour"},
        GRADER.solution + AFTER + "x[:, 2] %= 2 * np.pi\n    return x\n",
    ),
    "no default for n_iter": ({"grande_boucle"}, edited(GRADER.solution, "n_iter=10", "n_iter")),
    "measurements wrapped in place": (
        {"arguments"},
        GRADER.solution + AFTER + "for a in aretes:\n        a[2][:] = 0\n    return x\n",
    ),
    "now one convention, now the other": ({"erreur_hasard"}, GRADER.solution + MIXED),
    "error without its angle": (
        ERROR_CHECKS,
        edited(
            NUMERIC,
            "def gauss_newton",
            SHORT,
        ),
    ),
    "only the first twelve edges": (
        {"grande_boucle"},
        edited(GRADER.solution, "lineariser(x, aretes)", "lineariser(x, aretes[:12])"),
    ),
}


@pytest.mark.parametrize("name", SUBTLE)
def test_subtle_wrongs_are_rejected(name: str) -> None:
    checks, source = SUBTLE[name]
    assert checks <= failed(checked_verdict(source, 8))


def test_right_errors_are_not_blamed_for_a_wrong_optimisation_nor_the_reverse() -> None:
    assert failed(checked_verdict(misconception("omega_ignoree"), 3)).isdisjoint(ERROR_CHECKS | {"chaine", "boucle"})
    own = "\n\nright = erreur\n\n" + edited(GRADER.solution, "e[lignes] = erreur(", "e[lignes] = right(")
    source = GRADER.solution + own[: own.index("def erreur")] + own[own.index("def jacobiennes") :]
    wrong = "\n\ndef erreur(xi, xj, z):\n    return relatif(xi, xj)\n"
    assert failed(checked_verdict(source + wrong, 3)) == ERROR_CHECKS


def test_the_counterexample_of_forgotten_weights_can_be_worked_by_hand() -> None:
    check = next(c for c in checked_verdict(misconception("omega_ignoree"), 3, simplified=True).checks if not c.passed)
    assert check.counterexample is not None
    assert check.counterexample.expected == [[0, 0, 0], [pytest.approx(3), 0, 0], [pytest.approx(6), 0, 0]]
    assert check.counterexample.inputs["poses"] == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    assert "diag(2 ; 2 ; 2)" in check.message


@pytest.mark.parametrize("name", ["une_seule_iteration", "fermetures_ignorees", "erreur_non_ramenee_dans_gn"])
def test_counterexamples_are_small(name: str) -> None:
    check = next(c for c in checked_verdict(misconception(name), 5, simplified=True).checks if not c.passed)
    assert check.counterexample is not None
    assert len(check.counterexample.inputs["poses"]) <= 4


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    for name in ("repere_du_monde", "signe_du_pas"):
        figures = checks_of(misconception(name), 1, simplified=True).figures
        assert figures
        for data in json.loads(json.dumps([*figures.values()][:1])):
            assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


@given(st.integers(3, 8), st.floats(0.02, 3.1), st.sampled_from([-1.0, 1.0]), st.integers(0, 2**32 - 1))
def test_a_map_that_is_only_turned_says_by_how_much(count: int, size: float, way: float, seed: int) -> None:
    expected = np.random.default_rng(seed).uniform(-5.0, 5.0, (count, 2))
    c, s = math.cos(way * size), math.sin(way * size)
    got = expected[0] + (expected - expected[0]) @ np.array([[c, s], [-s, c]])
    assert turn_about_first(expected, got) == pytest.approx(way * size, abs=1e-6)
    got[1] += 2.0
    assert turn_about_first(expected, got) is None
    assert turn_about_first(expected, expected) is None


@given(st.integers(4, 8), st.floats(0.02, 3.1), st.booleans(), st.integers(0, 2**32 - 1))
def test_a_map_put_back_without_its_turn_is_seen(count: int, turn: float, all_turned: bool, seed: int) -> None:
    """Turned about the first pose with headings that stay, or moved as a whole but for the first pose."""
    rng = np.random.default_rng(seed)
    expected = rng.uniform(-3.0, 3.0, (count, 3))
    c, s = math.cos(turn), math.sin(turn)
    got = expected.copy()
    got[1:, :2] = expected[0, :2] + (expected[1:, :2] - expected[0, :2]) @ np.array([[c, s], [-s, c]])
    if all_turned:
        got[1:] += (0.3, -0.2, turn)
    assert is_detached_from_first(expected, got)
    assert not is_detached_from_first(expected, expected)
    got[1:, 2] += 0.1
    assert not is_detached_from_first(expected, got)


FREE = """
def gauss_newton(poses, aretes, n_iter=10):
    x = np.array(poses, dtype=float)
    for _ in range(n_iter):
        x = x - np.linalg.lstsq(jacobienne_et_reste(x, aretes)[0], jacobienne_et_reste(x, aretes)[1], rcond=1e-9)[
            0].reshape(-1, 3)
    x = x + poses[0] - x[0]
    x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x


def jacobienne_et_reste(x, aretes):
    def reste(y):
        y = y.reshape(-1, 3)
        return np.concatenate([np.linalg.cholesky(w).T @ erreur(y[i], y[j], z) for i, j, z, w in aretes])

    steps = 1e-6 * np.eye(x.size)
    return np.column_stack([(reste(x.ravel() + d) - reste(x.ravel() - d)) / 2e-6 for d in steps]), reste(x)
"""


def test_a_free_map_that_is_put_back_by_an_offset_is_named() -> None:
    assert named(verdict(GRADER.solution + FREE, 1)) == "carte_detachee"
