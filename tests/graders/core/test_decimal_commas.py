"""Decimal commas: found where nothing else can be meant, and told with their lines when a program fails."""

import pytest

from graders.core.code.decimal_commas import decimal_comma_diagnosis, find_decimal_commas


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("x = 0,5 * L", [(1, "0,5")]),
        ("def f():\n    return 0,5", [(2, "0,5")]),
        ("x = (3,14) * 2", [(1, "3,14")]),
        ("x = 2 * 1,25 + f(1,2)", [(1, "1,25")]),
        ("a, b = 0,5", []),
        ("x = [0,5]", []),
        ("x = f(0,5) + a[0,5]", []),
        ("for i in 0,5:\n    pass", []),
        ("x = '0,5'  # 0,5", []),
        ("x = 0, 5", []),
        ("x = (0,5,2)", []),
        ("x = np.array([(0,5)])", [(1, "0,5")]),
    ],
)
def test_decimal_commas_are_found_where_nothing_else_is_meant(source: str, found: list[tuple[int, str]]) -> None:
    assert find_decimal_commas(source) == found


def test_a_decimal_comma_is_named_with_its_line() -> None:
    found = decimal_comma_diagnosis(b"def f(x):\n    return np.array([x, x]) * 0,5\n")
    assert found is not None
    assert found.id == "virgule_decimale"
    assert "Ligne 2 : 0,5 s’écrit 0.5." in found.explanation
    assert decimal_comma_diagnosis(b"x = 0.5") is None
