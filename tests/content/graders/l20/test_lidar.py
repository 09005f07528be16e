"""l20/lidar: honest ways of casting rays pass, mistakes are rejected and named, what is asked has one answer."""

from __future__ import annotations

import itertools
import json
import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.streams import stream
from graders.l20.lidar import cases, probes
from graders.l20.lidar.checks import ACCEPTED, SameDistance
from graders.plotting import counterexample
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, named, verdict_of

GRADER = CODE["l20/lidar"]
verdict = partial(verdict_of, GRADER.exercise)
RAYS = {"approche", "axe_x", "axe_y", "obliques", "portee", "bord", "cartes"}
DRAWINGS = (cases.along_axes, cases.oblique, cases.within_range, cases.over_the_edge, cases.anywhere)

MARCH = """
from math import cos, sin, floor
def lancer_rayon(libres, x, y, angle, portee_max):
    hauteur, largeur = libres.shape
    t = {first}
    while t < portee_max:
        colonne, ligne = {cell}
        if {outside} or not libres[ligne, colonne]:
            return {end}
        t += {step}
    return portee_max
"""
USUAL = {
    "first": "0.0",
    "cell": "floor(x + t * cos(angle)), floor(y + t * sin(angle))",
    "outside": "not (0 <= colonne < largeur and 0 <= ligne < hauteur)",
    "end": "t",
    "step": "0.05",
}


def march(**changes: str) -> str:
    """A march of small steps, some parts of which are replaced."""
    return MARCH.format(**{**USUAL, **changes})


def mistake(name: str) -> str:
    return next(m.source for m in GRADER.misconceptions if m.id == name)


def specimen(path: str) -> str:
    return (GRADER.folder / "specimens" / path).read_text(encoding="utf-8")


def test_the_solution_gets_full_marks() -> None:
    assert verdict(GRADER.solution, 1).score == 1.0


@pytest.mark.parametrize(
    "path",
    one_in(9, sorted((GRADER.folder / "specimens/ok").glob("*.py"))),
    ids=lambda path: path.stem,
)
def test_honest_styles_pass(path: Any) -> None:
    assert verdict(path.read_text(encoding="utf-8"), 1).score == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted((GRADER.folder / "specimens/ok").glob("*.py")), ids=lambda path: path.stem)
def test_honest_styles_pass_whatever_the_seed(path: Any) -> None:
    scores = {verdict(path.read_text(encoding="utf-8"), seed).score for seed in range(30)}
    assert scores == {1.0}


@pytest.mark.parametrize("step", ["0.1", "0.09", "0.03"])
@pytest.mark.parametrize("end", ["t", "max(t - {step}, 0.0)", "max(t - {step} / 2, 0.0)"])
def test_a_march_of_small_steps_passes(step: str, end: str) -> None:
    assert verdict(march(step=step, end=end.format(step=step)), 2).score == 1.0


@pytest.mark.parametrize("step", ["0.2", "1.0"])
def test_a_march_of_long_steps_is_refused_in_every_check_and_named(step: str) -> None:
    found = verdict(march(step=step), 2)
    assert failed(found) >= RAYS - {"approche"}
    assert found.points >= 2
    assert named(found) == "pas_trop_grand"


def test_a_march_of_long_steps_that_ends_in_their_middle_is_refused() -> None:
    for step in ("0.25", "0.3", "0.5"):
        source = march(step=step, end=f"max(t - {step} / 2, 0.0)")
        assert checked(GRADER.exercise, source, 2).verdict.score < 0.5


@pytest.mark.parametrize("step", ["0.05 / max(abs(cos(angle)), 1e-9)", "0.05 / max(abs(sin(angle)), 1e-9)",
                                  "0.1 / max(abs(cos(angle)), abs(sin(angle)))"])  # fmt: skip
def test_a_step_that_is_constant_on_an_axis_is_named_and_no_range_is_blamed(step: str) -> None:
    assert named(verdict(march(step=step), 2)) == "pas_sur_un_axe"


def test_a_range_is_blamed_only_where_the_same_rays_are_right_with_a_long_one() -> None:
    assert (
        named(verdict(march().replace("    return portee_max", "    return portee_max - 0.5"), 2))
        == "portee_mal_traitee"
    )
    grows = march(step="0.03 + 0.02 * t")
    assert named(verdict(grows, 2)) not in ("portee_mal_traitee", "bord_mal_traite")


OUTSIDE = "colonne < 0 or ligne < 0 or colonne >= {w} or ligne >= {h}"
MARCHING = {
    "axes_echanges": {"cell": "floor(y + t * sin(angle)), floor(x + t * cos(angle))"},
    "sens_de_y": {"cell": "floor(x + t * cos(angle)), floor(y - t * sin(angle))"},
    "cos_sin_echanges": {"cell": "floor(x + t * sin(angle)), floor(y + t * cos(angle))"},
    "int_au_lieu_de_floor": {"cell": "int(x + t * cos(angle)), int(y + t * sin(angle))"},
    "arrondi_au_plus_proche": {"cell": "round(x + t * cos(angle)), round(y + t * sin(angle))"},
    "angle_en_degres": {"cell": "floor(x + t * cos(angle * 0.017453292519943295)), "
                                "floor(y + t * sin(angle * 0.017453292519943295))"},
    "indices_negatifs": {"outside": "colonne >= largeur or ligne >= hauteur"},
    "carte_de_la_trousse": {"outside": OUTSIDE.format(w="W", h="H")},
    "dehors_non_prevu": {"outside": "colonne < 0 or ligne < 0"},
    "depart_arrondi": {"cell": "floor(floor(x) + t * cos(angle)), floor(floor(y) + t * sin(angle))"},
    "portee_de_la_trousse": {"step": "0.05 if t < 12 else 100", "first": "0.0\n    portee_max = PORTEE_MAX"},
    "toujours_la_portee": {"end": "portee_max"},
}  # fmt: skip


@pytest.mark.parametrize(("name", "changes"), one_in(3, MARCHING.items()), ids=MARCHING.keys())
def test_a_mistake_is_named_in_a_march_too(name: str, changes: dict[str, str]) -> None:
    found = verdict(march(**changes), 3)
    assert found.score < 1.0
    assert named(found) == name


WRONG = {
    "dépasse la portée d'un rien": march() + "_l = lancer_rayon\ndef lancer_rayon(*a):\n    return _l(*a) * 1.00001\n",
    "commence à une case": march(first="1.0"),
    "saute la première demi-case": march(first="0.5"),
    "un dixième de pas de trop, toujours": march(end="t + 0.1"),
    "le premier appel vaut pour tous": march() + "M = {}\n_l = lancer_rayon\ndef lancer_rayon(l, x, y, a, p):\n"
    "    return M.setdefault((x, y), _l(l, x, y, a, p))\n",
    "le dernier pas peut dépasser": march(step="0.1").replace("while t < portee_max", "while True").replace(
        "    return portee_max", ""),
    "douze toujours": march() + "_l = lancer_rayon\ndef lancer_rayon(l, x, y, a, p):\n    return _l(l, x, y, a, 12)\n",
    "cinq cases au plus": march() + "_l = lancer_rayon\ndef lancer_rayon(l, x, y, a, p):\n"
    "    return min(_l(l, x, y, a, p), 5)\n",
    "carte carrée": march(outside="not (0 <= colonne < hauteur and 0 <= ligne < hauteur)"),
    "un bord ouvert": march(outside="colonne < 0 or ligne < 0 or colonne > largeur - 1 or ligne > hauteur"),
    "le rayon opposé": march() + "_l = lancer_rayon\ndef lancer_rayon(l, x, y, a, p):\n"
    "    return _l(l, x, y, a - np.pi, p)\n",
    "angle positif": march() + "_l = lancer_rayon\ndef lancer_rayon(l, x, y, a, p):\n"
    "    return _l(l, x, y, abs(a), p)\n",
}  # fmt: skip


@pytest.mark.parametrize("source", one_in(2, WRONG.values()), ids=WRONG.keys())
def test_subtly_wrong_programs_are_rejected(source: str) -> None:
    assert checked(GRADER.exercise, source, 1).verdict.score < 1.0


@pytest.mark.parametrize("name", ["rien_touche", "int_au_lieu_de_floor", "bord_du_mauvais_cote"])
def test_the_same_checks_fail_whatever_the_seed(name: str) -> None:
    found = {frozenset(failed(checked(GRADER.exercise, mistake(name), seed).verdict)) for seed in range(3)}
    assert len(found) == 1


def test_the_kit_has_no_lidar_to_ask() -> None:
    kit = GRADER.kit(stream(1, "kit"))
    assert set(kit.without) == {"lidar", "lidar_lot"}
    found = verdict(specimen("runtime_error/lidar_de_la_trousse.py"), 1)
    assert found.outcome is Outcome.RUNTIME_ERROR
    assert "NameError" in found.checks[0].message


def test_the_map_must_be_left_alone() -> None:
    found = verdict(specimen("wrong_answer/visites_effacees.py"), 3)
    assert failed(found) == {"arguments"}
    assert named(found) == "argument_modifie"


@pytest.mark.parametrize("draw", DRAWINGS)
def test_what_is_asked_is_judged_and_no_map_is_the_kits(draw: cases.Drawing) -> None:
    for libres, x, y, angle, portee_max in some(draw(np.random.default_rng(3))):
        assert cases.judged((libres, x, y, angle, portee_max))
        assert -math.pi <= angle <= math.pi
        assert 0.0 < portee_max <= 12.0
        assert libres.shape[0] != libres.shape[1]


def test_one_ray_in_a_room_is_right_by_hand() -> None:
    room = cases.plan("####### #.....# #...#.# #.....# #######")
    for angle, length in ((0.0, 2.7), (math.pi, 0.3), (math.pi / 2, 1.4), (-0.5, 1.6 / math.sin(0.5))):
        assert cases.distance(room, 1.3, 2.6, angle, 12.0) == pytest.approx(length, abs=1e-12)
        assert cases.distance(room, 1.3, 2.6, angle, 2.0) == pytest.approx(min(length, 2.0), abs=1e-12)


def test_a_march_agrees_with_what_is_expected_on_all_that_is_judged() -> None:
    """An oracle of another kind: points every thousandth of a cell."""
    rng = np.random.default_rng(11)
    for libres, x, y, angle, portee_max in some(itertools.chain.from_iterable(draw(rng) for draw in DRAWINGS)):
        t = np.arange(0.0, portee_max, 1e-3)
        columns, rows = np.floor(x + t * math.cos(angle)).astype(int), np.floor(y + t * math.sin(angle)).astype(int)
        walls = ~np.pad(libres, 13)[rows + 13, columns + 13]
        marched = float(t[np.argmax(walls)]) if walls.any() else portee_max
        assert marched == pytest.approx(cases.distance(libres, x, y, angle, portee_max), abs=1.01e-3)


def test_rays_that_graze_a_corner_are_not_judged() -> None:
    free = np.ones((6, 7), dtype=bool)
    free[3, 4] = False
    slanted = (free, 1.5, 0.5, math.atan2(2.5, 2.5))  # through (4, 3), a corner of the wall
    assert not cases.judged((*slanted, 12.0))
    assert cases.judged((*slanted, 3.0))  # it ends before
    assert not cases.judged((free, 1.5, 0.5 + 0.08, slanted[3], 12.0))
    assert cases.judged((free, 1.5, 0.5 + 0.09, slanted[3], 12.0))
    assert not cases.judged((free, 3.0, 2.5, 0.3, 12.0))  # on a line of the grid
    assert not cases.judged((free, 4.5, 3.5, 0.3, 12.0))  # in the wall


def test_a_distance_is_a_number_near_enough() -> None:
    same = SameDistance()
    for got in (2.7, 2.7 + ACCEPTED, np.float32(2.65), np.array(2.75), 2.6):
        assert same(2.7, got) is None
    for got, words in ((2.81, "trop loin"), (2.5, "trop près"), (math.nan, "nan"), (math.inf, "infinie"),
                       (None, "return"), ([2.7], "(1,)"), ((3.0, 1.0), "(2,)")):  # fmt: skip
        found = same(2.7, got)
        assert found is not None
        assert words in found.message


def test_a_counterexample_is_a_small_map_and_says_what_stops_the_ray() -> None:
    check = next(c for c in verdict(mistake("int_au_lieu_de_floor"), 1).checks if not c.passed)
    assert check.counterexample is not None
    assert np.size(check.counterexample.inputs["libres"]) <= 54
    assert "sort de la grille" in check.message
    inside = next(c for c in verdict(march(step="0.5"), 1).checks if not c.passed)
    assert "est un mur" in inside.message


def test_a_closed_map_stays_closed_when_it_shrinks() -> None:
    for smaller in some(cases.shrink_map(cases.ROOM)):
        assert not smaller[[0, -1]].any()
        assert not smaller[:, [0, -1]].any()
    assert all(smaller.all() for smaller in list(cases.shrink_map(np.ones((4, 6), dtype=bool))))


def test_probes_are_judged_rays_which_a_march_answers_as_a_walk_does() -> None:
    assert all(cases.judged(args) for args in probes.CALLS)
    assert probes.same(2.7, 2.8)
    assert not probes.same(2.7, 2.9)
    assert not probes.same(2.7, math.inf)
    assert probes.same(math.inf, math.inf)
    assert not probes.same(2.7, "un texte")


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = json.loads(json.dumps(checked(GRADER.exercise, mistake("sens_de_y"), 0).figures))
    assert set(figures) == RAYS - {"axe_x"}
    assert counterexample(GRADER.exercise, figures["bord"], theme=theme).startswith(b"<?xml")
    data = figures["axe_y"]
    for got in (None, -3.0) if theme == "light" else (None, -3.0, 1000.0, 0.0):
        assert counterexample(GRADER.exercise, {**data, "got": got}, theme=theme).startswith(b"<?xml")
