"""l20/modele_faisceau: honest styles pass, mistakes are rejected and named, no equality that is asked betrays."""

from __future__ import annotations

import itertools
import json
import math
import re
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from graders.core.contract.outcomes import Outcome
from graders.core.contract.streams import stream
from graders.l20.modele_faisceau import cases
from graders.l20.modele_faisceau.checks import SameField, SameLogarithm, distance_field, log_likelihood
from graders.plotting import counterexample
from reference.errors import InvalidArgumentError
from reference.sensors.beam import BeamModel, plain_log_likelihood
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, checked_verdict_of, failed, named, verdict_of

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

GRADER = CODE["l20/modele_faisceau"]
verdict = partial(verdict_of, GRADER.exercise)
checked_verdict = partial(checked_verdict_of, GRADER.exercise)
READINGS = (cases.echoes, cases.obstacles, cases.full_range, cases.scans, cases.long_scans)
MAPS = (cases.small_maps, cases.any_maps)
WEIGHING = {"echos", "imprevus", "portee", "scans", "longs_scans"}
MEASURING = {"champ_exemples", "champ_cartes"}


def mistake(name: str) -> str:
    return next(m.source for m in GRADER.misconceptions if m.id == name)


def specimen(path: str) -> str:
    return (GRADER.folder / "specimens" / path).read_text(encoding="utf-8")


def changed(change: str) -> str:
    return f"{GRADER.solution}\n\n_l, _c = log_vraisemblance, champ_distance\n{change}\n"


def test_the_solution_gets_full_marks() -> None:
    assert verdict(GRADER.solution, 1).score == 1.0


STYLES = sorted((GRADER.folder / "specimens/ok").glob("*.py"))


@pytest.mark.parametrize("path", some(STYLES)[::3], ids=lambda path: path.stem)
def test_honest_styles_pass(path: Any) -> None:
    assert verdict(path.read_text(encoding="utf-8"), 1).score == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("path", STYLES, ids=lambda path: path.stem)
def test_honest_styles_pass_whatever_the_seed(path: Any) -> None:
    assert {verdict(path.read_text(encoding="utf-8"), seed).score for seed in range(30)} == {1.0}


HONEST = {
    "0-d": "def log_vraisemblance(*a):\n    return np.array(_l(*a))",
    "liste de listes": "def champ_distance(m):\n    return _c(m).tolist()",
    "une garde minuscule": "def log_vraisemblance(z, m, s, zm, a, l):\n    h, c, x, r = a\n"
    "    p = h * np.exp(-(z - m) ** 2 / 2 / s ** 2) / s / np.sqrt(2 * np.pi) + c * l * np.exp(-l * z) * (z <= m)\n"
    "    return np.log(p + x * (z >= zm) + r / zm + 1e-12).sum()",
    "à un cheveu près": "def champ_distance(m):\n    return _c(m) + 1e-12",
    "sans regarder l'ordre": "def log_vraisemblance(z, m, *a):\n    return _l(z[::-1], m[::-1], *a)",
}


@pytest.mark.parametrize("change", HONEST.values(), ids=HONEST.keys())
def test_honest_changes_pass(change: str) -> None:
    assert verdict(changed(change), 1).score == 1.0


WRONG = {
    "sigma plafonné": "def log_vraisemblance(z, m, s, *a):\n    return _l(z, m, min(s, 1.0), *a)",
    "sigma au moins 0,3": "def log_vraisemblance(z, m, s, *a):\n    return _l(z, m, max(s, 0.3), *a)",
    "parts renormalisées sans le hasard": "def log_vraisemblance(z, m, s, zm, a, l):\n"
    "    return _l(z, m, s, zm, a / a[:3].sum(), l)",
    "trente rayons au plus": "def log_vraisemblance(z, m, *a):\n    return _l(z[:30], m[:30], *a)",
    "un rayon sur deux": "def log_vraisemblance(z, m, *a):\n    return _l(z[::2], m[::2], *a)",
    "un plancher à 0,02": "def log_vraisemblance(z, m, *a):\n"
    "    return sum(max(_l(z[k:k+1], m[k:k+1], *a), np.log(0.02)) for k in range(len(z)))",
    "un plancher à 0,001": "def log_vraisemblance(z, m, *a):\n"
    "    return sum(max(_l(z[k:k+1], m[k:k+1], *a), np.log(0.001)) for k in range(len(z)))",
    "une garde trop grande": "def log_vraisemblance(z, m, *a):\n"
    "    return sum(np.log(np.exp(_l(z[k:k+1], m[k:k+1], *a)) + 1e-6) for k in range(len(z)))",
    "le premier appel vaut pour tous": "M = {}\ndef log_vraisemblance(z, *a):\n"
    "    return M.setdefault(len(z), _l(z, *a))",
    "les lectures à la portée sautées": "def log_vraisemblance(z, m, s, zm, *a):\n"
    "    return _l(z[z < zm], m[z < zm], s, zm, *a)",
    "moins un millionième": "def log_vraisemblance(*a):\n    return _l(*a) * (1 - 1e-6)",
    "carte carrée": "def champ_distance(m):\n    n, c = min(m.shape), _c(m)\n    c[n:] = c[:, n:] = 0\n    return c",
    "transposée": "def champ_distance(m):\n    return _c(m).T",
    "simple précision": "def champ_distance(m):\n    return _c(m).astype(np.float32)",
    "aplati": "def champ_distance(m):\n    return _c(m).ravel()",
    "en place": "def champ_distance(m):\n    c = _c(m)\n    m[:] = True\n    return c",
}


@pytest.mark.parametrize("change", one_in(2, WRONG.values()), ids=WRONG.keys())
def test_subtly_wrong_programs_are_rejected(change: str) -> None:
    assert checked(GRADER.exercise, changed(change), 1).verdict.score < 1.0


NAMED = {
    "produit_qui_s_annule": "import math\ndef log_vraisemblance(z, m, *a):\n    p = 1.0\n    for k in range(len(z)):\n"
    "        p *= math.exp(_l(z[k:k+1], m[k:k+1], *a))\n    return np.log(p)",
    "logarithme_oublie": "def log_vraisemblance(*a):\n    return np.exp(_l(*a))",
    "lu_et_attendu_echanges": "def log_vraisemblance(m, z, *a):\n    return _l(z, m, *a)",
    "carte_de_la_trousse": "def champ_distance(m):\n"
    "    w = [(i, j) for i in range(H) for j in range(W) if not m[i, j]]\n"
    "    return [[min(np.hypot(i - a, j - b) for a, b in w) for j in range(W)] for i in range(H)]",
    "moyenne": "def log_vraisemblance(z, *a):\n    return _l(z, *a) / len(z)",
    "valeurs_en_dur": "def log_vraisemblance(z, m, s, zm, a, l):\n    return _l(z, m, s, PORTEE_MAX, a, l)",
    "distance_par_pas": "def champ_distance(m):\n    from scipy.ndimage import distance_transform_cdt as d\n"
    "    return d(m, metric='taxicab')",
    "pas_du_roi": "def champ_distance(m):\n    from scipy.ndimage import distance_transform_cdt as d\n"
    "    return d(m, metric='chessboard')",
    "libres_et_murs_echanges": "def champ_distance(m):\n    from scipy.ndimage import distance_transform_edt as d\n"
    "    return d(~m)",
    "bord_compte_comme_mur": "def champ_distance(m):\n    from scipy.ndimage import distance_transform_edt as d\n"
    "    return d(np.pad(m, 1))[1:-1, 1:-1]",
    "distance_au_carre": "def champ_distance(m):\n    return _c(m) ** 2",
    "jusqu_au_bord_du_mur": "def champ_distance(m):\n    return np.maximum(_c(m) - 0.5, 0)",
}


@pytest.mark.parametrize(("name", "change"), one_in(2, NAMED.items()), ids=NAMED.keys())
def test_a_mistake_is_named_in_another_style(name: str, change: str) -> None:
    assert named(verdict(changed(change), 3)) == name


def test_a_chamfer_is_named_by_what_is_true_of_it() -> None:
    found = verdict(specimen("wrong_answer/chanfrein.py"), 2)
    assert failed(found) == MEASURING
    assert named(found) == "distance_par_pas"


def test_a_product_costs_the_long_scans_alone() -> None:
    found = verdict(mistake("produit_qui_s_annule"), 2)
    assert failed(found) == {"longs_scans"}
    assert "−∞" in next(check.message for check in found.checks if not check.passed)


def test_the_range_costs_what_asks_about_it() -> None:
    found = [checked(GRADER.exercise, mistake(one), 2).verdict for one in ("portee_mal_traitee", "indicatrice_oubliee")]
    assert failed(found[0]) == {"portee", "scans", "longs_scans"}
    assert failed(found[1]) >= {"echos", "portee"}


@pytest.mark.parametrize("name", one_in(2, ["inegalite_stricte", "valeurs_en_dur", "mauvais_mur_retenu", "normalisee"]))
def test_the_same_checks_fail_whatever_the_seed(name: str) -> None:
    found = {frozenset(failed(checked(GRADER.exercise, mistake(name), seed).verdict)) for seed in range(3)}
    assert len(found) == 1


def test_arguments_must_be_left_alone() -> None:
    found = verdict(specimen("wrong_answer/modifie_sur_place.py"), 3)
    assert failed(found) == {"arguments"}
    assert named(found) == "argument_modifie"
    assert checked_verdict(specimen("invalid_output/sans_return.py"), 1).outcome is Outcome.INVALID_OUTPUT


@pytest.mark.parametrize("draw", READINGS)
def test_readings_are_exactly_what_decides_of_a_cause_or_far_from_it(draw: cases.Drawing) -> None:
    for z, expected, sigma, z_max, alpha, lam in some(draw(np.random.default_rng(5))):
        assert z.shape == expected.shape
        assert np.all((z > 0) & (z <= z_max) & (expected > 0) & (expected <= z_max))
        for gap in (z - expected, z - z_max):
            assert np.all((gap == 0.0) | (np.abs(gap) > 0.009))
        assert alpha.sum() == pytest.approx(1.0)
        assert alpha.min() > 0.005
        assert sigma > 0.0
        assert lam > 0.0


def test_the_product_of_a_long_scan_is_zero_in_the_machine() -> None:
    for args in some(cases.long_scans(np.random.default_rng(5))):
        densities = [math.exp(log_likelihood(args[0][k : k + 1], args[1][k : k + 1], *args[2:])) for k in range(400)]
        assert math.prod(densities) == 0.0
        assert min(densities) > 1e-3
        assert math.fsum(map(math.log, densities)) == pytest.approx(log_likelihood(*args), rel=1e-12)


def test_the_formula_agrees_with_the_course_by_hand() -> None:
    settings = (0.2, 10.0, (0.7, 0.1, 0.1, 0.1), 0.5)
    for z, density in ((5.0, 1.4104), (2.0, 0.0284), (10.0, 0.11)):
        assert math.exp(plain_log_likelihood([z], [5.0], *settings)) == pytest.approx(density, abs=5e-5)
    assert plain_log_likelihood([5.0, 2.0, 10.0], [5.0] * 3, *settings) == pytest.approx(-5.425, abs=5e-4)
    assert plain_log_likelihood([4.0], [3.0], 0.5, 10.0, (1, 0, 0, 0), 1.0) == pytest.approx(norm(3, 0.5).logpdf(4))
    assert plain_log_likelihood([4.0], [3.0], 0.5, 10.0, (0, 1, 0, 0), 1.0) == -math.inf


def test_the_formula_is_the_normalised_one_where_nothing_overflows() -> None:
    shares, sigma, rate, longest = (0.6, 0.2, 0.1, 0.1), 0.1, 8.0, 10.0
    model = BeamModel(longest, *shares, sigma=sigma, rate=rate)
    z, truth = np.array([4.9, 0.3, 7.0]), np.array([5.0, 6.0, 4.0])
    assert plain_log_likelihood(z, truth, sigma, longest, shares, rate) == pytest.approx(
        float(model.log_density(z, truth).sum()), abs=1e-9
    )
    with pytest.raises(InvalidArgumentError):
        plain_log_likelihood([1.0, 2.0], [1.0], sigma, longest, shares, rate)
    with pytest.raises(InvalidArgumentError):
        plain_log_likelihood([1.0], [1.0], sigma, longest, (0.5, 0.1, 0.1, 0.1), rate)


def test_fields_are_those_of_two_loops() -> None:
    for (libres,) in some(itertools.chain.from_iterable(draw(np.random.default_rng(4)) for draw in MAPS)):
        walls = np.argwhere(~libres)
        assert len(walls)
        by_loops = [[min(math.dist((y, x), wall) for wall in walls) for x in range(libres.shape[1])]
                    for y in range(libres.shape[0])]  # fmt: skip
        assert np.allclose(distance_field(libres), by_loops, atol=1e-12, rtol=0.0)


def test_answers_are_told_in_words() -> None:
    same, field = SameLogarithm(), SameField()
    assert same(-3.0, np.float64(-3.0)) is None
    assert same(-1265.0, -1265.0 - 1e-7) is None
    for got, words in ((-math.inf, "infini"), (None, "return"), ([-3.0], "(1,)"), (math.nan, "nan")):
        found = same(-3.0, got)
        assert found is not None
        assert words in found.message
    wanted = np.array([[0.0, 1.0], [1.0, 2.0]])
    found = field(wanted, [[0, 1], [1, 3]])
    assert found is not None
    assert "(1, 1) : 3 au lieu de 2" in found.message
    assert field(wanted, wanted.tolist()) is None
    check = next(c for c in verdict(mistake("cause_oubliee"), 1).checks if not c.passed)
    assert "la densité vaut" in check.message


def test_a_counterexample_of_a_field_is_a_small_map() -> None:
    check = next(c for c in verdict(mistake("distance_par_pas"), 1).checks if c.id == "champ_exemples")
    assert check.counterexample is not None
    assert np.size(check.counterexample.inputs["libres"]) <= 6


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = json.loads(json.dumps(checked(GRADER.exercise, mistake("cause_oubliee"), 0).figures))
    assert set(figures) == WEIGHING
    fields = json.loads(json.dumps(checked(GRADER.exercise, mistake("bord_compte_comme_mur"), 0).figures))
    assert set(fields) == MEASURING
    for data in (figures["longs_scans"], fields["champ_cartes"]):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")
    for data in (figures["imprevus"], fields["champ_exemples"]) if theme == "dark" else ():
        assert counterexample(GRADER.exercise, {**data, "got": None}, theme=theme).startswith(b"<?xml")


def test_each_map_that_is_drawn_has_a_wall() -> None:
    """A map without any is not asked: there is no distance then. This seed drew one."""
    assert all(not libres.all() for (libres,) in cases.any_maps(stream(77, "champ_cartes")))


def test_a_sum_that_is_hardly_wrong_is_shown_with_the_digits_that_differ() -> None:
    """Sums of four hundred logarithms, which print alike with six digits."""
    near = (
        GRADER.solution
        + "\n\n_sum = log_vraisemblance\n\n\ndef log_vraisemblance(*args):\n    return _sum(*args) * (1 + 1e-6)\n"
    )
    found = verdict(near, 7)
    shown = [re.search(r"on attend (\S+), et l’on obtient (\S+)\.", check.message or "") for check in found.checks]
    pairs = [match.groups() for match in shown if match]
    assert pairs
    assert all(expected != obtained for expected, obtained in pairs)
