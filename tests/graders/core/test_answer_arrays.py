"""Answers compared at once are compared as one by one."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from graders.core.code.answer_arrays import AnswerColumn, AnswerSequence
from graders.core.code.probes import ProbeFault, same_probe_answer

ANSWERS: list[Any] = [
    *(1.0, 1, True, 1.0 + 1e-8, 1.0 + 1e-6, float("nan"), float("inf"), -float("inf"), 10**400, 1 + 0j, 1j),
    *(None, "un", "", ProbeFault("ValueError"), ProbeFault("TypeError"), {"x": 1.0}, {"x": 2.0}),
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
        same = same_probe_answer(one, other)
        assert AnswerSequence([one]).compare_answers(AnswerSequence([other])) == [same], (one, other)
        assert AnswerColumn([one]).indices_of(other) == ([0] if same else []), (one, other)


def test_many_answers() -> None:
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(60):
        shapes = [(), (3,), (2, 2)] * 2
        answers = [rng.integers(0, 2, shape) + 0.0 for shape in shapes]
        others = [one + rng.choice([0.0, 1e-9, 1.0], p=[0.4, 0.3, 0.3]) for one in answers]
        wanted = [same_probe_answer(*pair) for pair in zip(answers, others, strict=True)]
        assert AnswerSequence(answers).compare_answers(AnswerSequence(others)) == wanted
        seen.update(wanted)
    assert seen == {True, False}
    column = [ANSWERS[k] for k in rng.integers(0, len(ANSWERS), 80)]
    for other in ANSWERS:
        assert AnswerColumn(column).indices_of(other) == [
            k for k, one in enumerate(column) if same_probe_answer(one, other)
        ]
