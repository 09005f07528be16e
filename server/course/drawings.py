"""What `figures/*.py` and `manipulations/*/figure.py` announce: read, not run, since drawing loads matplotlib."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from server.course import toml_file
from server.course.code import MANIPULATIONS, parse_python
from server.course.models import CourseFault, Drawing, Problem
from server.text.markup.text import SLUG

SIZE = (6.4, 4.0)
SHAPE = 'FIGURES = {"nom": (fonction, "Texte de remplacement.")} ou (fonction, "Texte.", (largeur, hauteur))'


def read(folder: Path, problems: list[Problem]) -> dict[str, Drawing]:
    """The drawings of a module's `figures` folder and of its manipulations, by name. A fault is noted, and the others
    go on."""
    drawings: dict[str, Drawing] = {}
    stills = folder.parent.glob(f"{MANIPULATIONS}/[!_.]*/figure.py")
    for path in sorted([*folder.glob("[!_.]*.py"), *stills]):
        try:
            for drawing in _read_file(path):
                if (other := drawings.get(drawing.name)) is not None:
                    raise _fault(path, drawing.line, f"figure « {drawing.name} » déjà dessinée dans {other.path.name}")
                drawings[drawing.name] = drawing
        except CourseFault as fault:
            problems.append(fault.problem)
    return drawings


def _fault(path: Path, line: int | None, message: str) -> CourseFault:
    return CourseFault(Problem(path, line, message))


def _read_file(path: Path) -> Iterator[Drawing]:
    tree = parse_python(toml_file.read_text(path), path)
    table = next((value for node in tree.body if (value := _figures_value(node)) is not None), None)
    if not isinstance(table, ast.Dict):
        raise _fault(path, table.lineno if table else 1, f"il faut un dictionnaire écrit en toutes lettres : {SHAPE}")
    for key, value in zip(table.keys, table.values, strict=True):
        yield _drawing(path, key, value)


def _figures_value(node: ast.stmt) -> ast.expr | None:
    """What is given to FIGURES, if that is what the statement does."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    named = any(isinstance(target, ast.Name) and target.id == "FIGURES" for target in targets)
    return node.value if named and isinstance(node, ast.Assign | ast.AnnAssign) else None


def _drawing(path: Path, key: ast.expr | None, value: ast.expr) -> Drawing:
    entry = value.elts if isinstance(value, ast.Tuple) else []
    match entry:
        case [ast.Name(id=function), ast.Constant(value=str(alt)), *size]:
            name = key.value if isinstance(key, ast.Constant) else None
            if isinstance(name, str) and alt.strip():
                if not re.fullmatch(SLUG, name):
                    raise _fault(path, value.lineno, f"nom de figure : minuscules, chiffres et tirets, pas « {name} »")
                return Drawing(name, alt.strip(), _size(path, size), path, value.lineno, function)
    raise _fault(path, value.lineno, f"figure mal annoncée : {SHAPE}")


def _size(path: Path, given: list[ast.expr]) -> tuple[float, float]:
    match given:
        case []:
            return SIZE
        case [ast.Tuple(elts=[ast.Constant(value=width), ast.Constant(value=height)])]:
            if isinstance(width, int | float) and isinstance(height, int | float):
                return float(width), float(height)
    raise _fault(path, given[0].lineno, "taille d’une figure : deux nombres en pouces, comme (6.4, 4.0)")
