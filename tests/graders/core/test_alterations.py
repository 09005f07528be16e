"""Altered solutions: what each operator makes, what is left alone, and marks of those that are still right."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

import pytest

from graders.core.alterations.alterations import Alteration, find_alterations
from graders.core.alterations.equivalents import find_stale_marks, read_equivalents
from graders.core.contract.malformed import MalformedExerciseError
from tests.support.quick import some
from tests.support.shipped import CODE


def altered(line: str, head: str = "") -> set[str]:
    """What the line becomes, in turn, in a function that begins with `head`."""
    source = f"def f(*_):\n{head}    {line}\n"
    made = {one.altered for one in find_alterations(source) if one.altered.startswith(f"def f(*_):\n{head}")}
    return {one.removeprefix(f"def f(*_):\n{head}").strip() for one in made}


def of_our_own(line: str) -> set[str]:
    return {one.added_lines[0] for one in find_alterations(f"def f(*_):\n    {line}\n") if one.is_course_mistake}


@pytest.mark.parametrize(
    ("line", "among"),
    [
        ("return a + b", {"return a - b", "return a * b", "return a", "return b"}),
        ("return a - b", {"return a + b", "return b - a"}),
        ("return a - (b + c)", {"return (b + c) - a", "return a", "return (b + c)"}),
        ("return (a + b) / n", {"return (a + b) * n", "return (a + b)"}),
        ("return x**2", {"return x*2", "return x", "return x**3", "return x**1"}),
        ("return 0.5 * x", {"return 0.0 * x", "return (-0.5) * x", "return 1.0 * x", "return 1.5 * x"}),
        ("return a[:-1]", {"return a[:1]", "return a[1:-1]", "return a[:-2]"}),
        ("return a[1:k]", {"return a[2:k]", "return a[0:k]", "return a[1:k + 1]", "return a[1:k - 1]"}),
        ("return a[i]", {"return a[i + 1]", "return a[i - 1]"}),
        ("return a < b", {"return a <= b", "return a >= b"}),
        ("return 0 <= x < n", {"return 0 <= x", "return x < n", "return 0 < x < n", "return 0 <= x <= n"}),
        ("return a not in b", {"return a in b"}),
        ("return a and b and c", {"return a or b and c", "return  b and c", "return a and c", "return a and b"}),
        ("return a if c else b", {"return (a)", "return (b)"}),
        ("return not a", {"return a"}),
        ("return -a", {"return a"}),
        ("return a, b, c", {"return b, a, c", "return a, c, b"}),
        ("return True", {"return False"}),
        ("return f(a, b)", {"return f(b, a)"}),
        ("return g(a, n=3)", {"return g(a)", "return g(a, n=4)"}),
        ("return np.clip(x, -5, 5)", {"return (x)", "return np.clip(x, 5, 5)", "return np.clip(x, -5, 0)"}),
        ("return abs(x)", {"return (x)"}),
        ("return x.copy()", {"return (x)"}),
        ("return np.argmin(x)", {"return np.argmax(x)"}),
        ("return min(a, b)", {"return max(a, b)", "return (a)", "return (b)"}),
        ("return x.sum()", {"return x.mean()"}),
        ("return np.floor(x)", {"return np.ceil(x)", "return (x)"}),
        ("return round(x)", {"return (x)"}),
        ("return range(n)", {"return range(1, n)", "return range(n - 1)", "return range(n + 1)"}),
        ("return np.where(c, a, b)", {"return (a)", "return (b)", "return np.where(c, b, a)"}),
        ("return np.arctan2(y, x)", {"return np.arctan2(x, y)", "return np.arctan((y) / (x))"}),
        ("return [x for x in a if x > 0]", {"return [x for x in a if False]", "return [x for x in a if True]"}),
        ("x += 1", {"x -= 1", "x = 1", "pass", "x += 2"}),
        ("a[0] = b", {"pass", "a[1] = b"}),
        ("a.append(b)", {"pass", "a.extend(b)"}),
    ],
)
def test_what_a_line_becomes(line: str, among: set[str]) -> None:
    assert among - altered(line) == set()


@pytest.mark.parametrize(
    ("line", "among"),
    [
        ("return np.sin(t)", {"return (-np.sin(t))", "return np.sin(57.29577951308232 * (t))"}),
        ("return np.exp(1j * t)", {"return np.exp((-1j) * t)", "return np.exp(57.29577951308232 * 1j * t)"}),
        ("return np.arctan2(y, x)", {"return (57.29577951308232 * np.arctan2(y, x))"}),
        ("return np.arctan2(np.sin(t), np.cos(t))", {"return (t)"}),
        ("return np.angle(np.exp(1j * t))", {"return (t)"}),
        ("return np.pi - (np.pi - t) % (2 * np.pi)", {"return np.pi - (np.pi - t)"}),
        ("return ramener(a)", {"return (a)"}),
        ("return w / w.sum()", {"return w"}),
        ("w /= np.linalg.norm(w)", {"pass"}),
        ("return libres[y, x]", {"return libres[x, y]"}),
        ("return np.zeros((H, W))", {"return np.zeros((W, H))"}),
        ("return a.shape[0]", {"return a.shape[1]"}),
        ("return np.sum(a, axis=0)", {"return np.sum(a, axis=1)", "return np.sum(a)"}),
        ("return R @ p", {"return p @ R", "return R.T @ p"}),
        ("return (a + b).T @ c", {"return (a + b) @ c"}),
        ("return composer(a, b)", {"return composer(b, a)"}),
    ],
)
def test_the_mistakes_that_the_course_warns_of_are_its_own(line: str, among: set[str]) -> None:
    assert among - of_our_own(line) == set()


def test_a_value_given_anew_may_be_forgotten_and_the_first_one_not() -> None:
    assert "pass" in altered("x = g(x)", head="    x = 1\n")
    assert "pass" not in altered("x = g(y)")


def test_a_loop_and_its_jumps() -> None:
    head = "    for k in g:\n    "
    assert {"break", "pass"} <= altered("    continue", head=head)
    assert {"continue", "pass"} <= altered("    break", head=head)
    assert {"if not (g(k)): pass", "if True: pass", "if False: pass"} <= altered("    if g(k): pass", head=head)


def test_what_is_no_code_is_left_alone() -> None:
    source = (
        '"""1 + 2."""\n'
        "from math import pi as tour\n"
        "import numpy as np\n\n\n"
        "@dataclass(frozen=True)\n"
        'def f(a: "1 + 2", b: list[int] = None) -> tuple[1, 2]:\n'
        '    """a + b, à 1 près."""\n'
        "    # a + b\n"
        "    return f'{a + 1}' + \"a < b\"\n"
    )
    assert find_alterations(source) == []


def test_each_alteration_is_another_program_and_differs_at_one_place() -> None:
    """Of the shortest solutions that are shipped."""
    for grader in some(sorted(CODE.values(), key=lambda one: len(one.solution)))[:3]:
        found = some(find_alterations(grader.solution))
        assert len({grader.solution, *(one.altered for one in found)}) == 1 + len(found)
        for one in found[::20]:
            compile(one.altered, "solution.py", "exec")
            blocks = difflib.SequenceMatcher(None, grader.solution.splitlines(), one.altered.splitlines()).get_opcodes()
            assert sum(tag != "equal" for tag, *_ in blocks) == 1
            assert one.removed_lines[0] == grader.solution.splitlines()[one.line - 1].strip()


def test_a_byte_is_no_character() -> None:
    """Places are counted in bytes, and the accents of a comment or of a text shift nothing."""
    assert "return 'éàü', a - b" in altered("return 'éàü', a + b", head="    # é à ü\n")


SOLUTION = "def f(a):\n    if a < 0:\n        return -a\n    return a\n"
BOUND = '[[equivalent]]\nfunction = "f"\nremoved = "if a < 0:"\nadded = "if a <= 0:"\nreason = "−0 vaut 0"\n'


def in_a_folder(folder: Path, text: str) -> Path:
    (folder / "equivalents.toml").write_text(text, encoding="utf-8")
    return folder


def test_a_mark_says_of_what_it_is(tmp_path: Path) -> None:
    assert read_equivalents(tmp_path) == ()
    (mark,) = read_equivalents(in_a_folder(tmp_path, BOUND))
    found = find_alterations(SOLUTION)
    (marked,) = (one for one in found if mark.matches(one))
    assert marked.altered == SOLUTION.replace("<", "<=")
    assert list(find_stale_marks([mark], found)) == []
    for other in (SOLUTION.replace("a < 0", "0 > a"), SOLUTION.replace("def f", "def g")):
        (fault,) = find_stale_marks([mark], find_alterations(other))
        assert str(fault).startswith(f"{tmp_path / 'equivalents.toml'}:1:")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        (BOUND + '[[equivalent]]\nfunction = "f"\n', 6, "added, reason, removed"),
        (BOUND + BOUND.replace("reason", "raison"), 6, "raison, reason"),
        (BOUND + BOUND, 6, "déjà plus haut"),
        (BOUND.replace('"−0 vaut 0"', '" "'), 1, "pourquoi"),
        (BOUND.replace('"−0 vaut 0"', "12"), 1, "text"),
        (f'title = "x"\n{BOUND}', 1, "il faut des tables"),
        ("equivalent = 3", 1, "il faut des tables"),
        ("equivalent = [{}]", 1, "commence par une ligne"),
        ("[[equivalent", 1, "pas du TOML"),
        ("", 1, "il faut des tables"),
    ],
)
def test_a_mark_is_read_strictly_and_told_with_its_line(tmp_path: Path, text: str, line: int, said: str) -> None:
    with pytest.raises(MalformedExerciseError, match=said) as raised:
        read_equivalents(in_a_folder(tmp_path, text))
    assert raised.value.line == line


def test_lines_of_a_mark_need_no_margins(tmp_path: Path) -> None:
    """A call that stands on several lines."""
    source = "def f(a):\n    return g(\n        a + 1,\n    )\n"
    text = BOUND.replace('"if a < 0:"', '"""\n  a + 1,\n"""').replace('"if a <= 0:"', '"a - 1,"')
    (mark,) = read_equivalents(in_a_folder(tmp_path, text))
    assert [one.altered for one in find_alterations(source) if mark.matches(one)] == [source.replace("+", "-")]


def test_what_is_no_program_is_refused() -> None:
    with pytest.raises(SyntaxError):
        find_alterations("def f(:")


def test_where_an_alteration_stands() -> None:
    def at(one: Alteration) -> Any:
        return (one.line, one.function)

    source = "A = 2\n\n\ndef f():\n    def g():\n        return 3\n    return g() + 1\n"
    assert {at(one) for one in find_alterations(source)} == {(1, ""), (6, "g"), (7, "f")}


@pytest.mark.slow
@pytest.mark.parametrize("exercise", sorted(CODE))
def test_the_marks_that_are_shipped_are_of_something(exercise: str) -> None:
    grader = CODE[exercise]
    assert [
        str(fault) for fault in find_stale_marks(read_equivalents(grader.folder), find_alterations(grader.solution))
    ] == []
