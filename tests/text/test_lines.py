"""One-line texts: what nobody sees goes, and what stays in the way is named."""

from __future__ import annotations

import time
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.base.errors import Invalid
from server.identity.logins import login_problem, normalise_login
from server.text.lines import (
    MAX_LINE,
    MAX_TEXT,
    describe_forbidden_character,
    normalise_line,
    normalise_lines,
    require_normalised_line,
)

PROBLEM = "Donnez un titre de 1 à 20 caractères."


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("ines@exemple.fr\u200b", "ines@exemple.fr"),
        ("\ufeffPetit", "Petit"),
        ("Tiers-temps\u00a0: PAP", "Tiers-temps : PAP"),
        ("1\u202f000\u2007élèves", "1 000 élèves"),
        ("Chloe\u0301", "Chloé"),
        ("co\u00adopé\u00adra\u00adtion", "coopération"),
        ("\u202eAda\u2066 L\u2069", "Ada L"),
        ("Zoé\u200d\u200c\u034f\ufe0f", "Zoé"),
        ("\u3164", ""),
        ("  a \t b\r\nc ", "a b c"),
    ],
)
def test_what_nobody_sees_goes(typed: str, meant: str) -> None:
    assert normalise_line(typed) == meant


@given(st.text(max_size=30))
def test_a_tidy_line_stays_as_it_is(text: str) -> None:
    line = normalise_line(text)
    assert normalise_line(line) == line
    assert line == line.strip()
    assert not any(unicodedata.category(sign) == "Cf" for sign in line)


def test_lines_stay_lines() -> None:
    assert normalise_lines("\n a\u200b \r\n\r\n b\u00a0c\n") == "a\n\nb c"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Ada\x07", "le 4e caractère, après « Ada », ne s’écrit pas (U+0007, sonnerie)"),
        ("\ue000", "le 1er caractère ne s’écrit pas (U+E000)"),
        ("Chlo\ufffd", "lettre accentuée perdue"),
        ("a\ud800", "(U+D800)"),
    ],
)
def test_the_character_that_stays_in_the_way_is_named(text: str, words: str) -> None:
    assert words in describe_forbidden_character(text)
    with pytest.raises(Invalid) as refused:
        require_normalised_line(text, 20, PROBLEM)
    assert words in refused.value.detail


def test_a_long_or_an_empty_line_is_refused_with_its_bounds() -> None:
    for text in ("", "\u200b\u00a0", "x" * 21):
        with pytest.raises(Invalid) as refused:
            require_normalised_line(text, 20, PROBLEM)
        assert refused.value.detail == PROBLEM
    assert require_normalised_line(f" {'x' * 20}\u200b", 20, PROBLEM) == "x" * 20
    assert describe_forbidden_character("deux\nlignes\t!") == ""


def test_what_is_far_too_long_is_refused_without_being_read_whole() -> None:
    """A letter that Unicode spells with eighteen others: a login of 160,000 of them took seconds."""
    for letter in ("\ufdfa", "é", "\u0130"):
        assert len(normalise_line(letter * 200_000)) <= MAX_LINE
        assert len(normalise_lines(f"{letter}\n" * 200_000)) <= MAX_TEXT
        began = time.process_time()
        assert login_problem(normalise_login(letter * 200_000))
        assert time.process_time() - began < 0.5
