"""What a tracer tells of honest programs, as a page gets it: the state before each line, and how it ended."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from server.sandbox import Kit, ProgramFault, Sandbox, SandboxFault
from server.sandbox.values import LibraryFile
from server.steps import run
from server.steps.questions import CellTraceRequest, TraceQuestion
from server.steps.schemas import EndOut, StepOut
from server.steps.trace_reader import TraceReader

POLICY = replace(run.POLICY, memory_bytes=128 << 20)


def followed(
    sandbox: Sandbox, source: str, function: str | None = "f", *args: Any, kit: Kit | None = None, **named: Any
) -> tuple[TraceReader, EndOut, str]:
    """What was told, how it ended, what was printed."""
    waits = function is None
    told = TraceReader(len(source.split("\n")))
    with sandbox.open(source.encode(), kit=kit, policy=POLICY, deferred=waits, echo_last=waits) as session:
        end, _ = run.read_trace_result(told, session.trace(function, *args, named=named), shows_value=not waits)
    return told, end, session.stdout()


def lines(told: TraceReader) -> list[tuple[str, int]]:
    return [(step.event, step.line) for step in told.steps]


def written(value: Any) -> Any:
    """A shown value as Python would hold it, its numbers as texts."""
    kinds = {
        "none": lambda: None,
        "bool": lambda: value.value,
        "number": lambda: value.text,
        "text": lambda: repr(value.text),
        "sequence": lambda: [written(item) for item in value.items],
        "mapping": lambda: {written(key): written(item) for key, item in value.items},
        "array": lambda: (value.shape, value.values),
        "other": lambda: f"<{value.type} {value.name}>",
    }
    return kinds[value.kind]()


def changed(step: StepOut) -> dict[str, Any]:
    return {change.name: written(change.value) for change in step.changes}


def test_each_step_is_the_state_before_its_line(sandbox: Sandbox) -> None:
    told, end, _ = followed(
        sandbox, "def f(n):\n    t = 0\n    for k in range(n):\n        t += k\n    return t\n", "f", 3
    )
    assert [(step.line, changed(step)) for step in told.steps if step.changes or step.event != "line"] == [
        (1, {"n": "3"}),
        (3, {"t": "0"}),
        (4, {"k": "0"}),
        (4, {"k": "1"}),
        (3, {"t": "1"}),
        (4, {"k": "2"}),
        (3, {"t": "3"}),
        (5, {}),
    ]
    assert lines(told)[:3] == [("call", 1), ("line", 2), ("line", 3)]
    assert lines(told)[-2:] == [("line", 5), ("return", 5)]
    assert (end.kind, written(end.value), written(told.steps[-1].value)) == ("returned", "3", "3")
    assert [change.new for step in told.steps for change in step.changes if change.name == "t"] == [True, False, False]


def test_calls_are_told_with_who_made_them(sandbox: Sandbox) -> None:
    source = (
        "def g(x):\n    return x\ndef h(x):\n    return g(x) + [g(k) for k in (1, 2)][0]\n"
        "def f():\n    return max([h(1), 0], key=lambda x: g(x))\n"
    )
    told, _, _ = followed(sandbox, source)
    names = [(frame.function, frame.parent, frame.depth) for frame in told.frames]
    assert names == [
        ("f", None, 0),
        ("h", 0, 1),
        *[("g", 1, 2)] * 3,
        *[("<lambda>", 0, 1), ("g", 5, 2)],
        *[("<lambda>", 0, 1), ("g", 7, 2)],
    ]


def test_a_change_through_another_name_is_seen_and_the_same_object_is_told(sandbox: Sandbox) -> None:
    source = (
        "import numpy as np\ndef f(M):\n    a = [1, 2]\n    b = a\n    V = M[0]\n    b.append(3)\n    V[1] = 7.0\n"
        "    W = M\n    a = list(a)\n    del V\n    return M\n"
    )
    told, _, _ = followed(sandbox, source, "f", np.zeros((2, 2)))
    at = {step.line: step for step in told.steps if step.event == "line"}
    assert changed(at[7]) == {"a": ["1", "2", "3"], "b": ["1", "2", "3"]}
    assert changed(at[8]) == {"M": ([2, 2], ["0.0", "7.0", "0.0", "0.0"]), "V": ([2], ["0.0", "7.0"])}
    assert [change.entries for change in at[8].changes] == [[1], [1]]
    alias = {change.name: change.value.alias for step in told.steps for change in step.changes}  # type: ignore[union-attr]
    assert alias["W"] == alias["M"] != alias["V"]
    assert alias["a"] != alias["b"]
    assert [step.gone for step in told.steps if step.gone] == [["V"]]


def test_a_number_of_another_type_is_a_change(sandbox: Sandbox) -> None:
    source = (
        "import numpy as np\ndef f():\n    x = 1\n    x = 1.0\n    x = True\n    x = float('nan')\n"
        "    x = float('nan')\n    x = np.float32(0.1)\n    L = [1]\n"
        "    L[0] = 1.0\n    L[0] = 1.0\n    x = 1 << 5000\n    return x\n"
    )
    told, _, _ = followed(sandbox, source)
    values = [(change.name, written(change.value)) for step in told.steps for change in step.changes]
    assert values == [
        *[("x", "1"), ("x", "1.0"), ("x", True), ("x", "nan"), ("x", "0.1")],
        *[("L", ["1"]), ("L", ["1.0"]), ("x", "environ 10^1505")],
    ]


def test_large_arrays_are_cut_and_a_change_beyond_is_seen(sandbox: Sandbox) -> None:
    source = (
        "import numpy as np\ndef f():\n    M = np.zeros((100, 100))\n    M[99, 99] = 1\n    M[0, 3] = 2\n    return 0\n"
    )
    told, _, _ = followed(sandbox, source)
    changes = [change for step in told.steps for change in step.changes]
    assert [(change.value.cut, len(change.value.values)) for change in changes] == [(True, 400)] * 3  # type: ignore[union-attr]
    assert [change.entries for change in changes] == [[], [], [3]]


def test_an_exception_is_told_where_it_passes(sandbox: Sandbox) -> None:
    source = (
        "def g(x):\n    return 1 / x\n"
        "def f():\n    try:\n        g(0)\n    except ZeroDivisionError:\n        pass\n    {}['a']\n"
    )
    told, end, _ = followed(sandbox, source)
    raised = [(step.frame, step.line, step.words) for step in told.steps if step.event == "exception"]
    assert raised == [
        *[(1, 2, "ZeroDivisionError\u00a0: division by zero"), (0, 5, "ZeroDivisionError\u00a0: division by zero")],
        (0, 8, "KeyError\u00a0: a"),
    ]
    assert not [step for step in told.steps if step.event == "return"]
    assert (end.kind, end.title, end.line) == ("fault", "Erreur à l’exécution", 8)


def test_a_generator_goes_on_where_it_was(sandbox: Sandbox) -> None:
    source = "def g():\n    k = 1\n    yield k\n    k = 2\n    yield k\ndef f():\n    return list(zip(g(), g()))\n"
    told, _, _ = followed(sandbox, source)
    assert [frame.function for frame in told.frames] == ["f", "g", "g"]
    yielded = [(step.frame, written(step.value)) for step in told.steps if step.event == "return"]
    assert yielded[:4] == [(1, "1"), (2, "1"), (1, "2"), (2, "2")]


def test_a_cell_is_followed_at_its_top_level_without_what_the_kit_gives(sandbox: Sandbox, kit: Kit) -> None:
    source = "x = PORTEE_MAX\nnp = 3\ndef carre(n):\n    return n * n\nfor k in range(2):\n    x += carre(k)\nx"
    told, end, printed = followed(sandbox, source, None, kit=kit)
    assert [frame.function for frame in told.frames] == ["<module>", "carre", "carre"]
    assert {name for step in told.steps if step.frame == 0 for name in changed(step)} == {"x", "np", "carre", "k"}
    assert changed(told.steps[-1]) == {}
    assert (told.steps[-1].event, end.kind, end.value, printed) == ("return", "returned", None, "8.0\n")


def test_the_last_line_of_a_cell_is_seen_to_change(sandbox: Sandbox) -> None:
    told, _, _ = followed(sandbox, "x = 1\ny = 2\n", None)
    assert [(step.event, step.line, changed(step)) for step in told.steps] == [
        *[("line", 1, {}), ("line", 2, {"x": "1"}), ("return", 2, {"y": "2"})],
    ]


def test_earlier_functions_run_without_being_followed(sandbox: Sandbox) -> None:
    shelf = LibraryFile("poses", ("double",), b"def double(x):\n    return 2 * x\n")
    kit = Kit("trousse", {"seed": 1}, library=(shelf,))
    source = "from mes_fonctions import double\ndef f(x):\n    y = double(x)\n    return y\n"
    told, end, _ = followed(sandbox, source, "f", 4, kit=kit)
    assert (told.omissions, [frame.function for frame in told.frames], written(end.value)) == (["library"], ["f"], "8")


def test_named_arguments_are_passed(sandbox: Sandbox) -> None:
    for name in ("b", "self", "arguments"):
        given: dict[str, Any] = {name: 2}
        _, end, _ = followed(sandbox, f"def f(a, {name}=0):\n    return a - {name}\n", "f", 5, **given)
        assert written(end.value) == "3"


def test_what_is_not_there_or_not_right_is_told_as_in_a_verdict(sandbox: Sandbox) -> None:
    _, end, _ = followed(sandbox, "def fa():\n    pass\n")
    assert "Il contient" in end.message
    with pytest.raises(ProgramFault, match="Ligne 1"):
        followed(sandbox, "def f(:\n", None)
    with sandbox.open(b"def f():\n    pass\n", policy=POLICY) as session:
        session.close()
        with pytest.raises(SandboxFault):
            session.trace("f")


def test_following_takes_nothing_from_the_answers_of_other_calls(sandbox: Sandbox) -> None:
    source = b"import sys\ndef f(n):\n    return n and 1 + f(n - 1)\ndef g():\n    return sys.gettrace() is None\n"
    with sandbox.open(source, policy=POLICY) as session:
        session.trace("f", 3)
        assert session.call("g").value is True
        assert session.call("f", 900).value == 900


def test_a_cell_is_answered_as_its_page_gets_it(sandbox: Sandbox) -> None:
    asked = CellTraceRequest(module="trousse", code="x = rng.integers(10)\nprint('a\\x1b')\n")
    trace, again = (run.trace_question(sandbox, TraceQuestion(steps=asked)) for _ in range(2))
    assert (trace.lines, trace.filename, trace.call) == (
        ["x = rng.integers(10)", "print('a\\x1b')", ""],
        run.CELL,
        "",
    )
    assert (trace.end.kind, trace.stdout, trace.mark) == ("returned", "a␛\n", None)
    assert trace.steps == again.steps
    broken = run.trace_question(sandbox, TraceQuestion(steps=CellTraceRequest(module="trousse", code="x = (")))
    assert (broken.steps, broken.end.kind, broken.end.line) == ([], "fault", 1)
