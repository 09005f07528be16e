"""Names are held against the answers to all probes of a function, and three at once against the program."""

from __future__ import annotations

import pytest

from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import LIKELY
from tests.support.shipped import CODE


def titles(exercise: str, *edits: tuple[str, str]) -> tuple[str, ...]:
    source = CODE[exercise].solution
    for old, new in edits:
        assert old in source
        source = source.replace(old, new)
    diagnosis = CODE[exercise].grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert diagnosis is not None
    return diagnosis.titles


def test_a_mistake_that_other_probes_would_have_shown_is_not_named() -> None:
    """Of two mistakes in one line no mutant is made: a third answers alike where little is read."""
    returned = "return R @ np.array(R0).T, t - R @ np.array(R0).T @ np.array(t0), erreurs[-1]"
    assert titles("l20/icp", ("return R, t, erreurs", returned)) == (
        "Le départ manque dans le résultat",
        "Une seule erreur est renvoyée, et non la suite",
    )


@pytest.mark.parametrize("wrapped", ["(angle + np.pi) % (2 * np.pi)", "(angle + np.pi / 2) % np.pi - np.pi / 2"])
def test_three_mistakes_are_no_fact_where_two_may_answer_alike(wrapped: str) -> None:
    """Exchanged poses and a wrong angle: all pairs are tried after the verdict only."""
    shown = titles(
        "l20/poses",
        ("np.pi - (np.pi - angle) % (2 * np.pi)", wrapped),
        ("xa, ya, ta = a\n    xb, yb, tb = b", "xa, ya, ta = b\n    xb, yb, tb = a"),
    )
    assert len(shown) < 3 or all(title.lower().startswith(LIKELY.lower()) for title in shown)
