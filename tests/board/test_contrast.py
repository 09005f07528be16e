"""A wrong and a right program side by side: the most alike, with the proven line and what replaces it."""

from __future__ import annotations

from server.board.contrast import Contrast, Extract, contrast_with_most_alike, extract_lines
from server.board.extracts import folded_name_words
from server.board.latest_change import LatestChange, find_change_between

WRONG = '''import numpy as np

def composer(a, b):
    """De Ada Lovelace,
    en deux lignes."""
    x = a - b  # Ada

    ada = x
    return ada
'''
RIGHT = WRONG.replace("a - b", "a + b")
FAR = "def composer(*poses):\n    while True:\n        for pose in poses:\n            yield from map(float, pose)\n"
PEOPLE = folded_name_words(["Ada Lovelace"])


def extract(code: str) -> Extract:
    return extract_lines(code, ["composer"], PEOPLE)


def marked(contrast: Contrast) -> tuple[list[str], list[str]]:
    return [line.text for line in contrast.wrong if line.marked], [line.text for line in contrast.right if line.marked]


def test_lines_keep_their_numbers_in_the_whole_program() -> None:
    assert extract(WRONG).lines == (
        (3, "def composer(a, b):"),
        (6, "    x = a - b"),
        (8, "    nom = x"),
        (9, "    return nom"),
    )


def test_the_proven_line_and_its_replacement_are_marked() -> None:
    contrast = contrast_with_most_alike(extract(WRONG), 6, [extract(FAR), extract(RIGHT)])
    assert marked(contrast) == (["    x = a - b"], ["    x = a + b"])


def test_nothing_is_marked_without_proof_nor_shown_that_is_too_far() -> None:
    other = RIGHT.replace("x =", "y =").replace("ada = x", "z = y").replace("return ada", "return z")
    contrast = contrast_with_most_alike(extract(WRONG), None, [extract(other)])
    assert contrast.right
    assert marked(contrast) == ([], []), "which of three lines is wrong is not known"
    only = contrast_with_most_alike(extract(WRONG), None, [extract(RIGHT)])
    assert marked(only) == (["    x = a - b"], ["    x = a + b"]), "the only line that differs is the wrong one"
    assert contrast_with_most_alike(extract(WRONG), 6, [extract(FAR)]).right == ()
    assert contrast_with_most_alike(extract(WRONG), 6, []).right == ()


def test_the_latest_change_is_its_first_line_and_a_count() -> None:
    after = WRONG.replace("a - b", "b - a").replace("return ada", "return -ada")
    assert find_change_between(WRONG.encode(), after.encode(), is_code=True) == LatestChange(
        6, "x = a - b  # Ada", "x = b - a  # Ada", 1
    )
    assert find_change_between(WRONG.encode(), WRONG.replace("\n\n", "\n \n").encode(), is_code=True) is None
    assert find_change_between(b'{"a": 1, "b": 2}', b'{"a": 1, "b": 3}', is_code=False) == LatestChange(None, "", "", 1)
    assert find_change_between(b"{", b"{}", is_code=False) is None


def test_the_latest_change_of_long_lines_shows_their_difference() -> None:
    long = "    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])"
    change = find_change_between(long.encode(), long.replace("a[2] + b", "ramener(a[2]) + b").encode(), is_code=True)
    assert change is not None
    assert max(len(change.before), len(change.after)) <= 60
    assert "a[2] + b[2]])" in change.before
    assert "ramener(a[2]) + b[2]])" in change.after
    moved = find_change_between(b"for k in a:\n    total += k\n    return total", WITHOUT_LOOP, is_code=True)
    assert moved == LatestChange(3, "    return total", "return total", 0), "an indentation is a change too"


WITHOUT_LOOP = b"for k in a:\n    total += k\nreturn total"
