"""Constructs that a declared exercise forbids or requires, found in the syntax tree of a student's file."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from graders.core.declared.malformed import MalformedDeclaration
from graders.core.syntax_trees import parse_or_none

#: Characters of a file whose constructs are looked for.
MAX_SOURCE = 100_000
_LOOPS = (ast.For, ast.While, ast.AsyncFor)
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
#: Constructs by the word by which a declaration names them; any other word is the name of a function or module.
CONSTRUCTS: dict[str, tuple[str, Callable[[ast.AST], bool]]] = {
    "boucle": ("une boucle", lambda node: isinstance(node, _LOOPS)),
    "for": ("une boucle « for »", lambda node: isinstance(node, ast.For)),
    "while": ("une boucle « while »", lambda node: isinstance(node, ast.While)),
    "comprehension": ("une liste en compréhension", lambda node: isinstance(node, _COMPREHENSIONS)),
    "import": ("une importation", lambda node: isinstance(node, ast.Import | ast.ImportFrom)),
    "lambda": ("une fonction « lambda »", lambda node: isinstance(node, ast.Lambda)),
    "try": ("un « try »", lambda node: isinstance(node, ast.Try)),
    "yield": ("un « yield »", lambda node: isinstance(node, ast.Yield | ast.YieldFrom)),
    "if": ("un « if »", lambda node: isinstance(node, ast.If | ast.IfExp)),
    "class": ("une classe", lambda node: isinstance(node, ast.ClassDef)),
    "global": ("un « global »", lambda node: isinstance(node, ast.Global)),
}
RECURSION = "recursion"


@dataclass(frozen=True)
class Rule:
    """A construct that is forbidden, or required, anywhere in the file."""

    word: str
    required: bool = False

    @classmethod
    def read(cls, word: str, *, required: bool) -> Rule:
        """Raises MalformedDeclaration for what is neither a construct nor a name."""
        if word not in CONSTRUCTS and word != RECURSION and not word.replace(".", "").isidentifier():
            raise MalformedDeclaration(f"« {word} » : un nom de fonction, ou {', '.join((*CONSTRUCTS, RECURSION))}")
        return cls(word, required)

    @property
    def wording(self) -> str:
        """The construct in words: « une boucle », « `sorted` »."""
        if self.word == RECURSION:
            return "une fonction qui s’appelle elle-même"
        return CONSTRUCTS[self.word][0] if self.word in CONSTRUCTS else f"`{self.word}`"

    def find_breach(self, source: bytes) -> tuple[str, int | None] | None:
        """Return why a file breaks the rule, with the line; None where it does not, or cannot be read."""
        tree = parse_or_none(source[:MAX_SOURCE].decode("utf-8-sig", "replace"))
        if tree is None:
            return None
        line = next(self._iter_matching_lines(tree), None)
        if self.required:
            return (
                None if line is not None else (f"L’énoncé demande {self.wording}, et votre fichier n’en a pas.", None)
            )
        return None if line is None else (f"Ligne {line} : l’énoncé ne permet pas {self.wording}.", line)

    def _iter_matching_lines(self, tree: ast.Module) -> Iterator[int]:
        if self.word == RECURSION:
            yield from _iter_recursive_call_lines(tree)
            return
        found = CONSTRUCTS[self.word][1] if self.word in CONSTRUCTS else self._is_named_by_rule
        yield from (getattr(node, "lineno", 1) for node in ast.walk(tree) if found(node))

    def _is_named_by_rule(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Import | ast.ImportFrom):
            modules = [alias.name for alias in node.names] + [getattr(node, "module", None) or ""]
            return any(self.word in (name, name.partition(".")[0]) for name in modules)
        if isinstance(node, ast.Attribute):
            return node.attr == self.word or _dotted_name(node) == self.word
        return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id == self.word


def _dotted_name(node: ast.Attribute) -> str:
    return f"{node.value.id}.{node.attr}" if isinstance(node.value, ast.Name) else ""


def _iter_recursive_call_lines(tree: ast.Module) -> Iterator[int]:
    """Yield the lines where a function calls itself, directly or through others of the file."""
    functions = {node.name: node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    calls = {
        name: {
            (call.func.id if isinstance(call.func, ast.Name) else getattr(call.func, "attr", "")): call.lineno
            for call in ast.walk(node)
            if isinstance(call, ast.Call)
        }
        for name, node in functions.items()
    }
    for name, called in calls.items():
        seen, left = set[str](), [callee for callee in called if callee in calls]
        while left:
            callee = left.pop()
            if callee not in seen:
                seen.add(callee)
                left += [other for other in calls[callee] if other in calls]
        if name in seen:
            yield called.get(name, functions[name].lineno)
