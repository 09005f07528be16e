"""l20/kabsch: any honest method passes, every catalogued mistake is named in several styles, figures draw."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.l20.kabsch import cases
from graders.l20.kabsch.checks import Pairing, Question, simpler_pairings
from graders.l20.kabsch.judge import judge
from graders.plotting import counterexample
from reference.registration import kabsch
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, failed, named, verdict_of

GRADER = CODE["l20/kabsch"]
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
checks_of = partial(checked, GRADER.exercise)

SVD = """
def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    H = (P - p).T @ (Q - q)
    U, S, Vt = np.linalg.svd(H)
    V = Vt.T
    if np.linalg.det(V @ U.T) < 0:
        V[:, -1] *= -1
    R = V @ U.T
    t = q - R @ p
    return R, t
"""
RETURN = "return R, t\n"
PRODUCT = "(P - p).T @ (Q - q)"
SCIPY = "import scipy.linalg\n"
FLIP = "V[:, -1] *= -1"

SEGMENT = """
def kabsch(P, Q):
    u, v = P[1] - P[0], Q[1] - Q[0]
    a = np.arctan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
"""

MEMOISED = f"""
{SVD}

first = []
right = kabsch

def kabsch(P, Q):
    first[:] = first or [right(P, Q)]
    return first[0]
"""


def mistake(name: str) -> Any:
    return next(m for m in GRADER.misconceptions if m.id == name)


@pytest.mark.parametrize("seed", range(12))
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).outcome is Outcome.OK


@pytest.mark.parametrize(
    "path", one_in(8, sorted((GRADER.folder / "specimens/ok").glob("*.py"))), ids=lambda path: path.stem
)
def test_honest_methods_pass(path: Path) -> None:
    """On one seed; on thirty, in `test_variety.py`."""
    found = verdict(path.read_text(encoding="utf-8"), 0)
    assert found.outcome is Outcome.OK, failed(found)


@pytest.mark.parametrize(
    "source",
    [
        SVD,
        SVD.replace(RETURN, "return [R.tolist(), tuple(t)]\n"),
        SVD.replace(RETURN, "return R.tolist(), t.tolist()\n"),
        SVD.replace(RETURN, "out = np.empty(2, dtype=object)\n    out[:] = [R, t]\n    return out\n"),
        SVD.replace(RETURN, "return np.asfortranarray(R), t.astype(complex)\n"),
        SVD.replace(RETURN, "return np.round(R, 12), np.round(t, 12)\n"),
        SVD.replace(PRODUCT, "np.einsum('ni,nj->ij', P - p, Q - q) / len(P)"),
        SVD.replace(PRODUCT, "(P - p).T @ Q"),
        SVD.replace(PRODUCT, "sum(np.outer(a - p, b - q) for a, b in zip(P, Q))"),
        SVD.replace(PRODUCT, "P.T @ Q - len(P) * np.outer(p, q)"),
        SVD.replace("t = q - R @ p", "t = (Q - P @ R.T).mean(axis=0)"),
        SVD.replace("t = q - R @ p", "t = q - p @ R.T"),
        SVD.replace(FLIP, "Vt[-1] *= -1\n        V = Vt.T"),
        SVD.replace(FLIP, "U[:, -1] *= -1"),
        SVD.replace("kabsch(P, Q)", "kabsch(A, B)").replace(
            "    p, q", "    P, Q = np.array(A), np.array(B)\n    p, q"
        ),
        SCIPY + SVD.replace("np.linalg.svd(H)", "scipy.linalg.svd(H, lapack_driver='gesvd')"),
        """
def kabsch(P, Q):
    P, Q = P.copy(), Q.copy()
    p, q = P.mean(0), Q.mean(0)
    P -= p
    Q -= q
    K = Q.T @ P
    U, S, Vt = np.linalg.svd(K)
    D = np.diag([1] * (len(K) - 1) + [round(np.linalg.det(U @ Vt))])
    R = U @ D @ Vt
    return R, q - R.dot(p)
""",
    ],
)
def test_honest_styles_pass(source: str) -> None:
    found = verdict(source, 0)
    assert found.outcome is Outcome.OK, [(c.id, c.message) for c in found.checks if not c.passed]


def test_a_general_minimiser_with_its_usual_tolerances_passes() -> None:
    source = """
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

def kabsch(P, Q):
    d, p, q = P.shape[1], P.mean(0), Q.mean(0)
    def turn(x):
        return Rotation.from_rotvec([0, 0, x[0]] if d == 2 else x).as_matrix()[:d, :d]
    def cost(x):
        return np.sum(((P - p) @ turn(x).T - (Q - q)) ** 2)
    starts = ([0.0], [2.0]) if d == 2 else ([0.1, 0, 0], [-1.5, 1.5, 1])
    R = turn(min((minimize(cost, x) for x in starts), key=lambda o: o.fun).x)
    return R, q - R @ p
"""
    assert verdict(source, 0).outcome is Outcome.OK


@pytest.mark.parametrize(
    ("source", "where"),
    [
        (SVD.replace(RETURN, "return R.astype(np.float32), t\n"), "exact_2d"),
        (SVD.replace(RETURN, "return np.round(R, 4), t\n"), "exact_2d"),
        (SVD.replace(RETURN, "return R, np.round(t, 3)\n"), "translation"),
        (SVD.replace(RETURN, "return R, t[None]\n"), "translation"),
        (SVD.replace(RETURN, "return R, t, S\n"), "exemples"),
        (SVD.replace(RETURN, "return t, R\n"), "exemples"),
        (SVD.replace(RETURN, "return R\n"), "exemples"),
        (SVD.replace(RETURN, "return R, t * np.nan\n"), "translation"),
        (SVD.replace(RETURN, "return R[::-1] if len(P) == 1 else R, t\n"), "degeneres"),
        (SVD.replace(PRODUCT, "(P[:-1] - p).T @ (Q[:-1] - q)"), "bruit"),
        (SVD.replace(PRODUCT, "(P - p).T @ ((Q - q) * (1 + np.arange(len(P)))[:, None])"), "bruit"),
        (SVD.replace("np.linalg.det(V @ U.T)", "np.linalg.det(V)"), "miroir"),
        (SVD.replace("np.linalg.det(V @ U.T) < 0", "len(H) == 2 and np.linalg.det(V @ U.T) < 0"), "miroir_3d"),
        (SVD.replace(FLIP, "V[:, -1] *= np.sign(np.linalg.det(H))"), "degeneres"),
        (SVD.replace("R = V @ U.T", "R = V @ U.T / (np.linalg.norm(H) / np.linalg.norm(H))"), "degeneres"),
        (SVD.replace("    H =", "    if len(P) < 3:\n        return np.eye(len(p)), q - p\n    H ="), "degeneres"),
        (SVD.replace("H = (P - p)", "Q -= 0 * P + 1e-3\n    H = (P - p)"), "arguments"),
        (MEMOISED, "exemples"),
        ("def kabsch(P, Q):\n    return np.eye(len(P[0])), Q.mean(0) - P.mean(0)\n", "exemples"),
    ],
)  # fmt: skip
def test_subtly_wrong_answers_are_rejected(source: str, where: str) -> None:
    found = checked_verdict(source, 0)
    assert found.outcome is Outcome.WRONG_ANSWER
    assert where in failed(found)


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("rotation_transposee", SVD.replace(PRODUCT, "(Q - q).T @ (P - p)")),
        ("rotation_transposee", SVD.replace(FLIP, "Vt[-1] *= -1").replace("R = V @ U.T", "R = U @ Vt")),
        ("rotation_transposee", SVD.replace(FLIP, "pass").replace("R = V @ U.T", "R = U @ Vt")),
        ("sans_centrage", SVD.replace(PRODUCT, "sum(np.outer(a, b) for a, b in zip(P, Q))")),
        ("t_sans_rotation", SVD.replace("q - R @ p", "(Q - P).mean(axis=0)")),
        ("t_sans_rotation", SVD.replace(FLIP, "pass").replace("q - R @ p", "(Q - P).mean(axis=0)")),
        ("t_centre_de_q", SVD.replace("H = ", "P = P - p\n    H = ").replace("R @ p", "R @ P.mean(axis=0)")),
        ("t_rotation_transposee", SVD.replace("q - R @ p", "(Q - P @ R).mean(axis=0)")),
        ("sans_correction", SCIPY + SVD.replace(FLIP, "V = Vt.T")),
        ("correction_ligne_de_r", SVD.replace(FLIP, "Vt[:, -1] *= -1\n        V = Vt.T")),
        ("correction_colonne_de_r", SVD.replace(FLIP, "U[-1, :] *= -1")),
        ("correction_premiere_direction", SVD.replace(FLIP, "U[:, 0] *= -1")),
        ("vt_pour_v", SVD.replace("V = Vt.T", "V = Vt").replace(PRODUCT, "(P - p).T @ (Q - q) / len(P)")),
        ("vt_pour_v", SCIPY + SVD.replace("V = Vt.T", "V = Vt").replace("np.linalg", "scipy.linalg")),
        ("premiers_points", SVD.replace(PRODUCT, "(P - p)[:len(p)].T @ (Q - q)[:len(p)]")),
        ("sommes_pour_moyennes", SVD.replace("P.mean(axis=0), Q.mean(axis=0)", "sum(P), sum(Q)")),
        ("t_premiere_paire", SVD.replace("q - R @ p", "(Q - P @ R.T)[0]")),
        ("t_premiere_paire", SCIPY + SVD.replace("q - R @ p", "Q[0, :] - np.dot(R, P[0, :])")),
        ("t_centres_echanges", SVD.replace("q - R @ p", "(P - Q @ R.T).mean(axis=0)")),
        ("angle_de_deux_points", SEGMENT),
        ("angle_de_deux_points", SEGMENT.replace("P[1]", "P[-1]").replace("Q[1]", "Q[-1]")),
        ("angle_de_deux_points", SEGMENT.replace("Q.mean(axis=0) - R @ P.mean(axis=0)", "Q[0] - R @ P[0]")),
        ("argument_modifie", SVD.replace("return", "P[0] = 0\n    return")),
        ("forme", SVD.replace(RETURN, "return R, t.reshape(-1, 1)\n")),
    ],
)  # fmt: skip
def test_a_mistake_is_recognised_in_another_style(name: str, source: str) -> None:
    assert named(verdict(source, 0)) == name


def test_a_rotation_and_a_translation_are_judged_apart() -> None:
    for wrong, fails in (
        ("t_sans_rotation", {"translation", "degeneres"}),
        ("t_oppose", {"translation", "degeneres"}),
        ("rotation_transposee", {"exemples", "exact_2d", "exact_3d", "bruit", "miroir", "miroir_3d", "degeneres"}),
    ):
        assert failed(checked_verdict(mistake(wrong).source, 3)) == fails


def test_the_first_counterexample_is_that_of_the_course() -> None:
    found = next(
        check
        for check in checked_verdict(mistake("t_sans_rotation").source, 3, simplified=True).checks
        if not check.passed
    )
    assert found.id == "translation"
    assert found.counterexample is not None
    assert found.counterexample.inputs["P"] == [[0, 0], [1, 0], [0, 1]]
    np.testing.assert_allclose(found.counterexample.expected[0], [[0, -1], [1, 0]], atol=1e-12)
    np.testing.assert_allclose(found.counterexample.expected[1], [1, 1], atol=1e-12)
    assert "R est juste" in found.message


def test_a_random_counterexample_is_shrunk() -> None:
    source = SVD.replace("return R, t\n", "return (R, t) if np.all(P == P.round()) or len(P) < 5 else (R, t + 1)\n")
    found = next(check for check in checked_verdict(source, 2, simplified=True).checks if check.id == "translation")
    assert found.counterexample is not None
    assert len(found.counterexample.inputs["P"]) == 5


def test_failed_checks_say_what_was_given_expected_and_obtained() -> None:
    for wrong in some(GRADER.misconceptions):
        for check in checked_verdict(wrong.source, 11, simplified=True).checks:
            if not check.passed and check.id != "arguments":
                assert check.message
                assert check.hint or check.repeats or check.cause is Outcome.RUNTIME_ERROR
                assert check.counterexample is not None
                assert check.counterexample.expected


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    right_shape = checks_of(mistake("t_sans_rotation").source, 1, simplified=True).figures
    wrong_shape = checks_of(mistake("points_en_colonnes").source, 1, simplified=True).figures
    drawn = (right_shape["translation"], wrong_shape["exact_3d"], wrong_shape["degeneres"])
    for data in json.loads(json.dumps(drawn)):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


def test_absurd_answers_are_judged_and_left_out_of_the_figure() -> None:
    source = SVD.replace("return R, t\n", "return R, t + 1e150\n")
    grading = checks_of(source, 1, simplified=True)
    assert failed(grading.verdict) == {"translation", "degeneres"}
    assert all(data["got"] is None for data in grading.figures.values())


@pytest.mark.parametrize("value", [None, 3, "R", {}, [], [1], (None, None), ([], []), ("R", "t"), np.zeros((2, 2)),
                                   ([[1, 2], [3]], [1, 2]), (np.eye(2), [1, np.inf]), ([[10**400] * 2] * 2, [0, 0]),
                                   (np.full((2, 2), 1e200), np.zeros(2)), (np.eye(2) * 1j, np.zeros(2))])  # fmt: skip
def test_any_value_is_judged_without_an_exception(value: Any) -> None:
    pairing = next(iter(cases.examples(np.random.default_rng(0))))
    judgement = judge(pairing.P, pairing.Q, kabsch(pairing.P, pairing.Q), value)
    assert judgement.mismatch is not None
    assert judgement.mismatch.message.endswith((".", "?"))


def test_what_serves_the_diagnosis_is_well_conditioned_and_not_square() -> None:
    for seed in range(5):
        for draw in (cases.examples, cases.exact_2d, cases.exact_3d, cases.noisy, cases.mirrored):
            for pairing in some(draw(np.random.default_rng(seed))):
                assert kabsch(pairing.P, pairing.Q).unique
                assert pairing.P.shape == pairing.Q.shape
                if pairing.observed:
                    assert cases.well_separated(pairing)
                    assert len(pairing.P) > pairing.P.shape[1]


def test_mirrors_do_need_the_correction_and_poor_clouds_are_ambiguous() -> None:
    for seed in range(5):
        for P, Q, _ in some(cases.mirrored(np.random.default_rng(seed))):
            H = (P - P.mean(axis=0)).T @ (Q - Q.mean(axis=0))
            assert np.linalg.det(H) < 0
        uniqueness = [kabsch(P, Q).unique for P, Q, _ in cases.degenerate(np.random.default_rng(seed))]
        assert uniqueness == [False] * 9 + [True] * 13


def test_a_simpler_pairing_keeps_its_points_paired() -> None:
    rng = np.random.default_rng(3)
    pairing = cases.random_pairing(rng, 2, noise=0.3)
    for simpler in simpler_pairings(pairing):
        assert simpler.P.shape == simpler.Q.shape
        assert len(simpler.P) >= len(pairing.P) - 1
    whole = Pairing(np.round(pairing.P), np.round(pairing.Q))
    assert whole.is_whole
    assert not pairing.is_whole
    assert Question.about(whole).best.unique
