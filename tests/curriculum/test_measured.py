"""The tables of the texts hold what the scripts of `measured/` find: `pytest -m slow` runs them, some minutes long."""

from __future__ import annotations

import pytest

from tests.curriculum.measured import graphs, particles
from tests.curriculum.measured.claims import BY_HAND, MEASURES
from tests.curriculum.measured.tables import FOLDER, Measure, Table, agrees, seconds, tables

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
    text = (FOLDER / f"{page}.md").read_text(encoding="utf-8").replace("{,}", ",")
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
