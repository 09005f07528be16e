"""Constants written with too few digits: found, told with their lines, and not taken for other numbers."""

import pytest

from graders.core.code.rounded_constants import find_rounded_constants, rounded_constant_diagnosis


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("pi = 3.14159265", [(1, "3.14159265", "np.pi")]),
        ("x = 3.14 * 2", [(1, "3.14", "np.pi")]),
        ("x = 3.1416 - a % 6.2832", [(1, "3.1416", "np.pi"), (1, "6.2832", "2 * np.pi")]),
        ("\nx = 1.5708 + 0.0174533 * d", [(2, "1.5708", "np.pi / 2"), (2, "0.0174533", "np.pi / 180")]),
        ("x = a * 57.2958", [(1, "57.2958", "180 / np.pi")]),
        ("x = 3.1 + 3.2 + 0.02 + 1.6 + 3.15 + 13.14 + a3.14", []),
        ("x = '3.14'  # 3.14", []),
        ("x = 3.141592653589793", []),
    ],
)
def test_rounded_constants_are_found(source: str, found: list[tuple[int, str, str]]) -> None:
    assert list(find_rounded_constants(source)) == found


def test_they_are_named_with_their_lines() -> None:
    diagnosis = rounded_constant_diagnosis(b"a = 1\nb = 3.14\n")
    assert diagnosis is not None
    assert diagnosis.id == "constante_arrondie"
    assert "Ligne 2 : 3.14 est à écrire np.pi." in diagnosis.explanation
    assert rounded_constant_diagnosis(b"b = np.pi") is None
