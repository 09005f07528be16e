"""Values of counterexamples and text from outside, as a reader sees them."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.text.plain import show_invisible_characters
from server.web.rendering import jinja_environment, render_backquotes_as_code
from server.web.values import MAX_ROWS, ValueView, build_value_view, build_value_view_pair, write_inputs_as_code
from server.web.words import count_with_noun, format_mark, format_points

SHOW = '{% from "values.html" import show %}{{ show(value) }}'
numbers = (
    st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.sampled_from(["nan", "inf", "-inf"])
)
json_values: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | numbers | st.text(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=20,
)


def shown(value: ValueView) -> str:
    return jinja_environment().from_string(SHOW).render(value=value)


def cells(value: Any, expected: Any = None) -> list[list[str]]:
    return [[cell.text for cell in row] for row in build_value_view(value, expected).rows]


def test_vectors_and_matrices_are_tables_in_french() -> None:
    assert cells([1.5, -2, "nan"]) == [["1,5", "\N{MINUS SIGN}2", "nan"]]
    assert cells([[1, 0.25], ["inf", 4]]) == [["1", "0,25"], ["∞", "4"]]


def test_what_differs_from_the_expected_is_marked() -> None:
    odd = [
        [cell.odd for cell in row]
        for row in build_value_view([[1, 2], [3, "nan"]], expected=[[1, 5], [3.0000000001, 4]]).rows
    ]
    assert odd == [[False, True], [False, True]]
    assert not any(cell.odd for cell in build_value_view([1, 2], expected=[1, 2, 3]).rows[0])


def test_values_side_by_side_have_the_digits_that_tell_them_apart() -> None:
    """Only numbers that differ get more digits, and a gap below six digits is marked when it is all that differs."""
    expected, got = build_value_view_pair([-0.25, -2.1415926536], [-0.25, -2.1415926464])
    texts = [[cell.text for cell in row] for view in (expected, got) for row in view.rows]
    assert texts == [["−0,25", "−2,1415926536"], ["−0,25", "−2,1415926464"]]
    assert [cell.odd for cell in got.rows[0]] == [False, True]
    assert not any(cell.odd for cell in expected.rows[0])
    number, other = build_value_view_pair(1.0, 1.00000001)
    assert number.text != other.text
    listed, others = build_value_view_pair([[1.0, 2.0], 3.0], [[1.0, 2.00000001], 3.0])
    assert listed.items[0][1].rows[0][1].text != others.items[0][1].rows[0][1].text
    assert build_value_view_pair(["a", None], [10**400, True])


def test_large_values_are_cut_and_say_so() -> None:
    big = build_value_view([[0.0] * 30] * 40)
    assert len(big.rows) == MAX_ROWS
    assert "40 × 30" in big.note
    assert "tableau de forme 40 × 50" in build_value_view({"forme": [40, 50], "premiers": [1.5]}).text


def test_a_counterexample_is_short_and_shows_where_it_differs() -> None:
    """A belief of the course is 16 × 24: three of them in full are 8 kB, of which nobody reads one number."""
    expected = [[0.0] * 24 for _ in range(16)]
    got = [row[:] for row in expected]
    got[11][3] = 0.5
    left, right = build_value_view_pair(expected, got)
    for view in (left, right):
        assert len(view.rows) == 3
        assert view.note == "16 × 24, seules les lignes d’indices 10 à 12 sont montrées"
    assert [cell.text for row in right.rows for cell in row if cell.odd] == ["0,5"]
    edges = build_value_view([[0, 1, [0.1, 0.2, 0.3]]] * 30, short=True)
    assert (len(edges.items), edges.note) == (4, "et 26 autres")


def test_grids_of_truth_values_are_drawn_as_maps() -> None:
    plan = build_value_view([[True, False], [False, True]])
    assert (plan.kind, plan.text) == ("plan", ".#\n#.")


def test_lists_that_are_no_matrix() -> None:
    mixed = build_value_view([[[1, 0], [0, 1]], [1, 2]], expected=[[[1, 0], [0, 1]], [1, 3]])
    assert mixed.kind == "list"
    assert mixed.items[1][1].rows[0][1].odd


@settings(deadline=None, max_examples=60)
@given(json_values, json_values)
def test_any_json_can_be_shown(value: Any, expected: Any) -> None:
    assert shown(build_value_view(value, expected))


@settings(deadline=None, max_examples=60)
@given(
    st.dictionaries(
        st.sampled_from(["a", "bel", "scan_obs"]), numbers | st.lists(numbers, min_size=1, max_size=4), min_size=1
    )
)
def test_replayed_lines_give_the_same_inputs(inputs: dict[str, Any]) -> None:
    import numpy as np

    names: dict[str, Any] = {"np": np}
    exec(write_inputs_as_code(inputs), names)
    for name, value in inputs.items():
        wanted = np.array(value, dtype=float) if value not in ("nan", "inf", "-inf") else float(value)
        np.testing.assert_array_equal(np.asarray(names[name], dtype=float), wanted)


def test_an_edge_of_a_graph_is_replayed_with_its_arrays() -> None:
    lines = write_inputs_as_code({"aretes": [[0, 1, [1.0, "nan"], [[1, 0], [0, 2]]], [1, 2, [3], [[1, 0]]]]})
    assert lines == (
        "aretes = [[0, 1, np.array([1.0, np.nan]), np.array([[1, 0], [0, 2]])], "
        "[1, 2, np.array([3]), np.array([[1, 0]])]]"
    )


def test_a_value_cut_short_cannot_be_replayed() -> None:
    assert write_inputs_as_code({"a": 1, "b": [{"forme": [900], "premiers": [1]}]}) == ""
    assert write_inputs_as_code({"argument 1": 3}) == ""


@pytest.mark.parametrize("strange", ["\x1b[31m", "\u202e", "\u2066", "\u200b", "\ufeff", "\x00", "\x7f", "\U000e0041"])
def test_invisible_characters_are_spelled_out(strange: str) -> None:
    text = show_invisible_characters(f"a{strange}b")
    assert strange not in text
    assert text.startswith("a")
    assert len(text) > 2


@settings(deadline=None, max_examples=60)
@given(st.text())
def test_visible_text_is_stable_and_keeps_what_can_be_seen(text: str) -> None:
    once = show_invisible_characters(text)
    assert show_invisible_characters(once) == once
    if text.isascii() and text.isprintable():
        assert once == text


@pytest.mark.parametrize("attack", ["<b>x</b>", "`<b>`", "{{ 7 * 7 }}", "`<script>`x`</script>`", '"><svg onload=x>'])
def test_a_message_is_never_markup(attack: str) -> None:
    html = str(render_backquotes_as_code(attack))
    assert "<b>" not in html
    assert "<script>" not in html
    assert "<svg" not in html
    assert "49" not in html


def test_ticks_mark_code() -> None:
    assert str(render_backquotes_as_code("appelez `f(x)` ici")) == "appelez <code>f(x)</code> ici"
    assert str(render_backquotes_as_code("un ` seul")) == "un ` seul"


def test_numbers_in_words() -> None:
    assert [count_with_noun(count, "essai") for count in (0, 1, 2)] == ["0 essai", "1 essai", "2 essais"]
    assert [format_points(value) for value in (20, 12.5, 0, 6.6667)] == ["20", "12,5", "0", "6,67"]


@pytest.mark.parametrize(
    ("value", "most", "shown"),
    [
        (20.0, 20.0, "20"),
        (20 * 0.1 * 10, 20.0, "20"),
        (19.99, 20.0, "19,75"),
        (17 / 6, 20.0, "2,75"),
        (2.875, 20.0, "3"),
        (0.0, 20.0, "0"),
        (20 / 22, 20 / 22, "0,91"),
        (0.9, 20 / 22, "0,75"),
    ],
)
def test_marks_are_shown_to_the_quarter_and_never_as_full_when_they_are_not(
    value: float, most: float, shown: str
) -> None:
    assert format_mark(value, most) == shown
