"""Source that several threads read at once."""

from __future__ import annotations

import ast
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from graders.core.syntax_trees import evaluate_literal, parse_expression, parse_source


def test_a_tree_can_be_built_while_a_collection_lets_another_thread_build_one() -> None:
    """`ast.parse` alone fails here before Python 3.13: the other thread builds its tree in the middle of this one's."""
    text = "x = [" + "(1 + 2) * f(3), " * 400 + "]"
    expected = ast.dump(ast.parse(text))
    over = Event()

    class Yielding:
        """An object in a circle of references, whose end lets another thread run."""

        def __init__(self) -> None:
            self.circle = self

        def __del__(self) -> None:
            over.wait(0.0005)

    def build(calls: int) -> str:
        """Read the text under so many calls: the count of CPython begins with them."""
        if calls:
            return build(calls - 1)
        for _ in range(40):
            Yielding()
        return ast.dump(parse_source(text))

    with ThreadPoolExecutor(4) as threads:
        trees = {work.result() for work in [threads.submit(build, 1 + rank % 4 * 10) for rank in range(40)]}
    assert trees == {expected}


def test_expressions_and_literals() -> None:
    assert ast.unparse(parse_expression("a+1")) == "a + 1"
    assert evaluate_literal(" (1, 'é')") == (1, "é")
    with pytest.raises(ValueError, match="malformed"):
        evaluate_literal("f(1)")
    with pytest.raises(SyntaxError):
        parse_source("def")
