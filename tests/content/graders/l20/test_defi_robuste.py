"""l20/defi_robuste: null spaces against singular values, graphs on which every robust program passes, names, films."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats
from graders.l20.defi_robuste import graphs, kernel, robust
from graders.l20.defi_robuste.replays import REPLAYS
from graders.plotting import counterexample
from reference.pose_graph import NormalEquations, PoseGraph, gauge_dimension, graduated_non_convexity
from tests.support.quick import THEMES, only, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, judgement_of, named, verdict_of

GRADER = CODE["l20/defi_robuste"]
graded = partial(judgement_of, GRADER.exercise)
verdict = partial(verdict_of, GRADER.exercise)

SPECIMENS = {one.path.stem: one.path.read_text(encoding="utf-8") for one in GRADER.specimens()}
HONEST = sorted(one.path.stem for one in GRADER.specimens() if one.outcome is Outcome.OK)
FEW = ("vectorise_geman_mcclure",)
ALL_GRAPHS = [(false, seed) for false, seeds in graphs.SEEDS.items() for seed in seeds]


def null_space(poses: Floats, edges: list[graphs.Edge]) -> int:
    """By the singular values of H, one pose of each piece named as fixed so that the graph can be made."""
    pieces: list[set[int]] = [{k} for k in range(len(poses))]
    for i, j, _, _ in edges:
        joined = [piece for piece in pieces if i in piece or j in piece]
        pieces = [piece for piece in pieces if piece not in joined] + [set().union(*joined)]
    model = PoseGraph.from_edges(len(poses), edges, fixed=tuple(min(piece) for piece in pieces))
    upper = NormalEquations(model, free_gauge=True).upper_triangle(poses.ravel()).toarray()
    singular = np.linalg.svd(upper + np.triu(upper, 1).T, compute_uv=False)
    return int(np.sum(singular < 1e-10 * singular[0]))


@pytest.mark.parametrize("cases", [kernel.examples, kernel.drawn])
def test_the_null_space_has_three_dimensions_a_piece(cases: Callable[..., object]) -> None:
    sizes = set()
    for poses, edges in some(cases(np.random.default_rng(4))):  # type: ignore[call-overload]
        assert kernel.expected(poses, edges) == null_space(poses, edges)
        sizes.add(kernel.expected(poses, edges))
    assert sizes == {3, 6, 9}


def test_what_never_changes_catches_edges_followed_one_way() -> None:
    for poses, edges in itertools.islice(kernel.drawn(np.random.default_rng(0)), 3):
        left, pieces = set(range(len(poses))), 0
        while left:
            pieces, reached = pieces + 1, {min(left)}
            while more := {j for i, j, _, _ in edges if i in reached} - reached:
                reached |= more
            left -= reached
        assert 3 * pieces != kernel.expected(poses, edges)


def test_a_pose_alone_is_a_piece() -> None:
    assert gauge_dimension(3, [(0, 2)]) == 6
    assert gauge_dimension(1, []) == 3


KERNELS = {
    "huber": lambda x: np.minimum(1.0, 2.0 / np.maximum(x, 1e-12)),
    "cauchy": lambda x: 1.0 / (1.0 + x**2 / 4.0),
    "geman-mcclure": lambda x: 1.0 / (1.0 + x**2 / 4.0) ** 2,
    "welsch": lambda x: np.exp(-(x**2) / 8.0),
    "tukey": lambda x: np.where(x < 2.0, (1.0 - x**2 / 4.0) ** 2, 0.0),
    "tukey, usual": lambda x: np.where(x < 4.685, (1.0 - (x / 4.685) ** 2) ** 2, 0.0),
    "dcs": lambda x: np.minimum(1.0, 8.0 / (4.0 + x**2)) ** 2,
    "dcs, phi = delta": lambda x: np.minimum(1.0, 4.0 / (2.0 + x**2)) ** 2,
    "rejection": lambda x: np.where(x <= 2.0, 1.0, 0.0),
}
WRONG = {
    "plain": np.ones_like,
    "the other way": lambda x: np.minimum(1.0, x / 2.0),
    "too mild": lambda x: np.sqrt(np.minimum(1.0, 2.0 / np.maximum(x, 1e-12))),
}


def reweighted(one: graphs.Robust, weigh: Callable[[Floats], Floats], *, chords: bool) -> tuple[Floats, Floats]:
    """Thirty steps of Gauss-Newton, the weights renewed at each."""
    sure = ~one.model.is_closure_mask if chords else np.zeros(len(one.edges), dtype=bool)
    equations = NormalEquations(one.model)
    state = one.poses.ravel()
    for _ in range(one.n_iter):
        system = equations.assemble(state, lambda u: np.where(sure, 1.0, weigh(np.sqrt(u))))
        upper = equations.pattern.upper_triangle(system.upper_entries).toarray()
        H = upper + np.triu(upper, 1).T
        state = equations.apply_step(state, -np.linalg.lstsq(H, system.b, rcond=None)[0])
    poses = state.reshape(-1, 3)
    return poses, np.where(sure, 1.0, weigh(one.whitened(poses)))


def fine(one: graphs.Robust, answer: tuple[Floats, Floats]) -> bool:
    return robust.judge(one, answer) is None


@pytest.mark.parametrize(
    ("false", "seed"),
    only([ALL_GRAPHS[-1]], ALL_GRAPHS),
)
def test_every_kernel_passes_and_no_mistake_does(false: int, seed: int) -> None:
    one = graphs.robust_graph(seed, false)
    assert (len(one.poses), int(one.model.is_closure_mask.sum()), int(one.false.sum())) == (24, 12 + false, false)
    assert one.ratio(one.without_false) < 0.25
    assert one.ratio(one.poses) > 0.3
    for chords in (False, True):
        assert [name for name, weigh in KERNELS.items() if not fine(one, reweighted(one, weigh, chords=chords))] == []
        assert [name for name, weigh in WRONG.items() if fine(one, reweighted(one, weigh, chords=chords))] == []
    found = graduated_non_convexity(one.model, one.poses)
    assert fine(one, (found.poses, found.weights))
    everything = np.ones(len(one.edges))
    assert not fine(one, (one.without_false, everything))
    assert not fine(one, (one.plain, np.where(one.false, 0.0, 1.0)))
    assert not fine(one, (one.poses, np.where(one.model.is_closure_mask, 0.0, 1.0)))


def test_what_comes_back_in_other_forms_is_read_and_nonsense_is_refused() -> None:
    one = graphs.robust_graph(0, 1)
    right = np.where(one.false, 0.0, 1.0)
    for got in ((one.without_false.tolist(), right[:, None]), [one.without_false, right > 0.5]):
        assert robust.judge(one, got) is None
    huge = np.full_like(one.poses, 1e300)
    bad = (None, 3, (one.poses,), (one.without_false, right[:-1]), (one.without_false, right * 1.2), (huge, right))
    for wrong in (*bad, (one.without_false * np.nan, right), (one.without_false, 1.0 - right), ("a", "b")):
        assert robust.judge(one, wrong) is not None


@pytest.mark.parametrize("name", only(FEW, HONEST))
def test_honest_styles_pass(name: str) -> None:
    assert failed(verdict(SPECIMENS[name], 4)) == set()


def edited(old: str, new: str) -> str:
    assert old in GRADER.solution
    return GRADER.solution.replace(old, new)


WEIGHED, PLAIN = "systeme(x, aretes, ponderer(x, aretes, delta))", "systeme(x, aretes, [1] * len(aretes))"
STYLES = {
    "rank": ("rang", "np.sum(valeurs < 1e-8", "np.sum(valeurs >= 1e-8"),
    "metres": ("erreur_non_blanchie", "e @ omega @ e", "e @ e"),
    "told last": ("moindres_carres_ordinaires", WEIGHED, PLAIN),
    "upside down": ("poids_inverses", "delta / np.maximum(normes, delta)", "np.array(normes) / delta"),
    "no gauge": ("jauge_libre", "pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])", "pas = np.linalg.solve(H, -b)"),
    "suspicion": ("sens_des_poids", "return x, ponderer(x, aretes, delta)", "return x, 1 - ponderer(x, aretes, delta)"),
    "odometry first": ("poids_dans_le_desordre", "return x, ponderer(x, aretes, delta)",
                       "return x, ponderer(x, sorted(aretes, key=lambda a: abs(a[0] - a[1]) != 1), 0.7 * delta)"),
    "start": ("rien_ne_bouge", "x += pas.reshape(x.shape)", "pass"),
}  # fmt: skip
NAMED = ("rank", "told last", "odometry first")


@pytest.mark.parametrize("style", only(NAMED, STYLES))
def test_a_mistake_is_named_in_another_program_than_the_model(style: str) -> None:
    name, old, new = STYLES[style]
    assert named(verdict(edited(old, new), 6)) == name


def test_the_solution_gets_full_marks_and_the_film_shows_the_reference_and_where_a_map_stays_bent() -> None:
    best = graded(GRADER.solution, 1)
    assert best.verdict.outcome is Outcome.OK
    right = REPLAYS["robuste"](json.loads(json.dumps(best.films["une_fausse"])))
    assert not right.charts[0].marks
    judgement = checked(GRADER.exercise, edited(WEIGHED, PLAIN), 1)
    wrong = REPLAYS["robuste"](json.loads(json.dumps(judgement.films["une_fausse"])))
    assert wrong.charts[0].marks
    assert any("Ici" in frame.caption for frame in wrong.frames)
    assert wrong.wire()["summary"]
    assert "0,4" in next(check for check in judgement.verdict.checks if not check.passed).message


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    one = graphs.robust_graph(0, 1)
    cases = next(iter(kernel.examples(np.random.default_rng(0))))
    for data in (
        robust.robust_figure(one, (one.plain, np.ones(len(one.edges)))),
        robust.robust_figure(one, None),
        kernel.pieces_figure(cases, 3, np.array(1.0)),
    ):
        assert counterexample(GRADER.exercise, json.loads(json.dumps(data)), theme=theme).startswith(b"<?xml")
