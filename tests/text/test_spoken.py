"""The name of a control whose label holds formulas."""

from __future__ import annotations

import pytest

from server.text.markup.text import no_module_names
from server.text.prose import render_author_line
from server.text.spoken import html_to_spoken_text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Aucune.", ""),
        ("$0{,}5$", "0,5"),
        ("Son noyau est de dimension $3$ & plus.", "Son noyau est de dimension 3 & plus."),
        (r"La matrice $H$, <b>creuse</b>", "La matrice H, <b>creuse</b>"),
        (r"**$x$** puis $\sqrt{2}$", "x puis 2"),
    ],
)
def test_formulas_are_said_once(text: str, said: str) -> None:
    assert html_to_spoken_text(render_author_line(text, no_module_names)) == said


def test_a_matrix_is_said_row_by_row() -> None:
    cell = "<mtd><mstyle><mn>{}</mn></mstyle></mtd>".format
    rows = "".join(f"<mtr>{cell(a)}{cell(b)}</mtr>" for a, b in ((1, 2), (3, 4)))
    assert html_to_spoken_text(f"<math><mo>(</mo><mtable>{rows}</mtable><mo>)</mo></math>") == "(1, 2 ; 3, 4)"
