"""What a module of the graders imports of ours, and what that imports in turn, read without running any of it.

Imports inside functions count too. Those that only type checkers follow do not, nor does what draws: a figure is drawn
when somebody looks, from what a verdict left. A module whose name is computed cannot be seen; the graders have one such
import, of an exercise's figures, and a test holds that what grading really imports is all found here.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache, lru_cache, partial
from pathlib import Path

from graders.core.syntax_trees import parse_source
from server.course.start_cache import StartCache

OWN_PACKAGES = ("graders", "reference")
#: What draws, and what says where courses stand.
EXCLUDED_PREFIXES = ("graders.plotting.", "graders.courses.")


class ImportGraph:
    """The modules under `roots`, each read once; `memory` keeps what was read of the same content earlier."""

    def __init__(self, *roots: Path, memory: StartCache | None = None) -> None:
        self._roots, self._memory = roots, memory or StartCache()
        self._module = cache(self._locate_and_read_imports)

    def imported_files(self, module: str) -> dict[str, Path]:
        """The files behind the import of a module, by the names of the modules; packages on the way are among them."""
        files: dict[str, Path] = {}
        left = {module}
        while left:
            name = left.pop()
            path, imported = self._module(name)
            if path is not None:
                files[name] = path
                left |= imported - files.keys()
        return files

    def _locate_and_read_imports(self, module: str) -> tuple[Path | None, frozenset[str]]:
        for base in (root.joinpath(*module.split(".")) for root in self._roots):
            for path, package in ((base / "__init__.py", module), (base.with_suffix(".py"), module.rpartition(".")[0])):
                if path.is_file():
                    content = path.read_bytes()
                    found = self._memory.cached_imports(content, package, partial(_imported_modules, content, package))
                    return path, frozenset(name for asked in (package, *found) for name in _with_parent_packages(asked))
        return None, frozenset()


def _with_parent_packages(module: str) -> Iterator[str]:
    """`a`, `a.b` and `a.b.c` for `a.b.c`, where it is of ours."""
    parts = module.split(".")
    if parts[0] in OWN_PACKAGES and not f"{module}.".startswith(EXCLUDED_PREFIXES):
        yield from (".".join(parts[:length]) for length in range(1, len(parts) + 1))


@lru_cache(maxsize=1024)
def _imported_modules(content: bytes, package: str) -> tuple[str, ...]:
    """The modules that a file may import: of `from a import b`, `a`, and `a.b`, which may be a module.

    Kept where a process reads a course again: most of its files are as they were.
    """
    return tuple(_parse_imports(content, package))


def _parse_imports(content: bytes, package: str) -> Iterator[str]:
    try:
        tree = parse_source(content)
    except (SyntaxError, ValueError):  # discovery has told of it
        return
    for node in _iterate_nested_statements(tree.body):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = _absolute_module_name(node, package)
            yield source
            yield from (f"{source}.{alias.name}" for alias in node.names)


def _absolute_module_name(node: ast.ImportFrom, package: str) -> str:
    if not node.level:
        return node.module or ""
    above = package.rsplit(".", node.level - 1)[0]
    return f"{above}.{node.module}" if node.module else above


def _iterate_nested_statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements, and those inside them: an import is a statement, so that no expression need be looked at."""
    for node in body:
        yield node
        for field in ("orelse", "finalbody") if _is_type_checking_block(node) else ("body", "orelse", "finalbody"):
            yield from _iterate_nested_statements(getattr(node, field, []))
        for part in (*getattr(node, "handlers", ()), *getattr(node, "cases", ())):
            yield from _iterate_nested_statements(part.body)


def _is_type_checking_block(node: ast.stmt) -> bool:
    """Whether it is `if TYPE_CHECKING:`."""
    test = node.test if isinstance(node, ast.If) else None
    return "TYPE_CHECKING" in (getattr(test, "id", None), getattr(test, "attr", None))
