"""What the tests of graders ask of a program and read in its verdict."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from graders.core.code.grading import CodeGrader
from graders.core.code.prober import Prober
from graders.core.compare.shrinking import Budget
from graders.core.contract.findings import Judgement
from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import Verdict
from tests.support.shipped import CODE


def judgement_of(exercise: str, source: str, seed: int) -> Judgement:
    """What comes of a program of ours, run in this process: its verdict, and what its figures show."""
    return CODE[exercise].grade(source.encode(), LOCAL, seed=seed, version="v")


def verdict_of(exercise: str, source: str, seed: int) -> Verdict:
    """The verdict of a program of ours, run in this process."""
    return judgement_of(exercise, source, seed).verdict


def plain_verdict_of(exercise: str, source: str, seed: int) -> Verdict:
    """The same with its counterexamples as they are found, for tests that look at what failed and at the name."""
    return _unsimplified(exercise).grade(source.encode(), LOCAL, seed=seed, version="v").verdict


def checked(exercise: str, source: str, seed: int, *, simplified: bool = False) -> Judgement:
    """What the checks alone find: no mistake is named, and counterexamples are left as they are found or `simplified`.

    To name a program that is like no known one, hundreds of mutants are asked first; a test that does not look at the
    name does not wait for them.
    """
    return _unnamed(exercise, simplified).grade(source.encode(), LOCAL, seed=seed, version="v")


def checked_verdict_of(exercise: str, source: str, seed: int, *, simplified: bool = False) -> Verdict:
    """The verdict of the checks alone, as of `checked`, for tests that look at what failed."""
    return checked(exercise, source, seed, simplified=simplified).verdict


@cache
def _unsimplified(exercise: str) -> CodeGrader:
    return replace(CODE[exercise], budget=Budget(calls=0))


@cache
def _unnamed(exercise: str, simplified: bool) -> CodeGrader:
    grader = CODE[exercise] if simplified else _unsimplified(exercise)
    return replace(grader, prober=None, misconceptions=())


def knowing(exercise: str, *mistakes: str) -> CodeGrader:
    """The grader of an exercise whose model knows these mistakes alone: hundreds of others need not be undone first."""
    grader = CODE[exercise]
    assert grader.prober is not None
    model = grader.prober.model
    edits = tuple(edit for edit in model.edits if edit.id in mistakes)
    return replace(grader, prober=Prober(replace(model, edits=edits), grader.prober.probes))


def model_with(exercise: str, *changes: str) -> str:
    """The model program of an exercise, some texts of which are replaced: each old one, which it holds once, before its
    new one."""
    prober = CODE[exercise].prober
    assert prober is not None
    text = prober.model.text
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def failed(found: Verdict) -> set[str]:
    """The ids of the checks that failed."""
    return {check.id for check in found.checks if not check.passed}


def named(found: Verdict) -> str | None:
    """The name given to the mistake, if any."""
    return found.diagnosis.id if found.diagnosis else None
