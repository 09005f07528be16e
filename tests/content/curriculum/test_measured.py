"""The tables of the texts hold what the scripts of `measured/` find: `pytest -m slow` runs them, some minutes long."""

from __future__ import annotations

import re

import numpy as np
import pytest

from graders.l20.tp_slam import recogniser
from reference.se2 import relative
from tests.content.curriculum.measured import graphs, journey, laboratory, particles, singles
from tests.content.curriculum.measured.claims import BY_HAND, MEASURES
from tests.content.curriculum.measured.tables import FOLDER, Measure, Table, agrees, seconds, tables

TABLES = tables()


def claimed(measure: Measure) -> Table:
    (found,) = [table for table in TABLES if (table.page, table.head[0]) == (measure.page, measure.head)]
    return found


def test_every_table_of_decimals_is_measured_or_said_to_be_by_hand() -> None:
    known = {(measure.page, measure.head) for measure in MEASURES} | BY_HAND.keys()
    there = {(table.page, table.head[0]): table.name for table in TABLES}
    assert [name for key, name in there.items() if key not in known and _by_key(key).tells_decimals] == []
    assert [key for key in known if key not in there] == []


def _by_key(key: tuple[str, str]) -> Table:
    return next(table for table in TABLES if (table.page, table.head[0]) == key)


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: f"{measure.page}-{measure.head}")
def test_each_claim_finds_its_table(measure: Measure) -> None:
    assert claimed(measure).rows


@pytest.mark.parametrize(
    ("cell", "value", "told"),
    [
        ("**0,67**", 0.6682, True),
        ("0,67", 0.664, False),
        ("−5719", -5719.4, True),
        ("12 / 30", 0.4, True),
        ("12 / 30", 0.5, False),
        ("plus de 100 pas", 101.0, True),
        ("plus de 100 pas", 80.0, False),
        ("moins de $10^{-7}$", 3e-8, True),
        ("moins de $10^{-7}$", 3e-7, False),
        ("entre 4 et 5 pas", 4.5, True),
        ("0,55 à 1", (0.545, 1.0), True),
        ("5,50 ± 0,048", (5.501, 0.0477), True),
        ("17 %", 16.6, True),
        ("toutes", None, True),
        ("toutes", 1.0, False),
    ],
)
def test_what_a_cell_tells(cell: str, value: float | tuple[float, float] | None, told: bool) -> None:
    assert agrees(cell, value) is told


def test_a_table_that_says_something_else_is_told() -> None:
    table = Table("page", ("N", "part", "temps"), (("1", "0,5", "1 ms"), ("2", "0,7", "10 ms")))
    rows = lambda: [[0.5, 0.002], [0.7, 0.03]]  # noqa: E731
    assert Measure("page", "N", rows, times=frozenset({1})).faults(table) == []
    assert Measure("page", "N", lambda: [[0.5, 0.002], [0.78, 0.03]], times=frozenset({1})).faults(table) != []
    assert Measure("page", "N", lambda: [[0.5, 0.002], [0.7, 0.3]], times=frozenset({1})).faults(table) != []
    assert Measure("page", "N", lambda: [[0.5, 0.002]]).faults(table) != []
    assert seconds("10 ms") == 0.01


@pytest.mark.slow
@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: f"{measure.page}-{measure.head}")
def test_a_table_holds_what_its_script_finds(measure: Measure) -> None:
    assert measure.faults(claimed(measure)) == []


def says(page: str, *parts: str) -> bool:
    """Does a lesson hold each of these words?"""
    text = (
        (FOLDER / f"{page}.md")
        .read_text(encoding="utf-8")
        .replace("{,}", ",")
        .replace("\u202f", " ")
        .replace("\xa0", " ")
    )
    return all(part in text for part in parts)


@pytest.mark.slow
def test_particles_drawn_where_the_scan_is_likely() -> None:
    assert particles.guided() == pytest.approx(39.0, abs=1.0)
    assert says("seances/localiser", "500 particules réussissent 39 fois sur 40")
    assert particles.truth_lost() == pytest.approx(9, abs=3)
    assert says("defis/kidnappe", "Neuf fois sur vingt")


@pytest.mark.slow
def test_rare_closures_are_solved_sooner() -> None:
    assert graphs.rare_closures() > 4.0
    assert says("seances/slam", "environ dix fois plus vite")


def test_kernels_that_start_well_or_harden_slowly() -> None:
    near, graduated = graphs.harsh_kernel_from_a_good_start_and_graduated()
    assert says("defis/robuste", f"l'écart revient à {near:.2f}".replace(".", ","))
    assert says("defis/robuste", f"elle trouve ici {graduated:.2f}".replace(".", ","))
    assert graphs.iterations_of_icp() == (27, 8)


@pytest.mark.slow
def test_the_practical_work_passes_its_own_checkpoints() -> None:
    """To within what the details of an ICP change: a centimetre, two closures."""
    scans, true = list(journey.keys()), journey.truth()
    assert says("tp/slam-navigation", "1 045 scans et 1 044 lignes", "136 poses clés", "71 fermetures acceptées")
    assert (len(journey.odometry()), len(scans)) == (1045, 136)
    assert len(journey.closures()) == pytest.approx(71, abs=2)
    first = journey.journey().ranges[0]
    assert (first[0], first[90]) == pytest.approx((3.4, 0.55), abs=0.05)
    end = float(np.hypot(*(journey.odometry() - true)[-1, :2]))
    shares = [step.share for step in journey.steps()]
    for told, found in (
        ("ATE de $0,58$ m", journey.ate(journey.odometry(), at_keys=False)),
        ("$1,10$ m d'écart", end),
        ("vaut $0,93$ en moyenne", float(np.mean(shares))),
        ("l'ATE tombe à $0,20$ m", journey.ate(journey.chain())),
        ("ATE de $0,10$ m", journey.ate(journey.optimised())),
        ("sans les fermetures : $0,20$ m", journey.ate(journey.optimised(closed=False))),
    ):
        assert says("tp/slam-navigation", told)
        assert found == pytest.approx(float(re.findall(r"\d,\d+", told)[0].replace(",", ".")), abs=0.0125)
    assert min(shares) > 0.7
    for i, j, z in [*((k, k + 1, step.T_a_b) for k, step in enumerate(journey.steps())), *journey.closures()]:
        assert np.hypot(*(z - relative(true[scans[i]], true[scans[j]]))[:2]) < 0.03


@pytest.mark.slow
def test_the_real_scans_pass_their_checkpoints() -> None:
    """With the course's own solutions; to within what the details of an ICP change."""
    found = laboratory.run()
    blind, right, ahead = laboratory.reading()
    assert says("tp/slam-navigation", "120 scans, dont 1 104 lectures ne voient rien")
    assert blind == 1104
    assert says("tp/slam-navigation", "23 paires proposées, 23 confirmées par la part, 16 gardées")
    apart = np.hypot(*np.diff(laboratory.truth()[:, :2], axis=0).T)
    assert says("tp/slam-navigation", "il y a 70 cm en moyenne")
    assert apart.mean() == pytest.approx(0.70, abs=0.01)
    assert says("tp/slam-navigation", "pour 83 m parcourus")
    assert apart.sum() == pytest.approx(83.5, abs=0.5)
    assert (found.tried, found.confirmed, found.kept) == (23, 23, pytest.approx(16, abs=1))
    for told, value in (
        ("un mur à $1,09$ m à droite", right),
        ("un autre à $2,63$ m devant", ahead),
        ("ATE de $10,82$ m", found.odometry),
        ("se trompe de $-0,040$ rad", -found.missed[0]),
        ("un écart-type de $0,040$ rad", found.missed[1]),
        ("ATE de $0,80$ m", found.first_chain),
        (r"\alpha = 0,052$ rad/m", found.constants[0]),
        (r"\beta = 0,975$", found.constants[1]),
        (r"\gamma = 0,962$", found.constants[2]),
        ("à $0,81$ m, sans qu'aucune vérité", found.calibrated),
        ("se trompe encore de $0,030$ rad par pas", found.missed[3]),
        ("mais de moins de $0,001$ en moyenne", abs(found.missed[2])),
        ("ATE de $0,21$ m, quatre fois mieux", found.chain),
        ("descend jusqu'à $0,35$", found.least_share),
        ("ATE de $0,10$ m avec les 16 boucles", found.graph),
        ("$0,25$ m sans elles", found.without),
        ("$0,54$ m avec les 23", found.with_false),
    ):
        assert says("tp/slam-navigation", told)
        number = re.findall(r"\d+,\d+", told)[0]
        nearness = 0.0125 if len(number.split(",")[1]) == 2 else 0.0015
        assert value == pytest.approx(float(number.replace(",", ".")), abs=nearness), told
    assert says("seances/slam", "$-0,040$ rad en moyenne", "fausse de $10,8$ m", "à $0,81$ m", "Les $0,030$ rad")
    assert found.odometry / found.graph == pytest.approx(100, rel=0.15)
    assert says("tp/slam-navigation", "8 177 carrés avec l'odométrie, 3 838 avec votre graphe, 3 531 avec les poses")
    assert laboratory.squares() == pytest.approx((8177, 3838, 3531), rel=0.01)


@pytest.mark.slow
def test_the_local_minimum_of_the_lesson_is_there() -> None:
    """Killian Court, from odometry and from the chordal start."""
    assert says(
        "seances/slam", "a 808 poses", r"s'arrête après une quarantaine de tours à $\chi^2 = 770$", "est à $39,6$"
    )
    assert says("seances/slam", r"arrive à $\chi^2 = 69$, et Gauss-Newton finit à $39,6$ en quatre tours")
    poses, stuck, rounds, apart, start, found = laboratory.killian_court()
    assert poses == 808
    assert (stuck, start) == (pytest.approx(769.7, abs=0.1), pytest.approx(69.3, abs=0.1))
    assert rounds == pytest.approx(40, abs=4)
    assert apart == pytest.approx(19.0, abs=0.1)
    assert found[4] == pytest.approx(39.60, abs=0.01)
    assert found[1] > 45


@pytest.mark.slow
def test_the_loops_of_the_laboratory_are_what_the_recogniser_proposes() -> None:
    """Their poses stand on a grid of 10 cm: rounding may choose its neighbour, and no more."""
    kept = laboratory.read("boucles.csv")
    found = recogniser.recognise(laboratory.clouds(), laboratory.run().chained)
    assert [(a, b) for a, b, _ in found] == [(int(a), int(b)) for a, b, *_ in kept]
    np.testing.assert_allclose([pose for _, _, pose in found], kept[:, 2:], atol=0.101)


@pytest.mark.slow
def test_the_published_graph_of_the_laboratory_ends_where_the_text_says() -> None:
    """By sparse steps, and the error of the course's solution: its own steps, which are dense, take a minute."""
    poses, edges, start, end = laboratory.published()
    assert says("tp/slam-navigation", "1 228 poses, 1 483 arêtes", "part de plus de cinq millions", "$214,17$")
    assert (poses, edges) == (1228, 1483)
    assert start > 5e6
    assert end == pytest.approx(214.17086, abs=1e-4)


@pytest.mark.slow
def test_what_is_measured_outside_tables() -> None:
    assert singles.astray_in_a_circle() == pytest.approx(0.24, abs=0.01)
    assert says("seances/localiser", "erreur quadratique moyenne de 24 cm")
    assert says("fiches/exercices-corriges", "que de $0,24$ m")
    assert singles.quarter_circle(middle=False) == pytest.approx(0.11, abs=0.005)
    assert singles.quarter_circle(middle=True) == pytest.approx(0.0015, abs=0.0001)
    assert says("seances/localiser", "11 cm à l'arrivée", "de 1,5 mm")
    length, cells = singles.ray_in_the_map()
    assert length == pytest.approx(2.8, abs=0.05)
    assert cells == pytest.approx(4.0, abs=0.1)
    assert says("seances/localiser", "2,8 cases en moyenne et en visite quatre")
    assert singles.farther_by_steps() == pytest.approx(12.0, abs=0.5)
    assert says("cours/rayons", "12 % des cases libres")


@pytest.mark.slow
def test_a_passer_by_in_the_scan_that_icp_registers() -> None:
    plain, disturbed, trimmed = singles.intruders()
    assert plain == pytest.approx(0.03, abs=0.005)
    assert disturbed == pytest.approx(0.25, abs=0.02)
    assert trimmed < 0.01
    assert says("seances/slam", "passée de 0,03 case à 0,25", "retombée sous 0,01")


@pytest.mark.slow
def test_a_field_is_quicker_than_rays_and_must_be_fine() -> None:
    assert 4.0 < singles.faster_by_field() < 100.0
    assert says("cours/rayons", "de dix à trente fois plus vite")
    (coarse, _), (middle, off), (fine, near) = (singles.by_field(fineness) for fineness in (1, 2, 8))
    assert coarse <= 3
    assert (middle, fine) == (pytest.approx(15, abs=2), pytest.approx(17, abs=2))
    assert (off, near) == (pytest.approx(0.22, abs=0.06), pytest.approx(0.08, abs=0.03))
    assert says("cours/rayons", "15 fois sur une grille deux fois plus fine, et 17 fois", "de 0,22 à 0,08 case")
