"""l20/icp: every honest way passes, what is asked has one answer, mistakes are refused and named, the way is filmed."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.l20.icp import cases, film
from graders.l20.icp.descent import DEFAULT, Registration, descend, fair, staircase
from graders.l20.icp.judge import misjudged, misplaced
from graders.l20.icp.replays import REPLAYS
from graders.plotting import counterexample
from reference.registration import icp
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, judgement_of, named, verdict_of

GRADER = CODE["l20/icp"]
graded = partial(judgement_of, GRADER.exercise)
verdict = partial(verdict_of, GRADER.exercise)
KINDS = {name: kind for name, kind in vars(cases).items() if isinstance(kind, cases.Kind)}

SHORT = """
def fit(P, B):
    p, b = P.mean(0), B.mean(0)
    U, _, Vt = np.linalg.svd((P - p).T @ (B - b))
    R = Vt.T @ np.diag([1, np.sign(np.linalg.det(U @ Vt))]) @ U.T
    return R, b - R @ p

def icp(P, Q, R0, t0, n_iter=30):
    R, t, erreurs = R0, t0, []
    for _ in range(n_iter):
        A = P @ R.T + t
        j = np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)
        erreurs.append(np.sum((A - Q[j]) ** 2))
        R, t = fit(P, Q[j])
    return R, t, erreurs
"""


def edited(*changes: str) -> str:
    """The short program with texts replaced, each found in it."""
    source = SHORT
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in source
        source = source.replace(old, new)
    return source


@pytest.mark.parametrize("name", one_in(3, sorted(KINDS)))
def test_kept_seeds_make_clouds_where_all_honest_programs_agree(name: str) -> None:
    """And the whole way is that of `reference.registration.icp`, which knows nothing of the grader."""
    kind = KINDS[name]
    assert len(kind.seeds) > 2
    for seed in some(kind.seeds):
        assert kind.telling(seed)
        case = kind.made(seed)
        step = descend(*case[:4], case.iterations)[-1]
        start = [*case.t0, np.arctan2(case.R0[1, 0], case.R0[0, 0])]
        found = icp(case.P, case.Q, start, max_iterations=case.iterations)
        np.testing.assert_allclose(found.R_q_p, step.R, atol=1e-9)
        np.testing.assert_allclose(found.t_q_p, step.t, atol=1e-9)
        stairs = staircase(descend(*case[:4], case.iterations + 1))
        assert all(np.min(np.abs(stairs - error)) < 1e-6 for error in found.errors[:-1])


DRAWS = (cases.one_iteration, cases.few_iterations, cases.to_the_end, cases.from_a_start, cases.of_unequal_sizes,
         cases.mirrored, cases.without_count)  # fmt: skip


@pytest.mark.parametrize(
    "source",
    [
        pytest.param(edited("np.sign(np.linalg.det(U @ Vt))", "1"), id="no correction"),
        pytest.param(
            edited(
                "j = np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)",
                "j = __import__('scipy.optimize').optimize.linear_sum_assignment("
                "np.sum((A[:, None] - Q) ** 2, axis=2))[1]",
            ),
            id="a partner each",
        ),
    ],
)
def test_what_a_mistake_is_worth_does_not_depend_on_the_draw(source: str) -> None:
    """Some reflections and some shared partners do not show on all clouds: the first of a kind is one that does."""
    names: dict[str, Any] = {"np": np}
    exec(source, names)

    def wrong(case: Registration) -> bool:
        try:
            return misplaced(case, names["icp"](*case.arguments)) is not None
        except (ValueError, IndexError):
            return True

    for draw in DRAWS:
        found = {any(wrong(case) for case in draw(np.random.default_rng(seed))) for seed in range(3)}
        assert len(found) == 1, draw.__name__


def test_ties_and_slow_ends_are_not_fair() -> None:
    P = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 3.0]])
    tied = Registration(P, P + np.array([1.0, 0.0]), np.eye(2), np.zeros(2))
    assert not fair(tied)
    assert fair(cases.example(DEFAULT))
    assert not fair(Registration(*film.scans(), np.eye(2), np.zeros(2))), "scans end little by little"


def test_scans_are_watched_while_each_iteration_tells() -> None:
    steps = film.path()
    assert len(steps) > film.WATCHED
    assert all(step.sure for step in steps[: film.WATCHED])
    assert all(step.after < 0.99 * step.before for step in steps[: film.WATCHED - 1])


def test_the_solution_gets_full_marks() -> None:
    assert verdict(GRADER.solution, 1).outcome is Outcome.OK


@pytest.mark.parametrize("path", some(sorted((GRADER.folder / "specimens/ok").glob("*.py")))[::6], ids=lambda p: p.stem)
def test_honest_styles_pass(path: Path) -> None:
    found = verdict(path.read_text(encoding="utf-8"), 5)
    assert found.outcome is Outcome.OK, failed(found)


@pytest.mark.parametrize(
    ("source", "where"), one_in(3, [
        (edited("(A - Q[j]) ** 2)", "(A - Q[j]) ** 2) / 2"), "erreurs"),
        (edited("return R, t, erreurs", "return R, t, erreurs + [erreurs[-1] + 1]"), "erreurs"),
        (edited("return R, t, erreurs", "return R, t, erreurs + [-1.0]"), "erreurs"),
        (edited("return R, t, erreurs", "return R, t, [0.0]"), "erreurs"),
        (edited("return R, t, erreurs", "return R, t, []"), "erreurs"),
        (edited("return R, t, erreurs", "return R, t, erreurs + [0.0] * 40"), "erreurs"),
        (edited("return R, t, erreurs", "return np.round(R, 3), t, erreurs"), "une_iteration"),
        (edited("return R, t, erreurs", "return R, t[None], erreurs"), "une_iteration"),
        (edited("return R, t, erreurs", "return R, t"), "une_iteration"),
        (edited("n_iter=30", "n_iter=12"), "defaut"),
        (edited("R, t, erreurs = R0, t0, []", "R, t, erreurs = np.round(R0), t0, []"), "depart"),
        (edited("np.sign(np.linalg.det(U @ Vt))", "1"), "miroir"),
        (edited("fit(P, Q[j])", "fit(P[:5], Q[j[:5]])"), "jusqu_au_bout"),
        (edited("R, t = fit(P, Q[j])", "P -= 0.0\\n        t0 += 1\\n        R, t = fit(P, Q[j])").replace("\\n", "\n"),
         "arguments"),
    ]),
)  # fmt: skip
def test_subtly_wrong_answers_are_rejected(source: str, where: str) -> None:
    assert where in failed(checked(GRADER.exercise, source, 0).verdict)


MISTAKES = [
    ("depart_ignore", edited("= R0, t0, []", "= np.eye(2), np.zeros(2), []")),
    ("sans_correction", edited("np.sign(np.linalg.det(U @ Vt))", "1")),
    ("increment_non_cumule", edited("fit(P, Q[j])", "fit(A, Q[j])")),
    ("erreurs_moyennes", edited("np.sum((A - Q[j]) ** 2)", "np.mean(np.sum((A - Q[j]) ** 2, axis=1))")),
    ("depart_transpose", edited("P @ R.T + t", "P @ R + t")),
    ("paires_par_indice", edited("j = np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)",
                                     "j = np.arange(len(P)) % len(Q)")),
    ("une_iteration", edited("for _ in range(n_iter):", "for _ in range(1):")),
    ("iterations_mal_comptees", edited("range(n_iter)", "range(n_iter + 1)")),
    ("sans_centrage", edited("(P - p).T @ (B - b)", "P.T @ B")),
    ("erreurs_racines", edited("np.sum((A - Q[j]) ** 2)", "np.linalg.norm(A - Q[j])")),
    ("erreur_seule", edited("return R, t, erreurs", "return R, t, erreurs[-1]")),
    ("mouvement_inverse", edited("return R, t, erreurs", "return R.T, -R.T @ t, erreurs")),
    ("defaut_faux", edited("n_iter=30", "n_iter")),
]  # fmt: skip


@pytest.mark.parametrize(("name", "source"), one_in(5, MISTAKES))
def test_a_mistake_is_recognised_in_another_style(name: str, source: str) -> None:
    assert named(verdict(source, 2)) == name


def test_the_first_counterexample_is_that_of_the_statement_or_simpler() -> None:
    source = edited("fit(P, Q[j])", "fit(A, Q[j])")
    found = checked(GRADER.exercise, source, 3, simplified=True).verdict.checks[1]
    assert found.counterexample is not None
    assert found.counterexample.inputs["n_iter"] == 2
    assert len(found.counterexample.inputs["P"]) <= 4
    one = checked(GRADER.exercise, edited("range(n_iter)", "range(1)"), 3).verdict.checks[1]
    assert "une seule itération" in one.message


def test_a_rotation_that_is_right_but_for_rounding_is_not_held_against_a_program() -> None:
    source = edited("return R, t, erreurs", "return R @ fit(P, P)[0], t + 1.0, erreurs")
    found = checked(GRADER.exercise, source, 3, simplified=True).verdict.checks[1]
    assert "R est juste, mais t vaut" in found.message
    turned = edited("return R, t, erreurs", "return fit(P, P)[0], t, erreurs")
    found = checked(GRADER.exercise, turned, 3, simplified=True).verdict.checks[1]
    assert "t est juste, mais R tourne de" in found.message


def test_errors_are_right_at_any_moment_of_an_iteration() -> None:
    case = cases.example(2)
    stairs = staircase(descend(*case[:4], 3))
    np.testing.assert_allclose(stairs[:3], [13.0, 5.797, 5.403], atol=1e-3)
    for errors in ([13.0], stairs[[0, 2]], stairs[[1, 3]], stairs[[2, 4]], stairs[[0, 2, 4]], stairs[[0, 1, 3]]):
        wrong = misjudged(case, (np.eye(2), np.zeros(2), errors))
        assert (wrong is None) == (errors[-1] < 13.0)


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    right = checked(GRADER.exercise, edited("R, t = fit(P, Q[j])", "R, t = fit(P, Q[j])[0], t"), 1).figures
    none = checked(GRADER.exercise, edited("return R, t, erreurs", "return R, t * 1e99, erreurs"), 1).figures
    for data in json.loads(json.dumps((right["tailles"], none["depart"]))):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


def test_the_iterations_are_filmed_beside_the_way_that_is_expected() -> None:
    right = json.loads(json.dumps(graded(SHORT, 1).films["scans"]))
    assert right["wrong"] is None
    assert len(json.dumps(right)) < 60_000
    body = REPLAYS[right["kind"]](right).wire()
    mine, wanted = (curve["y"] for curve in body["charts"][0]["series"])
    assert len(mine) == film.WATCHED + 1
    np.testing.assert_allclose(mine, wanted, rtol=1e-2)
    away = checked(GRADER.exercise, edited("fit(P, Q[j])", "fit(A, Q[j])"), 1)
    wrong = json.loads(json.dumps(away.films["scans"]))
    assert wrong["wrong"] == 2
    body = REPLAYS[wrong["kind"]](wrong).wire()
    assert "quitte le chemin" in body["frames"][2]["caption"]
    assert body["charts"][0]["marks"][0]["x"] == 2


def test_a_film_that_stops_is_told() -> None:
    source = edited("return R, t, erreurs", "return (R, t, erreurs) if len(P) < 20 or n_iter < 3 else None")
    data = json.loads(json.dumps(checked(GRADER.exercise, source, 1).films["scans"]))
    assert data["wrong"] == 3
    assert "le film s’arrête là" in " ".join(REPLAYS["iterations"](data).wire()["summary"])


@pytest.mark.parametrize("value", [None, 3, "R", {}, [], [1], (None, None, None), (np.eye(2), np.zeros(2)),
                                   (np.zeros(2), np.eye(2), []), (np.eye(3), np.zeros(2), []), np.zeros((3, 2)),
                                   (np.full((2, 2), np.nan), np.zeros(2), [0.0]), (np.diag([1, -1]), [0, 0], [0]),
                                   (np.full((2, 2), 1e200), [0, 0], [0]), (np.eye(2) * 1j, [0, 0], [0])])  # fmt: skip
def test_any_value_is_judged_without_an_exception(value: Any) -> None:
    for judge in (misplaced, misjudged):
        wrong = judge(cases.example(2), value)
        assert wrong is None or wrong.message.endswith((".", "?", ")"))
    assert misplaced(cases.example(2), value) is not None
