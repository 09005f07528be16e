"""The names that an exercise's editor proposes: what its page already says, and Python's own. Never its solution's."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from graders.core.contract.kits import module_name
from graders.core.syntax_trees import parse_source
from server.course import Course, Exercise
from server.pages.python_names import BUILTINS, NUMPY, RARER

#: `np.cos`, `rclpy.init` or `self.create_publisher` as a statement or the code to begin from writes it.
_WRITTEN = re.compile(r"\b(?:np|rng|rclpy|self|math|random)(?:\.[A-Za-z]\w*)+")
_WITH_LINES: Mapping[str, tuple[str, str]] = {**NUMPY, **RARER}


@dataclass(frozen=True)
class EditorName:
    """`signature` is what one writes after the name, empty for a value; `doc` is a line in French, or empty."""

    name: str
    signature: str
    doc: str


def names_for(course: Course, exercise: Exercise) -> list[EditorName]:
    """Return the names of an exercise of code, each once: its own first, then the kit's, numpy's and Python's."""
    kit = course.kits[exercise.kit] if exercise.kit else {}
    names = [
        *_asked(exercise),
        *_reused(course, exercise),
        *_of_kit(kit, exercise.kit),
        *_inherited(exercise, kit),
        *_written(exercise),
        *(EditorName(name, *line) for table in (NUMPY, BUILTINS) for name, line in table.items()),
    ]
    return list({name.name: name for name in reversed(names)}.values())[::-1]


def _asked(exercise: Exercise) -> Iterator[EditorName]:
    for function in exercise.functions:
        if not function.is_program:
            signature = function.signature.removeprefix("class ").removeprefix(function.name)
            yield EditorName(function.name, signature, function.doc.replace("`", ""))


def _reused(course: Course, exercise: Exercise) -> Iterator[EditorName]:
    for earlier in course.reused(exercise.id):
        for name in _asked(earlier):
            doc = f"{name.doc} ; à importer : from mes_fonctions import {name.name}"
            yield EditorName(name.name, name.signature, doc)


def _of_kit(files: Mapping[str, str], kit: str) -> Iterator[EditorName]:
    """The names that programs find without importing, and those of the packages of one level, behind their module."""
    for path, source in files.items():
        module = module_name(path)
        if "." in module:
            continue
        tree = parse_source(source)
        owner = "" if _gives_its_names(path, kit, files) else f"{module}."
        described = {node.name: node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        for name in _public(tree):
            node = described.get(name)
            signature = f"({ast.unparse(node.args)})" if isinstance(node, ast.FunctionDef) else ""
            doc = _first_line(node) or _sentence_about(name, ast.get_docstring(tree) or "")
            yield EditorName(owner + name, signature, doc)


def _inherited(exercise: Exercise, kit: Mapping[str, str]) -> Iterator[EditorName]:
    """The public methods, behind `self`, that an asked class has from a class of the kit."""
    bases = {base for function in exercise.functions for base in re.findall(r"^class \w+\((\w+)\)", function.signature)}
    for source in kit.values() if bases else ():
        for node in ast.walk(parse_source(source)):
            if isinstance(node, ast.ClassDef) and node.name in bases:
                yield from _methods(node)


def _methods(node: ast.ClassDef) -> Iterator[EditorName]:
    for method in node.body:
        if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
            arguments = ast.unparse(method.args).removeprefix("self").removeprefix(", ")
            signature = "" if method.decorator_list else f"({arguments})"
            yield EditorName(f"self.{method.name}", signature, _first_line(method))


def _first_line(node: ast.FunctionDef | ast.ClassDef | None) -> str:
    return ((node and ast.get_docstring(node)) or "").partition("\n")[0].replace("`", "")


def _gives_its_names(path: str, kit: str, files: Mapping[str, str]) -> bool:
    """Whether programs find the names of this file: that of the kit, and that of the module, which every kit has."""
    return path == f"{kit}.py" or path == next(iter(files))


def _public(tree: ast.Module) -> list[str]:
    """The names in `__all__`; none where there is none."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(to, ast.Name) and to.id == "__all__" for to in node.targets):
            return [str(name) for name in ast.literal_eval(node.value)]
    return []


def _sentence_about(name: str, text: str) -> str:
    """The sentence that begins with a name in a kit's presentation, without it: « vaut True là où… »."""
    found = re.search(rf"`{re.escape(name)}`,? ([^.;`]*)", text)
    return " ".join(found[1].split()) if found else ""


def _written(exercise: Exercise) -> Iterator[EditorName]:
    for name in _WRITTEN.findall(f"{exercise.statement.source.text}\n{exercise.starter}"):
        yield EditorName(name, *_WITH_LINES.get(name, ("", "")))
