"""Characters that Python does not know: the advice that is told, followed to the letter, repairs the program."""

import ast
import io
import tokenize

import pytest

from server.sandbox import messages
from server.sandbox.foreign_characters import (
    describe_foreign_characters,
    find_foreign_characters,
    is_readable,
    latin_spelling,
    replace_foreign_characters,
    show_foreign_characters,
)
from tests.support.tables import folded

PROGRAM = '''import numpy as np


def ramener(angle, *, tours=1):
    """Ramène un angle dans ]−π, π] « sans » un × de trop : – … ≤ “ ”"""
    if angle > np.pi and not tours != 2:
        return [angle - 2 * np.pi * tours, "été – hiver"]  # l’angle × 2
    total = (angle +
             tours / 2) \\
        - 1
    for k in range(3):
        total -= k <= 2 and {"é": k}["é"] ** 2
    return total if total >= 0 else f"{total} m²"


class Pose:
    x: float = 0.5
'''
SPACES = "\u00a0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000"
UNSEEN = "\u00ad\u034f\u180e\u200b\u200c\u200d\u200e\u200f\u202a\u202e\u2060\u2061\u2066\ufeff"
OTHERS = "\u000b\u0085\u2028\u2029−–—‐‑×÷∕“”‘’«»²³⁴≤≥≠→…√∞½；，：（）［］｛｝＝＋＊１٣€№"


def borders(program: str) -> list[int]:
    """Return the indices in the text at which a token begins or ends."""
    starts = [0]
    for line in program.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    tokens = tokenize.generate_tokens(io.StringIO(program).readline)
    ends = {
        starts[row - 1] + column for token in tokens for row, column in (token.start, token.end) if row <= len(starts)
    }
    return sorted(ends)


BORDERS = borders(PROGRAM)
#: Each space is put at one of so many spaces of the program.
SPACE_STRIDE = 5


@pytest.mark.parametrize("character", SPACES + UNSEEN + OTHERS, ids=lambda it: f"U+{ord(it):04X}")
def test_the_advice_repairs_a_program_with_a_character_too_many(character: str) -> None:
    """At borders of two words, each of which meets one character of every kind, wherever Python does not read it."""
    original = ast.dump(ast.parse(PROGRAM))
    broken = 0
    (kind,) = (kind for kind in (SPACES, UNSEEN, OTHERS) if character in kind)
    for index in BORDERS[kind.index(character) :: len(kind)]:
        text = PROGRAM[:index] + character + PROGRAM[index:]
        if is_readable(text):
            continue
        broken += 1
        found = find_foreign_characters(text.split("\n"))
        assert [text[it.index] for it in found] == [character]
        assert found[0].line == text.count("\n", 0, index) + 1
        assert f"U+{ord(character):04X}" in describe_foreign_characters(found)
        mended = replace_foreign_characters(text.split("\n"), found)
        assert is_readable(mended)
        if character in SPACES + UNSEEN:
            assert ast.dump(ast.parse(mended)) == original
    assert broken


@pytest.mark.parametrize("space", SPACES)
def test_a_space_that_parts_two_words_is_replaced_by_a_space(space: str) -> None:
    """Each space of the program gives way to several of them."""
    places = [index for index, letter in enumerate(PROGRAM) if letter == " "]
    for index in places[SPACES.index(space) % SPACE_STRIDE :: SPACE_STRIDE]:
        text = PROGRAM[:index] + space + PROGRAM[index + 1 :]
        found = find_foreign_characters(text.split("\n"))
        if is_readable(text):
            assert not found  # within a string or a comment
        else:
            assert replace_foreign_characters(text.split("\n"), found) == PROGRAM
            assert "à remplacer par une espace" in describe_foreign_characters(found)
    lines = SIGNS.replace(" ", space).split("\n")
    assert replace_foreign_characters(lines, find_foreign_characters(lines)) == SIGNS


LOOK_ALIKES = {
    "-": "− – — ‐ ‑", "*": "× ∗ ⋅", "/": "÷ ∕", '"': "“ ” ″ „", "'": "‘ ’ ′", "<=": "≤", ">=": "≥", "!=": "≠",
    "->": "→", "...": "…", "(": "（", ")": "）", "[": "［", "]": "］", "{": "｛", "}": "｝", ":": "：", ",": "，",
    "=": "＝", "+": "＋", "<": "＜", ">": "＞", "1": "１", "2": "２ ٢", ";": "；", "**2": "²", "def": "ｄｅｆ dеf",
    "return": "rеturn ｒｅｔｕｒｎ",
}  # fmt: skip
SIGNS = """def f(a, b: list[int]) -> dict:
    c = [a - 1, 2 * b[1] / 2.5, {'x': 1}]; d = (c <= a) + (a != b) - (a >= b) + (a < b > 1)
    e = a**2 + "mot"[1]
    return ...
"""


@folded(("plain", "foreign"), [(plain, foreign) for plain, many in LOOK_ALIKES.items() for foreign in many.split()])
def test_the_key_to_type_brings_the_program_back(plain: str, foreign: str) -> None:
    text = SIGNS.replace(plain, foreign)
    assert not is_readable(text)
    found = find_foreign_characters(text.split("\n"))
    assert ast.dump(ast.parse(replace_foreign_characters(text.split("\n"), found))) == ast.dump(ast.parse(SIGNS))
    assert all(it.line == text.count("\n", 0, it.index) + 1 for it in found)


def test_an_invisible_character_that_holds_two_words_apart_becomes_a_space() -> None:
    lines = ["def f(x):", "    return\u200bx"]
    assert replace_foreign_characters(lines, find_foreign_characters(lines)) == "def f(x):\n    return x"
    lines = ["nom\u200bbre = 1"]
    assert replace_foreign_characters(lines, find_foreign_characters(lines)) == "nombre = 1"


def test_strings_and_comments_hold_any_character() -> None:
    assert find_foreign_characters(PROGRAM.split("\n")) == []
    text = PROGRAM.replace("import", "import\u00a0")
    assert [it.line for it in find_foreign_characters(text.split("\n"))] == [1]


def test_quotes_of_typography_are_told_and_what_they_hold_is_not() -> None:
    lines = ["print(“été – hiver”)", "print(« l’été »)", "x = ‘a’"]
    found = find_foreign_characters(lines)
    assert replace_foreign_characters(lines, found) == 'print("été – hiver")\nprint(" l’été ")\nx = \'a\''


def test_the_message_names_every_line_and_shows_the_unseen() -> None:
    lines = ["import numpy as np", "", "def f(x):", "    return\u00a0np.sqrt(x)", "", "y\u00a0= 3 × 2"]
    message = messages.syntax_error("invalid non-printable character U+00A0", "return\ufffdnp.sqrt(x)", 4, lines)
    assert "Lignes 4, 6 : une espace insécable (U+00A0) est à remplacer par une espace" in message
    assert "Ligne 6 : « × » (un signe de multiplication, U+00D7) est à remplacer par *" in message
    assert "return⟦U+00A0⟧np.sqrt(x)" in message
    assert "effacer" not in message


def test_another_syntax_error_is_not_blamed_on_a_character() -> None:
    assert "remplacer" not in messages.syntax_error("expected ':'", "def f()", 1, ["def f()", "    return\u00a01"])
    assert "lettre latine « e »" in messages.syntax_error("invalid syntax", "dеf f():", 1, ["dеf f():", "    return 1"])


def test_names_of_other_alphabets_have_a_latin_spelling() -> None:
    assert latin_spelling("роsе") == "pose"
    assert latin_spelling("x\ufe0f") == "x"
    for name in ("theta", "θ", "π", "été", "ﬁn", "Δ"):
        assert latin_spelling(name) is None
    assert show_foreign_characters("a\u200b = 1") == "a⟦U+200B⟧ = 1"


def test_a_long_or_hostile_text_costs_little() -> None:
    text = ["\u00a0" * 60_000, "(" * 20_000 + "\u00a0", "“" * 3000]
    assert len(find_foreign_characters(text)) == 400
    assert describe_foreign_characters(find_foreign_characters(text))
