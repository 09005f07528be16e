"""Import of exercises made elsewhere, as drafts of declared exercises: nothing of a file is ever run.

Exercism's canonical data (JSON), CodeRunner questions (Moodle XML), TESTed's test suites (YAML), notebooks with
nbgrader's cells. A draft says what was understood, what its author must look at, and what was left, each with its place
in the file.
"""

from __future__ import annotations

import ast
import itertools
import json
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import PurePath
from typing import Any

from graders.core.syntax_trees import parse_source
from server.studio.coderunner import read_questions
from server.studio.import_drafts import (
    MAX_READ,
    UNREADABLE,
    ImportDraft,
    ImportRefused,
    UnderstoodCase,
    find_called_functions,
)
from server.studio.tested import read_test_suite

#: Bytes of a file; nested elements of one.
MAX_FILE, MAX_NESTING = 4 << 20, 60
#: Cells of a notebook that are read, and characters of one whose tests are read.
MAX_CELLS, MAX_CELL = 500, 40_000


def read_drafts(name: str, data: bytes) -> list[ImportDraft]:
    """Return the drafts of a file, by the ending of its name. Raises ImportRefused."""
    if len(data) > MAX_FILE:
        raise ImportRefused(f"{name} pèse {len(data) >> 20} Mio ; {MAX_FILE >> 20} au plus")
    readers: dict[str, Callable[[bytes], Iterator[ImportDraft]]] = {
        ".json": _read_exercism,
        ".xml": read_questions,
        ".ipynb": _read_notebook,
        ".yaml": read_test_suite,
        ".yml": read_test_suite,
    }
    reader = readers.get(PurePath(name).suffix.lower())
    if reader is None:
        raise ImportRefused(f"{name} : .zip, {', '.join(readers)} se lisent ici")
    drafts = list(reader(data))
    if not drafts:
        raise ImportRefused(f"{name} ne contient aucun exercice qui se reprenne ici")
    return drafts


def _parse_json(data: bytes) -> Any:
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        line = getattr(error, "lineno", 1)
        raise ImportRefused(f"ce fichier n’est pas du JSON (ligne {line}) : reprenez-le là où il a été fait") from error


def _read_exercism(data: bytes) -> Iterator[ImportDraft]:
    """Read canonical data: cases of properties, each with an input and what is expected."""
    content = _parse_json(data)
    if not isinstance(content, dict) or not isinstance(content.get("cases"), list):
        raise ImportRefused("ce JSON n’est pas celui d’Exercism : il n’a pas de « cases »")
    draft = ImportDraft(str(content.get("exercise", "exercice")).replace("-", " ").capitalize())
    for place, case in itertools.islice(_flatten_cases(content["cases"], "cases", 0), MAX_READ):
        _read_canonical_case(draft, place, case)
    draft.group_cases_into_checks()
    draft.to_look_at.append("écrivez l’énoncé et la solution : les données d’Exercism n’en contiennent pas")
    yield draft


def _flatten_cases(cases: Sequence[Any], place: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    for index, case in enumerate(cases):
        if isinstance(case, dict) and isinstance(case.get("cases"), list) and depth < MAX_NESTING:
            yield from _flatten_cases(case["cases"], f"{place}[{index}].cases", depth + 1)
        elif isinstance(case, dict):
            yield f"{place}[{index}]", case


def _read_canonical_case(draft: ImportDraft, place: str, case: dict[str, Any]) -> None:
    name, given = case.get("property"), case.get("input")
    if not isinstance(name, str) or not isinstance(given, dict):
        draft.left.append(f"{place} : ce cas n’a pas « property » et « input »")
        return
    function = re.sub(r"\W+", "_", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)).lower()
    expected = case.get("expected")
    is_error = isinstance(expected, dict) and "error" in expected
    if any(isinstance(value, str) and ("=>" in value or "->" in value) for value in given.values()):
        draft.to_look_at.append(
            f"{place} : une entrée semble être une fonction écrite dans un autre langage : récrivez-la en Python"
        )
    if "operations" in given:
        draft.to_look_at.append(f"{place} : une suite d’opérations, à laquelle une classe conviendrait mieux")
    if is_error:
        draft.to_look_at.append(f"{place} : une erreur est attendue, sans son nom : ValueError a été choisie")
    call = f"{function}({', '.join(repr(value) for value in given.values())})"
    draft.add_case(place, UnderstoodCase(function, call, "ValueError" if is_error else repr(expected)))


def _read_notebook(data: bytes) -> Iterator[ImportDraft]:
    """Read nbgrader's cells: solutions between marks, `assert f(x) == y` in the cells of tests, text as statement."""
    content = _parse_json(data)
    cells = content.get("cells") if isinstance(content, dict) else None
    if not isinstance(cells, list):
        raise ImportRefused("ce fichier n’est pas un notebook : il n’a pas de « cells »")
    draft = ImportDraft("Exercice d’un notebook")
    for index, cell in enumerate(cells[:MAX_CELLS]):
        if isinstance(cell, dict) and not draft.is_full:
            _read_cell(draft, f"cellule {index + 1}", cell)
    draft.group_cases_into_checks()
    if draft.functions or draft.left:
        yield draft


def _read_cell(draft: ImportDraft, place: str, cell: dict[str, Any]) -> None:
    source = cell.get("source", "")
    text = "".join(map(str, source)) if isinstance(source, list) else str(source)
    metadata = cell.get("metadata")
    marks = metadata.get("nbgrader", {}) if isinstance(metadata, dict) else {}
    if cell.get("cell_type") == "markdown":
        draft.statement += text + "\n\n"
    elif isinstance(marks, dict) and marks.get("solution"):
        draft.solution += re.sub(r"^\s*###? (BEGIN|END) SOLUTION.*\n", "", text, flags=re.MULTILINE) + "\n"
    elif isinstance(marks, dict) and marks.get("grade"):
        _read_assertions(draft, place, text)


def _read_assertions(draft: ImportDraft, place: str, text: str) -> None:
    if len(text) > MAX_CELL:
        draft.left.append(f"{place} : {len(text)} caractères ; {MAX_CELL} au plus")
        return
    try:
        body = parse_source(text).body
    except UNREADABLE:
        draft.left.append(f"{place} : cette cellule n’est pas du Python seul")
        return
    for node in itertools.islice(body, MAX_READ):
        where, test = f"{place}, ligne {node.lineno}", node.test if isinstance(node, ast.Assert) else None
        if isinstance(test, ast.Compare) and len(test.ops) == 1 and isinstance(test.ops[0], ast.Eq):
            call, expected = ast.unparse(test.left), ast.unparse(test.comparators[0])
            functions = find_called_functions(call, draft.solution)
            if functions:
                draft.add_case(where, UnderstoodCase(functions[0], call, expected))
                continue
        draft.left.append(f"{where} : « {ast.unparse(node)[:80]} » n’est pas « assert f(…) == … »")
