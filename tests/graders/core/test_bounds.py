"""However heavy what a submission gives, its verdict has a bound, and says what it leaves out."""

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graders.core.compare import words as render
from graders.core.contract.bounds import VERDICT_BYTES, json_size, limit_size
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Counterexample, Verdict

HUGE: dict[str, Any] = {
    "key": {"k" * 1_000_000: 1},
    "keys": {f"{n}" * 60: n for n in range(3000)},
    "rows": [[0.1234] * 400] * 400,
    "deep": [[[[[[1.5] * 9] * 9] * 9] * 9] * 9] * 9,
    "dictionaries": {str(n): {str(m): m for m in range(60)} for n in range(60)},
    "integers": [2**4000 + n for n in range(3000)],
    "texts": ["é" * 1000] * 3000,
    "arrays": [np.zeros(300)] * 300,
    "array": np.zeros(1_000_000),
}


@pytest.mark.parametrize("value", HUGE.values(), ids=HUGE.keys())
def test_a_value_is_written_within_bounds_and_says_that_it_is_cut(value: Any) -> None:
    written = json.dumps(render.to_jsonable(value), ensure_ascii=False)
    assert len(written) < 2 * render.MAX_CHARACTERS + 30 * render.LEVELS * render.MAX_ITEMS
    assert "…" in written or "premiers" in written
    assert len(render.text(value)) <= render.MAX_LINE
    assert render.to_complete_jsonable(value, limit=400) is None


def test_a_table_is_not_read_in_a_sentence() -> None:
    assert len(render.text([[0.5] * 13] * 13)) > 1000
    assert render.text([[0.5] * 30] * 30) == f"[[{' ; '.join(['0,5'] * 30)}] ; [{' ; '.join(['0,5'] * 8)} ; …] ; …]"


def test_what_is_small_is_written_whole() -> None:
    value = {"graphe": [(0, 1, np.eye(3)), (1, 2, np.eye(3))], "seuil": 0.5, "nom": "boucle"}
    assert render.to_complete_jsonable(value, limit=400) == render.to_jsonable(value)
    assert "…" not in json.dumps(render.to_jsonable(value)) + render.text(value)


def judgement(messages: list[str], values: list[Any], stdout: str = "", figures: tuple[Any, ...] = ()) -> Judgement:
    drawn = {f"c{n}": {"kind": "any", "data": data} for n, data in enumerate(figures)}
    checks = [
        CheckResult(
            id=f"c{n}", title="T", passed=False, points=0, max_points=1, message=message,
            counterexample=Counterexample({"x": 1}, 2, value), figure=f"c{n}" if f"c{n}" in drawn else None,
        )
        for n, (message, value) in enumerate(zip(messages, values, strict=True))
    ]  # fmt: skip
    return Judgement(Verdict("m/a", "1", Outcome.WRONG_ANSWER, 7, checks, stdout=stdout), drawn)


def total(one: Judgement) -> int:
    return json_size(one.verdict.to_json()) + json_size(one.figures)


def test_a_light_verdict_is_the_same() -> None:
    light = judgement(["Non."], [[1.0, 2.0]], "vu", ([0.5],))
    assert limit_size(light) is light


def test_the_heavy_parts_are_cut_and_the_light_ones_are_whole() -> None:
    heavy = judgement(
        ["Petit.", "m" * 300_000, "Dessin."], [[1.5], ["x" * 400] * 1000, 3], "\x01" * 65536, ([0], [1], [0.1] * 90000)
    )
    kept = limit_size(heavy)
    first, second, third = kept.verdict.checks
    assert total(kept) <= VERDICT_BYTES
    assert (first, kept.figures["c0"]) == (heavy.verdict.checks[0], heavy.figures["c0"])
    assert second.message.startswith("m" * 10_000)
    assert "coupé ici : 300000 caractères en tout" in second.message
    assert second.counterexample is not None
    assert "trop longue" in second.counterexample.got
    assert (third.figure, "c2" in kept.figures) == (None, False)
    assert third.message == "Dessin. Le dessin de ce cas serait trop volumineux : il n’est pas montré."
    assert "coupé ici : 65536 caractères en tout" in kept.verdict.stdout
    assert kept.verdict.points == heavy.verdict.points
    assert Verdict.from_json(json.loads(json.dumps(kept.verdict.to_json()))) == kept.verdict


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.text(max_size=40), st.integers(0, 400), st.booleans()), min_size=1, max_size=12),
    st.text(max_size=40),
    st.integers(6000, 40_000),
)
def test_any_verdict_comes_within_its_bound(parts: list[tuple[str, int, bool]], printed: str, most: int) -> None:
    one = judgement(
        [text * times for text, times, _ in parts],
        [[text] * times for text, times, _ in parts],
        printed * 50,
        tuple([text] * times for text, times, drawn in parts if drawn),
    )
    kept = limit_size(one, most)
    assert total(kept) <= max(most, 450 * (3 * len(parts) + 1))
    assert limit_size(kept, total(kept)) is kept
