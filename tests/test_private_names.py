"""No private API: the code uses only public names of libraries, of the standard library and of its other packages."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.base.files import ROOT

PACKAGES = ("server", "graders", "reference")
#: Public API in spite of its underscore, by the standard library's documentation.
DOCUMENTED = {"_exit", "_getframe", "_make", "_replace", "_asdict", "_fields"}
#: Public in name only: internals of SQLAlchemy and Jinja, which break with their next release.
INTERNAL = {
    ("sqlalchemy.util", "LRUCache"),
    ("sqlalchemy.orm.attributes", "instance_dict"),
    ("jinja2.compiler", "CodeGenerator"),
    ("jinja2.compiler", "Frame"),
}


def sources() -> list[Path]:
    """Return every Python file, except templates of files and the students' programs that graders are tried on."""
    found = (path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py")))
    return [path for path in found if not {"node_modules", "skeletons", "specimens"} & set(path.parts)]


def is_private(name: str) -> bool:
    dunder = name.startswith("__") and name.endswith("__")
    return name.startswith("_") and not dunder and name not in DOCUMENTED


def private_uses(tree: ast.Module) -> Iterator[str]:
    """Yield each import of a private or internal name, and each private attribute of an imported module or name."""
    imported: dict[str, str] = {}
    accesses: list[ast.Attribute] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            accesses.append(node)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                imported[alias.asname or alias.name.partition(".")[0]] = alias.name
                if any(map(is_private, alias.name.split("."))):
                    yield f"{node.lineno}: import {alias.name}"
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            for alias in node.names:
                imported[alias.asname or alias.name] = f"{module}.{alias.name}"
                private = any(map(is_private, (*module.split("."), alias.name)))
                if private or (module, alias.name) in INTERNAL:
                    yield f"{node.lineno}: from {module} import {alias.name}"
    for node in accesses:
        root, *attributes = dotted_name(node)
        if root in imported and attributes:
            private = [position for position, name in enumerate(attributes) if is_private(name)]
            if private:
                yield f"{node.lineno}: {'.'.join((root, *attributes[: private[0] + 1]))}"
            elif (imported[root], attributes[0]) in INTERNAL:
                yield f"{node.lineno}: {root}.{attributes[0]}"


#: An attribute of an object's own is nobody's API.
OWN_ATTRIBUTE = re.compile(r"(?<![\w.])(?:self|cls)\._\w+")
PRIVATE_ATTRIBUTE = re.compile(r"\._\w|\b(?:" + "|".join(name for _, name in INTERNAL) + r")\b")
IMPORT = re.compile(r"\bimport\b(?:[^(\n]*\([^)]*|[^\n]*)")
PRIVATE_WORD = re.compile(r"(?<!\w)_\w")


def may_use_private_names(source: str) -> bool:
    """Whether the text has what each private use is written with: the tree of any other file need not be walked."""
    if PRIVATE_ATTRIBUTE.search(OWN_ATTRIBUTE.sub("", source)):
        return True
    return any(PRIVATE_WORD.search(words) for words in IMPORT.findall(source))


def dotted_name(node: ast.AST) -> tuple[str, ...]:
    """Return the parts of `a.b.c`; an empty name for any other expression."""
    if isinstance(node, ast.Name):
        return (node.id,)
    if isinstance(node, ast.Attribute):
        return (*dotted_name(node.value), node.attr)
    return ("",)


@pytest.mark.parametrize(
    ("code", "count"),
    [
        ("from sqlalchemy.util import LRUCache", 1),
        ("from sqlalchemy.orm import attributes\nattributes.instance_dict(x)", 1),
        ("from jinja2.compiler import CodeGenerator as Base", 1),
        ("from os import _exit", 0),
        ("import numpy._core", 1),
        ("import _thread", 1),
        ("from a import (\n    b,\n    _c,\n)", 1),
        ("from a._b import c", 1),
        ("import os\nos._exit(0)", 0),
        ("import json\njson._default_encoder", 1),
        ("from a import b\nb.c._d.e()", 1),
        ("import os\nos.path.join()\nself._x = os.__doc__", 0),
    ],
)
def test_private_uses_are_recognised(code: str, count: int) -> None:
    assert len(set(private_uses(ast.parse(code)))) == count
    assert may_use_private_names(code) >= bool(count)


def test_no_private_name_is_used() -> None:
    texts = ((path, path.read_text(encoding="utf-8")) for path in sources())
    uses = [
        f"{path.relative_to(ROOT)}:{use}"
        for path, text in texts
        if may_use_private_names(text)
        for use in sorted(set(private_uses(ast.parse(text))))
    ]
    assert not uses, "\n".join(uses)
