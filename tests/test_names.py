"""Names that can be guessed: the counts of the house rules on names (see `.github/CONTRIBUTING.md`)."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("server", "graders/core", "graders/scene", "graders/robotics", "reference")
LEFT_OUT = {"migrations", "node_modules", "skeletons"}
MAX_VARIABLES_NAMED_ONE = 20
VAGUE_MODULES = {
    "asked", "beside", "done", "found", "given", "held", "kept", "made", "mine", "reached", "sent", "shown", "told",
    "whole",
}  # fmt: skip
VAGUE_CLASSES = {
    "Able", "Asked", "Coming", "Fate", "Given", "Had", "HeapError", "Held", "Kept", "Lately", "Most", "Shown", "Told",
    "Wanted",
}  # fmt: skip


#: A class statement; a line of a docstring that begins with the word goes on otherwise.
CLASS = re.compile(r"^\s*class (\w+)\s*[(:]", re.MULTILINE)


@cache
def sources() -> dict[str, str]:
    """The text of each module, by its path."""
    paths = (path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py")))
    return {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
        for path in paths
        if not LEFT_OUT.intersection(path.parts)
    }


@cache
def classes() -> dict[str, list[str]]:
    """Where each class is defined, by its name without leading underscores."""
    places = defaultdict(list)
    for path, text in sources().items():
        for match in CLASS.finditer(text):
            places[match[1].lstrip("_")].append(f"{path}:{text.count(chr(10), 0, match.start(1)) + 1}")
    return places


def is_variable_named_one(node: ast.AST) -> bool:
    return (isinstance(node, ast.Name) and node.id == "one" and isinstance(node.ctx, ast.Store)) or (
        isinstance(node, ast.arg) and node.arg == "one"
    )


#: What stands behind a name where it is set, or is an argument; in prose too, now and then.
SET_ONE = re.compile(r"\bone\b\s*(?:[-+*/|&^%@<>:]*=|[,):\]]|in\b|if\b|#|\\|$)", re.MULTILINE)


def nodes_that_may_be_named_one() -> Iterator[tuple[str, ast.AST]]:
    for path, text in sources().items():
        if SET_ONE.search(text):
            yield from ((path, node) for node in ast.walk(ast.parse(text)))


def test_few_variables_are_named_one() -> None:
    places = [
        f"{path}:{node.lineno}"  # type: ignore[attr-defined]
        for path, node in nodes_that_may_be_named_one()
        if is_variable_named_one(node)
    ]
    assert len(places) <= MAX_VARIABLES_NAMED_ONE, places


def test_no_class_name_is_defined_in_three_places() -> None:
    assert {name: places for name, places in classes().items() if len(places) >= 3} == {}


def test_no_name_of_a_class_is_vague() -> None:
    assert {name: classes()[name] for name in VAGUE_CLASSES & classes().keys()} == {}


def test_no_module_is_named_by_a_vague_participle() -> None:
    assert [path for path in sources() if Path(path).stem in VAGUE_MODULES] == []
