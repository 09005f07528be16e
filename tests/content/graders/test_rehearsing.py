"""What a grader grades before the first submission: a right program and a wrong one, unless these take long."""

from __future__ import annotations

import pytest

from graders.core.code.grading import CodeGrader
from tests.support.shipped import CODE


@pytest.mark.parametrize("name", ["l20/poses", "l20/mcl", "l20/tp_slam"])
def test_what_is_rehearsed_is_what_the_first_grading_would_pay_for(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    grader, graded = CODE[name], list[str]()
    monkeypatch.setattr(CodeGrader, "grade", lambda _self, source, *_, **__: graded.append(source.decode()))
    grader.warm_up()
    mistake = grader.misconceptions[0].source
    assert graded == ([] if grader.long else [mistake] if grader.heavy else [grader.solution, mistake])


def test_few_are_spared() -> None:
    assert {name for name, grader in CODE.items() if grader.long} == {"l20/tp_slam"}
    assert {name for name, grader in CODE.items() if grader.heavy} == {"l20/mcl", "l20/defi_kidnappe"}
