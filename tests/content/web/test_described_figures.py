"""What the figures of verdicts show, in words: each kind that an exercise draws has its text, which the page gives."""

from __future__ import annotations

import importlib
import re

import pytest

from graders.plotting import DECLARED
from server.base.files import ROOT
from server.course.drawings import describe_verdict_figures

LEAST = 40
EXERCISES = sorted(
    "/".join(path.parts[-3:-1]) for path in ROOT.glob("graders/l[0-9]*/*/figures.py")
)  # fmt: skip
FRENCH = re.compile(r"\b(le|la|les|des|en|une?)\b")
COLOURS = re.compile(r"bleu|orange|couleur|clair|noir")


@pytest.mark.parametrize("exercise", EXERCISES)
def test_each_kind_of_figure_says_what_it_shows(exercise: str) -> None:
    described = describe_verdict_figures(exercise)
    own = importlib.import_module(f"graders.{exercise.replace('/', '.')}.figures").FIGURES
    declared = importlib.import_module(DECLARED).FIGURES
    assert described == {kind: words for kind, (_, words) in {**declared, **own}.items()}
    assert len(set(described.values())) == len(described)
    for words in described.values():
        assert len(words) >= LEAST
        assert words.endswith(".")
        assert FRENCH.search(words)
        assert COLOURS.search(words)
