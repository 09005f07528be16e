"""Answers compared at once are compared as one by one."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from graders.core.code.packed import Column, Packed
from graders.core.code.probes import Fault, same_seen

ANSWERS: list[Any] = [
    *(1.0, 1, True, 1.0 + 1e-8, 1.0 + 1e-6, float("nan"), float("inf"), -float("inf"), 10**400, 1 + 0j, 1j),
    *(None, "un", "", Fault("ValueError"), Fault("TypeError"), {"x": 1.0}, {"x": 2.0}),
    *(
        [1.0, 2.0],
        (1.0, 2.0 + 1e-9),
        np.array([1.0, 2.0]),
        np.array([[1.0, 2.0]]),
        np.array([1.0, np.nan]),
        [1.0, "un"],
    ),
    *([], np.zeros(0), [[1.0], [1.0, 2.0]], (np.eye(2), np.ones(2)), (np.eye(2), np.ones(2) + 1e-9), (np.eye(2), None)),
]


def test_each_pair_of_answers() -> None:
    for one, other in itertools.product(ANSWERS, ANSWERS):
        same = same_seen(one, other)
        assert Packed([one]).agreeing(Packed([other])) == [same], (one, other)
        assert Column([one]).same_as(other) == ([0] if same else []), (one, other)


def test_many_answers() -> None:
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(60):
        shapes = [(), (3,), (2, 2)] * 2
        answers = [rng.integers(0, 2, shape) + 0.0 for shape in shapes]
        others = [one + rng.choice([0.0, 1e-9, 1.0], p=[0.4, 0.3, 0.3]) for one in answers]
        wanted = [same_seen(*pair) for pair in zip(answers, others, strict=True)]
        assert Packed(answers).agreeing(Packed(others)) == wanted
        seen.update(wanted)
    assert seen == {True, False}
    column = [ANSWERS[k] for k in rng.integers(0, len(ANSWERS), 80)]
    for other in ANSWERS:
        assert Column(column).same_as(other) == [k for k, one in enumerate(column) if same_seen(one, other)]
