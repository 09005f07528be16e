"""A call that somebody types is read as Python would make it, without running anything."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from server.base.errors import Invalid
from server.steps import calls
from tests.support.tables import folded


@pytest.mark.parametrize(
    "typed",
    [
        "f()",
        "f((0, 0, 0), 1, 0.5)",
        "f(" + "1," * 1900 + ")",
        "f([1, [2, -3]], (), (1,))",
        "f(-1.5e3 + 2, 1 / 4 - 3 * 2, +True, 2j)",
        "f(pi / 2, -np.pi, math.inf, np.nan, math.tau)",
        "f(np.array([[1, 2], [3, 4.5]]), np.zeros(3), np.ones((2, 3)), np.eye(2), np.array([]))",
        "f({'a': 1, 'b': [2]}, 'texte', None)",
        "f(1, n_iter=3, sigma=np.array([1]))",
        "f([(0, 1, np.array([1, 0, pi / 2]), np.eye(3))])",
    ],
)
def test_a_call_has_the_values_that_python_gives_it(typed: str) -> None:
    def same(*arguments: Any, **named: Any) -> tuple[Any, Any]:
        return arguments, named

    arguments, named = eval(typed, {"f": same, "np": np, "math": math, "pi": math.pi})
    call = calls.parse_call(f"  {typed} \n")
    assert call.function == "f"
    np.testing.assert_equal((call.arguments, dict(call.named)), (arguments, named))
    assert [type(one) for one in call.arguments] == [type(one) for one in arguments]


@folded(
    ("typed", "said"),
    [
        ("", "ne comprend pas"),
        ("f(1", "ne comprend pas"),
        ("f(" + "(" * 3000 + ")", "ne comprend pas"),
        ("f\0()", "ne comprend pas"),
        ("f(" + "-" * 3900 + "1)", "ne comprend pas|trop"),
        ("f(" + "1+" * 1000 + "1)", "trop"),
        ("f(" + "1," * 2100 + ")", "trop long"),
        ("x = f(1)", "ne comprend pas"),
        ("1 + 1", "pas l’appel"),
        ("a.f(1)", "pas l’appel"),
        ("f(1)(2)", "pas l’appel"),
        ("f(x)", "« x » n’est pas connu"),
        ("f(e)", "« e » n’est pas connu"),
        ("f(os.sep)", "n’est pas connu"),
        ("f(*[1])", "pas compris"),
        ("f(**{'a': 1})", "chaque argument"),
        ("f(a=1, b=2, a=3)", "argument a est donné deux fois"),
        ("f(__import__('os').system('ls'))", "pas compris"),
        ("f(2 ** 10 ** 10)", "pas compris"),
        ("f([0] * 10 ** 9)", "pas"),
        ("f('a' * 10000)", "n’en est pas un"),
        ("f(1 / 0)", "impossible"),
        ("f(" + " * ".join(["1" + "0" * 200] * 3) + ")", "chiffres"),
        ("f(1" + "0" * 400 + ")", "chiffres"),
        ("f([k for k in (1, 2)])", "pas compris"),
        ("f(lambda: 1)", "pas compris"),
        ("f(f'{1}')", "pas compris"),
        ("f(b'a')", "pas compris"),
        ("f(...)", "pas compris"),
        ("f({1: 2})", "clés"),
        ("f({**{}})", "clés"),
        ("f(np.zeros(10 ** 9))", "pas compris"),
        ("f(np.zeros((99999, 99999)))", "pas compris"),
        ("f(np.eye(5000))", "pas compris"),
        ("f(np.zeros(-1))", "pas compris"),
        ("f(np.array([[1, 2], [3]]))", "même longueur"),
        ("f(np.array(['a']))", "que des nombres"),
        ("f(np.array([1], dtype=object))", "Un seul argument"),
        ("f(np.load('a'))", "pas compris"),
        ("f(np.zeros(True))", "pas compris"),
        ("f(np.array(" + "[" * 9 + "1" + "]" * 9 + "))", "profondément"),
        ("f(" + "[" * 70 + "1" + "]" * 70 + ")", "profondément"),
    ],
)
def test_what_is_no_call_of_values_is_refused(typed: str, said: str) -> None:
    with pytest.raises(Invalid, match=said) as refused:
        calls.parse_call(typed)
    assert len(refused.value.detail) < 400


def test_a_call_is_written_with_its_large_values_by_their_shapes() -> None:
    call = calls.parse_call("f((1,), [0.5, 'a'], np.eye(2), np.zeros((5, 7)), {'a': None}, n=-pi)")
    assert calls.format_call(call) == (
        "f((1,), [0.5, 'a'], np.array([[1.0, 0.0], [0.0, 1.0]]), [tableau 5 × 7], {'a': None}, n=-3.141592653589793)"
    )
