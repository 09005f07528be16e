"""l20/predire2d: honest styles pass on every seed, mistakes are rejected and named, closed loops are fair."""

import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

from graders.core.contract.local import LocalProgram
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PlannedCalls, Program, StudentFault
from graders.l20.predire2d import cases, trials
from graders.l20.predire2d.beliefs import SameBelief, SameLikeliest, in_words, instead, one_hot
from graders.l20.predire2d.checks import tells_something
from graders.plotting import counterexample
from reference.localisation.grid_filter import most_likely_cell
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, verdict_of

GRADER = CODE["l20/predire2d"]
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
checks_of = partial(checked, GRADER.exercise)

SEEDS = range(5)


def mistake(name: str) -> str:
    return next(m.source for m in GRADER.misconceptions if m.id == name)


def checks(found: Any) -> dict[str, Any]:
    return {check.id: check for check in found.checks}


def specimen(path: str) -> str:
    source = (GRADER.folder / "specimens" / path).read_text(encoding="utf-8")
    return source.replace("from l20 import lidar as sonder", "sonder = lidar")


@pytest.mark.parametrize("seed", SEEDS)
def test_the_solution_gets_full_marks(seed: int) -> None:
    assert verdict(GRADER.solution, seed).score == 1.0


@pytest.mark.parametrize(
    "path", one_in(8, sorted((GRADER.folder / "specimens/ok").glob("*.py"))), ids=lambda path: path.stem
)
def test_honest_styles_pass(path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """On one seed; on thirty, in `test_variety.py`."""
    assert verdict(specimen(f"ok/{path.name}"), 0).score == 1.0


HONEST = {
    "retour en float imbriqué": "_p = predire2d\ndef predire2d(a, b, c):\n    return _p(a, b, c).tolist()",
    "sigma numpy par défaut": "_c = corriger2d\ndef corriger2d(b, s, t=np.float64(0.5)):\n    return _c(b, s, t)",
    "renormalise aussi la prédiction": "_p = predire2d\ndef predire2d(*a):\n    n = _p(*a)\n    return n / n.sum()",
    "nom d'arguments variables": "_c = corriger2d\ndef corriger2d(*args, **k):\n    return _c(*args, **k)",
    "poussière d'arrondi": "_p = predire2d\ndef predire2d(*a):\n    return _p(*a) + 1e-13 * libres",
    "vraisemblance avec plancher minuscule": (
        "def corriger2d(bel, z, s=0.5):\n"
        "    v = np.zeros((H, W))\n"
        "    v[Y, X] = np.exp(-np.sum((z - ATTENDUS) ** 2, axis=1) / (2 * s * s)) + 1e-15\n"
        "    return bel * v / np.sum(bel * v)"
    ),
    "écarts en place sur une copie": (
        "def corriger2d(bel, z, s=0.5):\n"
        "    b = bel.copy()\n"
        "    for k in range(4):\n"
        "        b[Y, X] *= np.exp(-(z[k] - ATTENDUS[:, k]) ** 2 / (2 * s ** 2))\n"
        "        b /= b.sum()\n"
        "    return b"
    ),
}


@pytest.mark.parametrize("change", HONEST.values(), ids=HONEST.keys())
def test_honest_changes_pass(change: str) -> None:
    for seed in range(2):
        assert verdict(f"{GRADER.solution}\n\n{change}\n", seed).score == 1.0


WRONG = {
    "probabilités 0,7 et 0,15": "def arrivees(u, v):\n    return [(1.0, 0, 0)] if (u, v) == (0, 0) else "
    "[(0.7, u, v), (0.15, u + v, u + v), (0.15, u - v, v - u)]",
    "vers le bas comme vers le haut": "_p = predire2d\ndef predire2d(b, u, v):\n    return _p(b, u, abs(v))",
    "un millionième de fuite": "_p = predire2d\ndef predire2d(*a):\n    return _p(*a) * (1 - 1e-6)",
    "une case qui ne compte pas": "_p = predire2d\ndef predire2d(*a):\n    n = _p(*a)\n"
    "    n[Y[-1], X[-1]] = 0\n    return n",
    "entiers": "_p = predire2d\ndef predire2d(*a):\n    return np.rint(1000 * _p(*a)) / 1000",
    "croyance simplifiée": "_p = predire2d\ndef predire2d(b, u, v):\n    d = np.zeros((H, W))\n"
    "    d.flat[np.argmax(b)] = 1\n    return _p(d, u, v)",
    "sigma ignoré": "_c = corriger2d\ndef corriger2d(b, z, sigma=0.5):\n    return _c(b, z, 0.5)",
    "trois rayons": "_c = corriger2d\ndef corriger2d(b, z, s=0.5):\n    z = np.r_[z[:3], np.nan]\n"
    "    n = np.zeros((H, W))\n    n[Y, X] = b[Y, X] * np.exp(-np.nansum((z - ATTENDUS) ** 2, axis=1) / (2 * s**2))\n"
    "    return n / n.sum()",
    "argmax seulement": "_c = corriger2d\ndef corriger2d(*a):\n    n = _c(*a)\n    return 1.0 * (n == n.max())",
    "le premier appel vaut pour tous": "from functools import lru_cache\nMEMO = {}\n_p = predire2d\n"
    "def predire2d(b, u, v):\n    return MEMO.setdefault((u, v), _p(b, u, v))",
    "rayons dans l'autre sens": "ATTENDUS = ATTENDUS[:, [0, 3, 2, 1]]",
    "lidar tourné d'un quart": "ATTENDUS = np.roll(ATTENDUS, 1, axis=1)",
    "log-vraisemblance": "_c = corriger2d\ndef corriger2d(*a):\n    return np.log(_c(*a) + 1e-300)",
    "transposée": "_c = corriger2d\ndef corriger2d(*a):\n    return _c(*a).T",
    "aplatie": "_c = corriger2d\ndef corriger2d(*a):\n    return _c(*a).ravel()",
}


@pytest.mark.parametrize("change", WRONG.values(), ids=WRONG.keys())
def test_subtly_wrong_programs_are_rejected(change: str) -> None:
    assert checked_verdict(f"{GRADER.solution}\n\n{change}\n", 1).score < 1.0


def test_functions_that_do_nothing_earn_nothing() -> None:
    nothing = (
        "def predire2d(bel, du, dv):\n    return bel\n\ndef corriger2d(bel, scan_obs, sigma=0.5):\n    return bel\n"
    )
    assert [checked_verdict(nothing, seed).score for seed in range(2)] == [0.0] * 2


def test_the_other_function_keeps_its_points() -> None:
    found = checks(checked_verdict(mistake("sens_inverse"), 2))
    assert all(found[name].passed for name in ("corriger_exemples", "corriger_autre_carte", "sigma_par_defaut"))
    assert not any(found[name].passed for name in ("predire_exemples", "predire_murs", "predire_autre_carte"))


def test_a_file_that_fails_on_another_map_says_so() -> None:
    class Programs:
        def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
            if kit.parameters["libres"] is not None:
                raise StudentFault(Outcome.RUNTIME_ERROR, "IndexError", frames=("ligne 3",), exception="IndexError")
            return LocalProgram(source, kit)

    graded = GRADER.grade(GRADER.solution.encode(), Programs(), seed=1, version="v").verdict
    found = checks(graded)
    assert graded.outcome is Outcome.RUNTIME_ERROR
    assert found["predire_exemples"].passed
    assert not found["predire_autre_carte"].passed
    assert "autre carte" in found["predire_autre_carte"].message
    assert "ligne 3" in found["predire_autre_carte"].message
    assert found["predire_autre_carte"].counterexample is not None


def test_arguments_must_be_left_alone() -> None:
    found = verdict(specimen("wrong_answer/modifie_sur_place.py"), 3)
    assert [check.id for check in found.checks if not check.passed] == ["arguments"]
    assert found.diagnosis.id == "argument_modifie"


def test_the_counterexample_of_a_wrong_move_is_one_cell() -> None:
    for name in ("axes_echanges", "sens_inverse", "glissement_oublie"):
        check = checks(checked_verdict(mistake(name), 3, simplified=True))["predire_exemples"]
        assert len(check.counterexample.inputs["bel, cases (y, x) non nulles"]) == 1
        assert len(check.counterexample.expected) == 3


def test_the_counterexample_of_a_lost_mass_is_one_wall() -> None:
    check = checks(checked_verdict(mistake("masse_perdue"), 3, simplified=True))["predire_murs"]
    assert check.counterexample.inputs["bel, cases (y, x) non nulles"] == {"(3, 6)": 1.0}
    assert "au lieu de 1" in check.message


def test_a_counterexample_of_another_map_can_be_typed_in_again() -> None:
    check = checks(checked_verdict(mistake("tour_du_bord"), 3, simplified=True))["predire_autre_carte"]
    inputs = check.counterexample.inputs
    assert set(inputs) == {"libres", "bel", "du", "dv"}
    assert np.count_nonzero(inputs["bel"]) == 1
    assert np.shape(inputs["libres"]) == np.shape(inputs["bel"]) == np.shape(check.counterexample.got)


def test_the_counterexample_of_a_wrong_likelihood_is_a_doubt_between_two_cells() -> None:
    check = checks(checked_verdict(mistake("facteur_deux_oublie"), 3, simplified=True))["corriger_exemples"]
    assert check.counterexample.inputs["bel, cases (y, x) non nulles"] == {"(1, 1)": 0.5, "(1, 2)": 0.5}
    assert check.counterexample.expected == pytest.approx({"(1, 1)": 0.98201379, "(1, 2)": 0.01798621})


def test_every_walk_is_followed_with_a_margin_and_not_by_standing_still() -> None:
    grid = cases.module_world()
    for seed in range(6):
        for episode in some(trials.episodes(seed)):
            assert trials.gap(most_likely_cell(episode.belief), episode.end) <= 1
            assert len(episode.cells) == len(episode.commands) == trials.STEPS
            assert all(grid.free[cell] for cell in (episode.start, *episode.cells))


@pytest.mark.parametrize("draw", [cases.doubts, cases.noisy_scans])
def test_scans_are_likely_enough_for_every_honest_formula(draw: Callable[..., Any]) -> None:
    rng = np.random.default_rng(8)
    for _ in range(10):
        grid = cases.open_world(rng) if draw is cases.noisy_scans else cases.module_world()
        for belief, scan, sigma in some(draw(rng, grid)):
            likelihood = np.exp(-np.sum((scan - grid.scans) ** 2, axis=2) / (2 * sigma**2))
            assert np.sum(belief * likelihood) > 2e-3
            assert not belief[~grid.free].any()
            assert belief.sum() == pytest.approx(1.0)


def test_beliefs_given_are_beliefs() -> None:
    rng = np.random.default_rng(9)
    for draw, grid in (
        (cases.open_moves, cases.module_world()),
        (cases.moves_near_walls, cases.module_world()),
        (cases.moves_at_the_edge, cases.open_world(rng)),
    ):
        for belief, _, _ in some(draw(rng, grid)):
            assert not belief[~grid.free].any()
            assert belief.sum() == pytest.approx(1.0)


def test_a_doubt_that_a_scan_settles_shows_nothing() -> None:
    grid = cases.module_world()
    near, far = one_hot(grid.free.shape, (1, 1), (1, 2)), one_hot(grid.free.shape, (1, 1), (8, 12))
    assert tells_something(grid, (near, grid.scans[1, 1], 0.5))
    assert not tells_something(grid, (far, grid.scans[1, 1], 0.5))


def test_opposed_cells_differ_by_two_opposite_beams_which_read_the_same_numbers() -> None:
    scans = cases.module_world().scans
    told = []
    for one, other in cases.OPPOSED:
        beams = np.flatnonzero(scans[one] != scans[other])
        assert np.array_equal(scans[one][beams], scans[other][beams][::-1])
        told.append(beams.tolist())
    assert told == [[0, 2], [1, 3]]
    for cell in cases.ALIKE:
        assert np.array_equal(scans[cell], scans[cases.ALIKE[0]])


def test_two_cells_as_likely_are_no_maximum_even_by_rounding() -> None:
    likeliest, wanted = SameLikeliest(np.ones((1, 3), dtype=bool)), np.array([[0.7, 0.3, 0.0]])
    assert likeliest(wanted, [[0.51, 0.49, 0.0]]) is None
    assert likeliest(wanted, [[0.5 + 1e-12, 0.5 - 1e-12, 0.0]]) is not None


def test_other_maps_have_free_cells_that_meet_at_a_corner_between_two_walls() -> None:
    for seed in range(20):
        free = cases.open_world(np.random.default_rng(seed)).free
        for one in (free, free[:, ::-1]):
            corners = one[:-1, :-1] & one[1:, 1:]
            assert np.any(corners & ~(one[:-1, 1:] | one[1:, :-1]))


def test_the_comparator_names_what_is_not_a_belief() -> None:
    free = np.array([[True, True, False]])
    same, wanted = SameBelief(free), np.array([[0.5, 0.5, 0.0]])
    assert same(wanted, [[0.5, 0.5 + 5e-10, 0.0]]) is None
    for got, words in (
        ([[1.0, 1.0, 0.0]], "somme"),
        ([[0.5, 0.4, 0.1]], "mur (0, 2)"),
        ([[0.6, 0.4, 0.0]], "(0, 0)"),
        ([[0.5, float("nan"), 0.0]], "nan"),
        ([0.5, 0.5, 0.0], "forme"),
        (None, "return"),
    ):
        found = same(wanted, got)
        assert found is not None
        assert words in found.message
    assert in_words(wanted) == "0,5 en (0, 0) et 0,5 en (0, 1)"


def test_two_values_that_differ_are_told_with_digits_that_differ() -> None:
    assert instead(0.25, 1.0) == "0,25 au lieu de 1"
    assert instead(1.0, 1.0 - 4e-8) == "1 au lieu de 0,99999996"
    wanted = np.array([[1.0 - 1e-8, 5e-9, 5e-9]])
    found = SameBelief(np.ones((1, 3), dtype=bool))(wanted, [[1.0 - 4e-8, 2e-8, 2e-8]])
    assert found is not None
    assert found.message.endswith("0,99999996 au lieu de 0,99999999.")


NAMED = {
    "indice_negatif": (
        "def predire2d(bel, du, dv):\n    n = np.zeros((H, W))\n    for y in range(H):\n        for x in range(W):\n"
        "            for p, a, b in arrivees(du, dv):\n                j, i = y + b, x + a\n"
        "                if j >= H or i >= W or not libres[j, i]:\n                    j, i = y, x\n"
        "                n[j, i] += p * bel[y, x]\n    return n"
    ),
    "roll_et_renormalise": (
        "def predire2d(bel, du, dv):\n    if du == dv == 0:\n        return bel.copy()\n"
        "    r = lambda a, b: np.roll(np.roll(bel, a, axis=1), b, axis=0)\n"
        "    n = 0.8 * r(du, dv) + 0.1 * r(du + dv, dv + du) + 0.1 * r(du - dv, dv - du)\n"
        "    n = np.where(libres, n, 0)\n    return n / n.sum()"
    ),
    "depart_compte_deux_fois": "_p = predire2d\ndef predire2d(b, u, v):\n    return b + _p(b, u, v)",
    "sigma_ignore": "_c = corriger2d\ndef corriger2d(bel, scan, sigma=0.5):\n    return _c(bel, scan)",
    "tour_du_bord": (
        "def predire2d(bel, du, dv):\n    n = np.zeros((H, W))\n    for p, a, b in arrivees(du, dv):\n"
        "        va = np.roll(libres, (-b, -a), axis=(0, 1))\n"
        "        n += p * (bel * ~va + np.roll(bel * va, (b, a), axis=(0, 1)))\n    return n"
    ),
    "masse_renormalisee": (
        "def predire2d(bel, du, dv):\n    n = np.zeros((H, W))\n    for y, x in zip(Y, X):\n"
        "        for p, a, b in arrivees(du, dv):\n            j, i = y + b, x + a\n"
        "            if 0 <= j < H and 0 <= i < W and libres[j, i]:\n                n[j, i] += p * bel[y, x]\n"
        "    return n / n.sum()"
    ),
}


@pytest.mark.parametrize(("name", "change"), NAMED.items(), ids=NAMED.keys())
def test_a_mistake_is_named_in_another_style(name: str, change: str) -> None:
    for seed in range(2):
        found = verdict(f"{GRADER.solution}\n\n{change}\n", seed)
        assert found.outcome is Outcome.WRONG_ANSWER
        assert found.diagnosis.id == name


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = json.loads(json.dumps(checks_of(mistake("sens_inverse"), 0, simplified=True).figures))
    assert set(figures) == {"predire_exemples", "predire_murs", "predire_autre_carte", "localisation"}
    for name in ("predire_exemples", "predire_autre_carte", "localisation"):
        assert counterexample(GRADER.exercise, figures[name], theme=theme).startswith(b"<?xml")


def test_every_failed_comparison_leaves_a_figure() -> None:
    for name in ("tour_du_bord", "centre_oublie", "sigma_par_defaut_faux"):
        found = checks_of(mistake(name), 1, simplified=True)
        assert found.figures
        assert {check.figure for check in found.verdict.checks if not check.passed} == set(found.figures)


def test_a_figure_without_anything_obtained_draws() -> None:
    data = {"kind": "beliefs", "free": [[True, False]], "given": [[1.0, 0.0]], "expected": [[1.0, 0.0]]}
    assert counterexample(GRADER.exercise, {**data, "got": None, "command": [0, -1], "scan": None}).startswith(b"<?xml")
    assert counterexample(GRADER.exercise, {**data, "got": None, "command": None, "scan": ["1", "2"]}).startswith(
        b"<?xml"
    )
