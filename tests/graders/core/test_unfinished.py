"""A known mistake that never ends, or takes all memory, costs the verdict nothing, and is said to its author."""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from graders.core.code import confined
from graders.core.code.checks import Cases
from graders.core.code.confined import HelperProcessError, HelperProcessWork, UnfinishedAnswer
from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from graders.core.code.mutations import Edit, Model
from graders.core.code.prober import Prober
from graders.core.code.probes import Probes
from graders.core.compare.comparison import CloseTo
from graders.core.contract.local import LOCAL
from graders.l20 import world

SOLUTION = "def fib(n):\n    a, b = 0, 1\n    for _ in range(int(n)):\n        a, b = b, a + b\n    return float(a)\n"
OFF_BY_ONE = (
    "def fib(n):\n    a, b = 0, 1\n    for _ in range(int(n) - 1):\n        a, b = b, a + b\n    return float(a)\n"
)
NAIVE = "def fib(n):\n    return n if n < 2 else fib(n - 1) + fib(n - 2)\n"
ENDLESS = {
    "récursion naïve": NAIVE,
    "boucle": "def fib(n):\n    while n > 5:\n        pass\n    return n\n",
    "boucle de numpy": "def fib(n):\n    while n > 5:\n        np.sort(np.ones(10**6))\n    return n\n",
    "puissance": "def fib(n):\n    return n if n < 5 else 10**10**9\n",
    "mémoire": "def fib(n):\n    kept = []\n    while n > 5:\n        kept.append(bytes(10**6))\n    return n\n",
    "tableau": "def fib(n):\n    return n if n < 5 else float(np.ones(2**31).sum())\n",
    "interception": "def fib(n):\n    while True:\n        try:\n            while n > 5:\n                pass\n"
    "            return n\n        except BaseException:\n            pass\n",
    "fichier": "while True:\n    pass\n",
    "arrêt": "import os\n\ndef fib(n):\n    os.kill(os.getpid(), 9)\n",
}  # fmt: skip


def stop_helpers() -> None:
    while confined._IDLE:
        confined._IDLE.pop().stop()


@pytest.fixture(autouse=True)
def short_time(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(confined, "CPU_SECONDS", 0.1)
    stop_helpers()  # forked with the usual time
    yield
    stop_helpers()


def mistake(name: str, source: str) -> Misconception:
    return Misconception(name, ("fib",), name, "explication", "question ?", source)


def solved(n: Any) -> Any:
    return LOCAL.open(SOLUTION.encode(), world.STILL).call("fib", n).value


def grader(*mistakes: Misconception, **given: Any) -> CodeGrader:
    check = Cases(
        id="fib", title="fib", points=20, functions=("fib",), hint="?", names=("n",),
        cases=lambda rng: [(1.0,), (3.0,), (80.0,)], expected=solved, compare=CloseTo(),
    )  # fmt: skip
    return CodeGrader("l20/jouet", Path(), ("fib",), (check,), world.kit, mistakes, SOLUTION, **given)


def grade(code: CodeGrader, source: str) -> Any:
    return code.grade(source.encode(), LOCAL, seed=3, version="v").verdict


@pytest.mark.parametrize("name", ENDLESS)
def test_an_endless_mistake_is_left_out_and_the_others_are_named(name: str) -> None:
    code = grader(mistake("sans_fin", ENDLESS[name]), mistake("un_de_moins", OFF_BY_ONE))
    first = grade(code, OFF_BY_ONE)
    assert (first.outcome.value, first.diagnosis.id) == ("wrong_answer", "un_de_moins")
    assert grade(code, SOLUTION).points == 20
    wrong = grade(code, "def fib(n):\n    return n + 0.5\n")
    assert (wrong.points, wrong.diagnosis) == (0, None), "no wrong name instead"


def test_warming_up_finds_it_before_the_first_submission(monkeypatch: pytest.MonkeyPatch) -> None:
    code = grader(mistake("sans_fin", NAIVE), mistake("un_de_moins", OFF_BY_ONE))
    code.warm_up()
    asked: list[Any] = []
    real = HelperProcessWork.answer_each
    monkeypatch.setattr(
        HelperProcessWork, "answer_each", lambda self, items, *a, **k: asked.append(items) or real(self, items, *a, **k)
    )
    assert grade(code, OFF_BY_ONE).diagnosis.id == "un_de_moins"
    assert asked == [[1]], "the endless one is not run again"


@pytest.mark.parametrize(
    ("name", "reason"),
    [("récursion naïve", "ne finit pas"), ("mémoire", "prend trop de mémoire"), ("fichier", "ne finit pas")],
)
def test_its_author_is_told_which_on_which_input(name: str, reason: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if name == "mémoire":
        monkeypatch.setattr(confined, "CPU_SECONDS", 60.0)  # its memory ends it, however long a page takes
    ((found, unfinished),) = grader(mistake("sans_fin", ENDLESS[name])).unfinished_mistakes(seed=1)
    assert found.id == "sans_fin"
    assert reason in unfinished.reason
    assert unfinished.last_report == ("le chargement du fichier" if name == "fichier" else "fib(80)")


def probed(*edits: Edit) -> CodeGrader:
    model = Model(SOLUTION, edits)
    prober = Prober(model, [Probes(function="fib", calls=((1.0,), (4.0,), (30.0,)), kit=world.STILL)])
    mistakes = [replace(mistake(edit.id, str(edit.apply(SOLUTION))), edited=True) for edit in edits]
    return grader(*mistakes, prober=prober)


def test_an_endless_mutant_is_left_out_too() -> None:
    code = probed(
        Edit("sans_fin", (("for _ in range(int(n)):", "while n > 20 or a < n:"),), frozenset({"fib"})),
        Edit("un_de_moins", (("int(n)", "int(n) - 1"),), frozenset({"fib"})),
    )
    assert grade(code, OFF_BY_ONE).diagnosis.id == "un_de_moins"
    assert grade(code, OFF_BY_ONE).diagnosis.id == "un_de_moins"
    ((found, unfinished),) = code.unfinished_mistakes(seed=1)
    assert (found.id, unfinished.last_report) == ("sans_fin", "fib(30)")


def test_answers_made_before_a_fault_are_given_and_those_after_it() -> None:
    def handle(items: Any, context: Any) -> Any:
        for item in items:
            if item == "mort":
                os._exit(1)
            yield item, context, os.getpid() == owner

    owner = os.getpid()
    work = HelperProcessWork(handle)
    items = [1, "mort", 2, 3, "mort", "mort", 4]
    answers = list(work.answer_each(items, "c"))
    assert [answer if isinstance(answer, UnfinishedAnswer) else answer[0] for answer in answers[::2]] == [
        1,
        2,
        answers[4],
        4,
    ]
    assert [k for k, answer in enumerate(answers) if isinstance(answer, UnfinishedAnswer)] == [1, 4, 5]
    assert answers[0] == (1, "c", False)


def test_an_error_of_the_handler_is_ours() -> None:
    def handle(items: Any, context: Any) -> Any:
        yield 1 / 0

    with pytest.raises(HelperProcessError, match="ZeroDivisionError"):
        list(HelperProcessWork(handle).answer_each([1]))


def test_a_helper_ends_with_the_one_who_has_it() -> None:
    work = HelperProcessWork(lambda items, context: iter([os.getpid()]))
    (pid,) = work.answer_each([1])
    (helper,) = confined._IDLE
    helper._channel.close()
    assert os.waitpid(pid, 0)[1] == 0
    confined._IDLE.clear()


def test_a_sleeping_program_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(confined, "ASLEEP_SECONDS", 0.3)
    work = HelperProcessWork(lambda items, context: iter(lambda: time.sleep(1000), 0))
    ((answer),) = work.answer_each([1])
    assert answer.reason == "attend sans rien calculer"


def test_a_work_may_vanish_while_a_helper_is_forked() -> None:
    """Another thread may let go of a work at any moment: here when the number of the work before it is looked up."""

    class Number(int):
        def __hash__(self) -> int:
            works.clear()
            return int(self)

    works: list[HelperProcessWork] = []
    first, second = HelperProcessWork(_no_answer), HelperProcessWork(_no_answer)
    number = second.number + 10**9
    confined._WORKS[Number(number)] = first
    confined._WORKS[number + 1] = confined._WORKS.pop(second.number)
    works.append(second)
    del second
    helper = confined._HelperProcess()
    helper.stop()
    assert helper.has_work(first.number)


def _no_answer(items: Sequence[Any], context: Any) -> Iterator[Any]:
    return iter(())
