"""What the page of a trace computes: states, moves, loops, numbers and words, held against Python itself."""

from __future__ import annotations

import math
import random
import sys
from types import FrameType
from typing import Any

import pytest

from graders.core.compare import words
from tests.steps.page_scripts import Scripts, number, step, trace

SCRIPTS = Scripts()


def test_the_variables_at_any_step_are_those_of_replaying_all_changes_before_it() -> None:
    chance = random.Random(4)
    names = ["a", "b", "c", "d"]
    steps: list[dict[str, Any]] = []
    expected: list[dict[str, str]] = []
    states: list[dict[str, str]] = [{}, {}]
    for k in range(200):
        frame = chance.randrange(2)
        changes = {name: chance.randrange(9) for name in names if chance.random() < 0.3}
        gone = tuple(name for name in states[frame] if name not in changes and chance.random() < 0.2)
        states[frame].update({name: str(value) for name, value in changes.items()})
        for name in gone:
            del states[frame][name]
        steps.append(step(k % 7 + 1, frame=frame, gone=gone, **changes))
        expected.append(dict(states[frame]))
    data = trace("\n" * 8, steps, parents=(None, 0))
    found = SCRIPTS.value("(() => { const t = new Trace(d); return d.steps.map((_, k) => t.variables(k)); })()", d=data)
    for k, (told, state) in enumerate(zip(found, expected, strict=True)):
        assert {one["name"]: one["value"]["text"] for one in told} == state
        assert {one["name"] for one in told if one["changed"]} == {one["name"] for one in steps[k]["changes"]}


def moves(data: dict[str, Any], expression: str) -> Any:
    return SCRIPTS.value(f"(() => {{ const t = new Trace(d), m = new Moves(t); return {expression}; }})()", d=data)


CALLS = trace(
    "def f0():\n    x = f1()\n    y = f1()\ndef f1():\n    return f2()\ndef f2():\n    return 1",
    [
        step(1, "call"),
        step(2),
        step(4, "call", 1),
        step(5, frame=1),
        step(6, "call", 2),
        step(7, frame=2),
        step(7, "return", 2),
        step(5, "return", 1),
        step(3, x=1),
        step(4, "call", 3),
        step(5, "return", 3),
        step(3, "return", y=1),
    ],
    parents=(None, 0, 1, 0),
)


def test_calls_are_stepped_over_entered_and_left() -> None:
    assert moves(CALLS, "m.open(0)") == [0, 1, 8, 11]
    assert moves(CALLS, "[0, 1, 8, 11].map((k) => m.by(k, 1))") == [1, 8, 11, 11]
    assert moves(CALLS, "[11, 8, 1, 0].map((k) => m.by(k, -1))") == [8, 1, 0, 0]
    assert moves(CALLS, "d.steps.map((_, k) => m.into(k))") == [None, 2, None, 4, *[None] * 4, 9, None, None, None]
    assert moves(CALLS, "[2, 5, 6, 7, 10, 11].map((k) => m.out(k))") == [8, 7, 7, 8, 11, None]
    assert moves(CALLS, "m.open(4)") == [0, 1, 2, 3, 4, 5, 6, 7, 8, 11], "one's own call, and those that led to it"
    assert moves(CALLS, "[m.size(2), m.size(4), m.size(9)]") == [6, 3, 2]
    assert moves(CALLS, "[m.first(), m.last(), t.path(2)]") == [0, 11, [0, 1, 2]]


def test_changes_and_passages_are_found_in_both_directions() -> None:
    data = trace("x = 1\ny = 2", [step(1), step(2, x=1), step(1), step(2, x=2), step(1, x=3, y=1)])
    assert moves(data, "[0, 1, 2, 4].map((k) => m.change(k, 0, 'x', 1))") == [1, 3, 3, None]
    assert moves(data, "[4, 3, 2, 1].map((k) => m.change(k, 0, 'x', -1))") == [3, 1, 1, None]
    assert moves(data, "m.change(0, 0, 'absent', 1)") is None
    assert moves(data, "[m.line(0, 1), m.line(4, 1), m.line(0, 9)]") == [
        {"step": 2, "time": 2, "times": 3},
        {"step": 0, "time": 1, "times": 3},
        None,
    ]


def test_what_a_line_does_is_told_by_its_call_and_not_by_the_calls_that_it_makes() -> None:
    assert moves(CALLS, "[t.executed(8), t.executed(1), t.executed(11)]") == [2, None, 3]
    assert moves(CALLS, "t.effects(1).changes.map((one) => one.name)") == ["x"]


def test_a_trace_without_a_step_has_neither_variables_nor_loops() -> None:
    assert moves(trace("x =", [], parents=()), "[t.length, t.passages(1), new Loops(t).loops]") == [0, [], []]


LOOPS = """
def plain(n):
    total = 0
    for k in range(n):
        total += k
    return total

def nested(n):
    found = []
    for i in range(n):
        # a comment

        j = 0
        while j < i:
            j += 1
            if j == 2:
                continue
            found.append(
                (i,
                 j))
    else:
        found.append(None)
    return found

def over_lines(n):
    for a, b in zip(
        range(n),
        range(n),
    ):
        c = a + b
    return n

def endless(n):
    while True:
        n -= 1
        if n <= 0:
            break
    return n

def left(n):
    for k in range(n):
        if k == 2:
            return k
    return None

def none(n):
    for k in range(0):
        n += 1
    text = \"\"\"
    for k in nothing:
        here
    \"\"\"
    return [k for k in text]
"""


def followed(name: str, n: int) -> dict[str, Any]:
    """A trace of lines alone, by Python's own means."""
    steps: list[dict[str, Any]] = []

    def look(frame: FrameType, event: str, _value: object) -> Any:
        if frame.f_code.co_name == name:
            steps.append(step(frame.f_lineno, event))
        return look if frame.f_code.co_name == name else None

    space: dict[str, Any] = {}
    exec(compile(LOOPS, "loops.py", "exec"), space)
    before = sys.gettrace()
    sys.settrace(look)
    try:
        space[name](n)
    finally:
        sys.settrace(before)
    return trace(LOOPS, steps)


def laps(name: str, n: int) -> dict[int, list[int]]:
    """By line of the header, how many laps each run of that loop has."""
    expression = """(() => {
      const t = new Trace(d), loops = new Loops(t), seen = new Map();
      t.steps.forEach((_, k) => {
        for (const { line, laps } of loops.around(k)) seen.set(`${line} ${laps[0]}`, [line, laps.length]);
      });
      return [...seen.values()];
    })()"""
    found: dict[int, list[int]] = {}
    for line, count in SCRIPTS.value(expression, d=followed(name, n)):
        found.setdefault(line, []).append(count)
    return found


@pytest.mark.parametrize(
    ("name", "n", "expected"),
    [
        ("plain", 5, {4: [5]}),
        ("plain", 0, {}),
        ("nested", 4, {10: [4], 14: [1, 2, 3]}),
        ("over_lines", 3, {26: [3]}),
        ("endless", 3, {34: [3]}),
        ("left", 9, {41: [3]}),
        ("none", 1, {}),
    ],
)
def test_the_laps_of_loops_are_counted(name: str, n: int, expected: dict[int, list[int]]) -> None:
    found = {line: sorted(counts) for line, counts in laps(name, n).items()}
    assert found == expected


def test_one_goes_to_a_lap_and_past_the_loop() -> None:
    data = followed("plain", 3)
    [told] = SCRIPTS.value("new Loops(new Trace(d)).around(4)", d=data)
    assert [data["steps"][k]["line"] for k in told["laps"]] == [5, 5, 5]
    assert told["lap"] == 0
    assert data["steps"][told["after"]]["line"] == 6
    [header] = SCRIPTS.value("new Loops(new Trace(d)).around(2)", d=data)
    assert (header["lap"], len(header["laps"])) == (-1, 3), "at its header, the loop says how many laps it has"


def lapped(source: str, *lines: int) -> list[list[int]]:
    """At each step of these lines: of the loops around it, the line and the laps that are begun."""
    data = trace(source, [step(line) for line in lines])
    expression = """(() => {
      const loops = new Loops(new Trace(d));
      return d.steps.map((_, k) => loops.around(k).map((one) => [one.line, one.lap + 1, one.laps.length]));
    })()"""
    found: list[list[int]] = SCRIPTS.value(expression, d=data)
    return found


def test_an_endless_loop_whose_header_is_not_come_back_to_has_its_laps() -> None:
    source = "while True:\n    n -= 1\n    if n:\n        break\nx = n"
    assert lapped(source, 1, 2, 3, 2, 3, 4, 5) == [[[1, 0, 2]], *[[[1, 1, 2]]] * 2, *[[[1, 2, 2]]] * 3, []]
    nested = "while True:\n    for k in a:\n        n += k\n    n -= 1"
    inner = lapped(nested, 1, 2, 3, 2, 3, 2, 4, 2, 3, 2, 4)
    assert [around[-1] for around in inner] == [[1, 0, 2], *[[1, 1, 2]] * 6, *[[1, 2, 2]] * 4]


def test_a_loop_that_is_left_by_returning_is_over_there() -> None:
    data = followed("left", 9)
    [inside] = SCRIPTS.value("new Loops(new Trace(d)).around(4)", d=data)
    assert data["steps"][inside["after"]]["event"] == "return"


def told(value: float) -> str:
    """What a verdict says of a number, in the signs of the page."""
    text = words.number(value)
    raised = {ord(sign): up for sign, up in zip("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True)}
    before, power, exponent = text.replace("−", "-").partition("10^")
    plain = before.replace("-", "−")
    return plain.replace(" × ", "\u00a0×\u00a0") + ("10" if power else "") + exponent.translate(raised)


def test_numbers_are_written_as_in_a_verdict() -> None:
    chance = random.Random(1)
    some = [0.1, -0.5, 1.0, 1e5, 123456.0, 1234567.0, 1e-4, 1.5e-5, -3e22, math.pi / 2, -2 * math.pi / 3, 5.0, 99999.95]
    some += [chance.uniform(-1, 1) * 10.0 ** chance.randrange(-9, 20) for _ in range(300)]
    found = SCRIPTS.value("texts.map((one) => french(one))", texts=[repr(one) for one in some])
    assert found == [told(one) for one in some]
    whole = [0, 7, -12, 10**14, -(10**14), 10**60]
    found = SCRIPTS.value("texts.map((one) => french(one))", texts=[str(one) for one in whole])
    assert found == ["0", "7", "−12", "1" + 14 * "0", "−1" + 14 * "0", "1\u00a0×\u00a010⁶⁰"]


def test_numbers_beyond_digits_are_named_and_no_small_one_is_called_nothing() -> None:
    said = SCRIPTS.value("texts.map((one) => french(one))", texts=["nan", "inf", "-inf", "(1+2.5j)", "6e-17", "-0.0"])
    assert said == ["nan", "∞", "−∞", "(1+2,5j)", "6\u00a0×\u00a010⁻¹⁷", "0"]
    assert SCRIPTS.value("french(t)", t="9" * 5000) == "environ 10⁴⁹⁹⁹"
    assert SCRIPTS.value("[inArray('6e-17', 1), inArray('6e-17', 1e-16), exact('-6.5e-17'), inArray('1e-12', 1)]") == [
        "≈\u202f0",
        "6\u00a0×\u00a010⁻¹⁷",
        "−6,5e−17",
        "1\u00a0×\u00a010⁻¹²",
    ]


def array(*rows: list[float]) -> dict[str, Any]:
    values = [str(one) for row in rows for one in row]
    return {"kind": "array", "dtype": "float64", "shape": [len(rows), len(rows[0])], "values": values, "cut": False}


def listed(*items: Any, kind: str = "list") -> dict[str, Any]:
    values = [item if isinstance(item, dict) else number(item) for item in items]
    return {"kind": "sequence", "type": kind, "items": values, "length": len(values), "alias": 1}


@pytest.mark.parametrize(
    ("name", "value", "guess"),
    [
        ("P", array([0, 1], [2, 3], [4, 5]), "points"),
        ("R", array([0, 1], [-1, 0]), ""),
        ("particules", array([0, 1, 0.5], [1, 1, 3]), "poses"),
        ("pose", listed(1, 2, 0.5, kind="tuple"), "poses"),
        ("poids", listed(0.2, 0.3, 0.5), ""),
        ("pose", listed(100, 200, 900), ""),
        ("chemin", listed(listed(0, 1), listed(1, 1)), "points"),
        ("t", listed(0.5, 1.5), "points"),
        ("nombres", listed(0.5, 1.5), ""),
    ],
)
def test_what_may_be_drawn_is_offered_and_taken_for_what_its_name_says(name: str, value: Any, guess: str) -> None:
    assert SCRIPTS.value("drawable(n, v).guess", n=name, v=value) == guess


@pytest.mark.parametrize(
    "value",
    [
        number(3),
        listed(),
        listed(1),
        listed(1, 2, 3, 4),
        listed(listed(1, 2), listed(1)),
        listed(1, float("nan")),
        listed(listed(1, 2), 3),
        array([1e300, 1], [2, 3]),
        {"kind": "text", "text": "ab", "length": 2},
        listed(float("inf"), 1),
        {**listed(listed(1, 2), listed(3, 4)), "length": 9},
        {**array([1, 0], [0, 1]), "dtype": "bool", "values": ["True", "False"] * 2},
    ],
)
def test_what_is_no_drawing_is_not_offered_as_one(value: Any) -> None:
    assert SCRIPTS.value("drawable('points', v)", v=value) is None


def test_each_step_is_told_in_a_short_sentence() -> None:
    data = trace(
        "a\nb\nc", [step(1, "call", a=1, b=2), step(2), step(3, x=1, y=2, z=3, u=4, v=5, w=6), step(3, "return")]
    )
    data["steps"][3] |= {"value": number(2.5)}
    say = "(() => { const t = new Trace(d); return d.steps.map((_, k) => sentence(t, k)); })()"
    assert SCRIPTS.value(say, d=data) == [
        "Appel de f0, qui reçoit a et b.",
        "Ligne 2 à exécuter.",
        "Ligne 3 à exécuter ; la ligne 2 change x, y, z, u et 2 autres.",
        "f0 renvoie 2,5.",
    ]
    returned = trace("a", [step(1, "return") | {"value": array([1, 2], [3, 4])}])
    assert SCRIPTS.value(say, d=returned) == ["f0 renvoie un tableau 2\u00a0×\u00a02."]
    failing = trace("a", [step(1, "call"), step(1), {**step(1, "exception"), "words": "ZeroDivisionError : …"}])
    assert SCRIPTS.value(say, d=failing)[-1] == "La ligne 1 échoue : ZeroDivisionError : …"
    lost = trace("a\nb", [step(1, "call", a=1), step(1), step(2, gone=("a",))])
    assert SCRIPTS.value(say, d=lost)[-1] == "Ligne 2 à exécuter. a n’existe plus."


def test_values_are_short_in_a_table() -> None:
    deep = listed(listed(listed(listed(listed(1)))))
    values = [
        {"kind": "none"},
        {"kind": "bool", "value": True},
        listed(1, 2.5, kind="tuple"),
        listed(*range(9)),
        deep,
        array([1, 2], [3, 4]),
        {"kind": "text", "text": "a" * 60, "length": 900},
        {"kind": "mapping", "items": [], "length": 2, "alias": 0},
        {"kind": "other", "type": "module", "name": "numpy"},
    ]
    assert SCRIPTS.value("values.map((one) => brief(one))", values=values) == [
        "None",
        "True",
        "(1\u202f; 2,5)",
        "liste de 9\u00a0éléments",
        "[[[liste de 1\u00a0élément]]]",
        "tableau 2\u00a0×\u00a02",
        "«\u202f" + 40 * "a" + "…\u202f»",
        "dictionnaire, 2\u00a0clés",
        "module numpy",
    ]
