"""What `figures/*.py` and `manipulations/*/figure.py` announce, and what the `figures.py` of a grader says that its
drawings show: read, not run, since drawing loads matplotlib."""

from __future__ import annotations

import ast
import importlib
import logging
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from graders import courses
from graders.core.declared import figure_data
from server.course import toml_file
from server.course.code import MANIPULATIONS, parse_python
from server.course.models import CourseFault, Drawing, Problem
from server.text.markup.text import SLUG

logger = logging.getLogger(__name__)

VERDICT_FIGURES = "figures.py"
SIZE = (6.4, 4.0)
SHAPE = 'FIGURES = {"nom": (fonction, "Texte de remplacement.")} ou (fonction, "Texte.", (largeur, hauteur))'


def read_drawings(folder: Path, problems: list[Problem]) -> dict[str, Drawing]:
    """The drawings of a module's `figures` folder and of its manipulations, by name. A fault is noted, and the others
    go on."""
    drawings: dict[str, Drawing] = {}
    stills = folder.parent.glob(f"{MANIPULATIONS}/[!_.]*/figure.py")
    for path in sorted([*folder.glob("[!_.]*.py"), *stills]):
        try:
            for drawing in _read_drawings_of_file(path):
                if (other := drawings.get(drawing.name)) is not None:
                    raise _drawing_fault(
                        path, drawing.line, f"figure « {drawing.name} » déjà dessinée dans {other.path.name}"
                    )
                drawings[drawing.name] = drawing
        except CourseFault as fault:
            problems.append(fault.problem)
    return drawings


@cache
def describe_verdict_figures(exercise: str) -> Mapping[str, str]:
    """What each kind of figure of an exercise's verdicts shows, in words, by the "kind" of its data.

    Figures of declared exercises are among them. A drawing that is announced without words is not, nor what a file
    that does not compile draws: its pages are served all the same, and the drawing tells of the fault.
    """
    rooms = courses.room_folders(courses.GRADERS)
    own = [path for room in rooms if (path := room / exercise / VERDICT_FIGURES).is_file()]
    described: dict[str, str] = {}
    for path in (Path(figure_data.__file__).with_name(VERDICT_FIGURES), *own[:1]):
        try:
            described.update(_figure_descriptions(parse_python(toml_file.read_text(path), path)))
        except CourseFault as fault:
            logger.warning("no words for the figures of %s: %s", exercise, fault.problem.message)
    return MappingProxyType(described)


def _figure_descriptions(tree: ast.Module) -> Iterator[tuple[str, str]]:
    table = next((value for node in tree.body if (value := _value_assigned_to_figures(node)) is not None), None)
    entries = zip(table.keys, table.values, strict=True) if isinstance(table, ast.Dict) else ()
    for key, value in entries:
        match value:
            case ast.Tuple(elts=[_, ast.Constant(value=str(words))]):
                kind = _resolve_figure_kind(key, tree)
                if kind is not None and words.strip():
                    yield kind, words.strip()


def _resolve_figure_kind(key: ast.expr | None, tree: ast.Module) -> str | None:
    """The text of a key: written there, or a constant imported from a module that the grader imports too."""
    if isinstance(key, ast.Constant):
        return key.value if isinstance(key.value, str) else None
    if not isinstance(key, ast.Name):
        return None
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and key.id in [alias.name for alias in node.names]:
            kind = _find_module_constant("." * node.level + (node.module or ""), key.id)
            return kind if isinstance(kind, str) else None
    return None


def _find_module_constant(module: str, name: str) -> object:
    """What a module calls so; None where it cannot be imported, of which the drawing tells."""
    try:
        return getattr(importlib.import_module(module), name, None)
    except (ImportError, TypeError) as error:  # TypeError: it is relative, which courses do not use
        logger.warning("no words for a figure: %s", error)
        return None


def _drawing_fault(path: Path, line: int | None, message: str) -> CourseFault:
    return CourseFault(Problem(path, line, message))


def _read_drawings_of_file(path: Path) -> Iterator[Drawing]:
    tree = parse_python(toml_file.read_text(path), path)
    table = next((value for node in tree.body if (value := _value_assigned_to_figures(node)) is not None), None)
    if not isinstance(table, ast.Dict):
        raise _drawing_fault(
            path, table.lineno if table else 1, f"il faut un dictionnaire écrit en toutes lettres : {SHAPE}"
        )
    for key, value in zip(table.keys, table.values, strict=True):
        yield _parse_drawing(path, key, value)


def _value_assigned_to_figures(node: ast.stmt) -> ast.expr | None:
    """What is given to FIGURES, if that is what the statement does."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    named = any(isinstance(target, ast.Name) and target.id == "FIGURES" for target in targets)
    return node.value if named and isinstance(node, ast.Assign | ast.AnnAssign) else None


def _parse_drawing(path: Path, key: ast.expr | None, value: ast.expr) -> Drawing:
    entry = value.elts if isinstance(value, ast.Tuple) else []
    match entry:
        case [ast.Name(id=function), ast.Constant(value=str(alt)), *size]:
            name = key.value if isinstance(key, ast.Constant) else None
            if isinstance(name, str) and alt.strip():
                if not re.fullmatch(SLUG, name):
                    raise _drawing_fault(
                        path, value.lineno, f"nom de figure : minuscules, chiffres et tirets, pas « {name} »"
                    )
                return Drawing(name, alt.strip(), _parse_size(path, size), path, value.lineno, function)
    raise _drawing_fault(path, value.lineno, f"figure mal annoncée : {SHAPE}")


def _parse_size(path: Path, arguments: list[ast.expr]) -> tuple[float, float]:
    match arguments:
        case []:
            return SIZE
        case [ast.Tuple(elts=[ast.Constant(value=width), ast.Constant(value=height)])]:
            if isinstance(width, int | float) and isinstance(height, int | float):
                return float(width), float(height)
    raise _drawing_fault(path, arguments[0].lineno, "taille d’une figure : deux nombres en pouces, comme (6.4, 4.0)")
