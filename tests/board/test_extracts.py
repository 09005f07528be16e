"""What is shown of a student's program to others says nothing of whose it is."""

from __future__ import annotations

import time

import pytest

from server.board.extracts import CUT_MARK, MAX_LINES, anonymise_extract, extract_function, folded_name_words

CODE = '''"""Devoir d'Évariste Galois."""
import numpy as np

AUTEUR = "Galois"

def composer_bis(a, b):
    return a

def composer(
    a,
    b,
):  # par Évariste
    """Composer, par Galois."""
    galois_evariste = a + b
    x = f"{galois_evariste} de {AUTEUR}"

    return galois_evariste

class Reste:
    pass
'''


def test_a_function_is_extracted_whole_and_alone() -> None:
    found = extract_function(CODE, ["composer"])
    assert found.startswith("def composer(\n")
    assert found.endswith("return galois_evariste")
    assert extract_function(CODE, ["relatif", "Reste"]) == "class Reste:\n    pass"
    assert extract_function(CODE, ["compose"]) == ""
    assert extract_function("", ["composer"]) == ""


def test_comments_strings_and_names_are_removed() -> None:
    told = anonymise_extract(extract_function(CODE, ["composer"]), folded_name_words(["Évariste Galois", "Li Wu"]))
    assert "nom_nom = a + b" in told
    assert "return nom_nom" in told
    for word in ("Galois", "variste", "par", "#", '"'):
        assert word.casefold() not in told.casefold()
    assert (
        anonymise_extract("def f(li):\n    return li", folded_name_words(["Li Wu"])) == "def f(li):\n    return li"
    ), "a name of two letters is a word"


@pytest.mark.parametrize(
    "code", ["(" * 50_000, "'" * 50_001, "\x00def f(:", 'f"{' * 20_000, "-" * 60_000 + "1", "é" * 9000]
)
def test_extracts_are_bounded_for_any_program(code: str) -> None:
    told = anonymise_extract(
        extract_function(f"def composer(a, b):\n    {code}\n", ["composer"]), folded_name_words(["Ada Lovelace"])
    )
    assert len(told) < 250
    long = anonymise_extract("def f(x):\n" + "    x = x + 1\n" * 500, folded_name_words([]))
    assert long.endswith(CUT_MARK)
    assert long.count("\n") == MAX_LINES


def test_an_extract_is_read_in_linear_time() -> None:
    """Pygments took the square of the blanks between a soft keyword and what follows it."""

    def seconds(size: int) -> float:
        code, best = f"def composer(a):\n    match{' ' * size}x", float("inf")
        for _ in range(3):
            began = time.process_time()
            anonymise_extract(code, frozenset())
            best = min(best, time.process_time() - began)
        return best

    assert seconds(64_000) <= 8 * max(seconds(16_000), 0.002)
