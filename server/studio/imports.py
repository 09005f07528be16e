"""Import of exercises made elsewhere, as drafts of declared exercises: nothing of a file is ever run.

Exercism's canonical data (JSON), CodeRunner questions (Moodle XML), notebooks with nbgrader's cells. A draft says what
was understood, what its author must look at, and what was left, each with its place in the file.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any
from xml.etree import ElementTree

from graders.core.compare.python_values import python_text
from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared.case_reading import parse_expected, parse_scenario
from graders.core.declared.declaration import MAX_CASES, MAX_CHECKS
from graders.core.declared.malformed import MalformedDeclaration

#: Bytes of a file; nested values of one; nested elements.
MAX_FILE, MAX_NESTING = 4 << 20, 60
NO_SOLUTION = "raise NotImplementedError('À écrire : la solution')\n"


class ImportRefused(Exception):
    """A file that cannot be read; the message is French."""


@dataclass
class Draft:
    """A draft: the declaration's data, the statement and the solution, and three lists for its author."""

    title: str
    statement: str = ""
    solution: str = ""
    functions: list[str] = field(default_factory=list)
    checks: list[dict[str, Any]] = field(default_factory=list)
    understood: list[str] = field(default_factory=list)
    to_look_at: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)

    def declaration(self) -> dict[str, Any]:
        """Return the declaration, whose checks share the points."""
        share = round(MAX_POINTS / max(1, len(self.checks)), 2)
        points = [share] * len(self.checks)
        points[-1:] = [round(MAX_POINTS - share * (len(self.checks) - 1), 2)] if points else []
        checks = [{**check, "points": part} for check, part in zip(self.checks, points, strict=True)]
        return {"fonctions": self.functions, "verifications": checks}


def read_drafts(name: str, data: bytes) -> list[Draft]:
    """Return the drafts of a file, by the ending of its name. Raises ImportRefused."""
    if len(data) > MAX_FILE:
        raise ImportRefused(f"{name} : {len(data)} octets ; {MAX_FILE} au plus")
    readers: dict[str, Callable[[bytes], Iterator[Draft]]] = {
        ".json": _exercism, ".xml": _coderunner, ".ipynb": _notebook,
    }  # fmt: skip
    reader = readers.get(PurePath(name).suffix.lower())
    if reader is None:
        raise ImportRefused(f"{name} : {', '.join(readers)} se lisent ici")
    drafts = list(reader(data))
    if not drafts:
        raise ImportRefused(f"{name} : il n’y a là aucun exercice qui se lise ici")
    return drafts


def _json(data: bytes) -> Any:
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise ImportRefused(f"ce fichier n’est pas du JSON : {error}") from error


def _exercism(data: bytes) -> Iterator[Draft]:
    """Read canonical data: cases of properties, each with an input and what is expected."""
    content = _json(data)
    if not isinstance(content, dict) or not isinstance(content.get("cases"), list):
        raise ImportRefused("ce JSON n’est pas celui d’Exercism : il n’a pas de « cases »")
    draft = Draft(str(content.get("exercise", "exercice")).replace("-", " ").capitalize())
    cases: list[tuple[str, str, str]] = []
    for place, case in _flat_cases(content["cases"], "cases", 0):
        _read_canonical_case(draft, place, case, cases)
    _add_checks(draft, cases)
    draft.to_look_at.append("la solution : Exercism n’en donne pas ; écrivez-la, et l’énoncé avec elle")
    yield draft


def _flat_cases(cases: Sequence[Any], place: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    for index, case in enumerate(cases):
        if isinstance(case, dict) and isinstance(case.get("cases"), list) and depth < MAX_NESTING:
            yield from _flat_cases(case["cases"], f"{place}[{index}].cases", depth + 1)
        elif isinstance(case, dict):
            yield f"{place}[{index}]", case


def _read_canonical_case(draft: Draft, place: str, case: dict[str, Any], cases: list[tuple[str, str, str]]) -> None:
    name, given = case.get("property"), case.get("input")
    if not isinstance(name, str) or not isinstance(given, dict):
        draft.left.append(f"{place} : ni propriété, ni entrées")
        return
    function = re.sub(r"\W+", "_", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)).lower()
    expected = case.get("expected")
    is_error = isinstance(expected, dict) and "error" in expected
    if any(isinstance(value, str) and ("=>" in value or "->" in value) for value in given.values()):
        draft.to_look_at.append(f"{place} : une entrée semble être une fonction, écrite dans un autre langage")
    if "operations" in given:
        draft.to_look_at.append(f"{place} : une suite d’opérations ; une classe dirait mieux la même chose")
    if is_error:
        draft.to_look_at.append(f"{place} : une erreur est attendue ; ValueError a été choisie")
    call = f"{function}({', '.join(repr(value) for value in given.values())})"
    _add_case(draft, place, function, call, "ValueError" if is_error else repr(expected), cases)


def _add_case(
    draft: Draft, place: str, function: str, call: str, expected: str, cases: list[tuple[str, str, str]]
) -> None:
    """Add a case that a declaration can hold; say why where it cannot."""
    functions = list(dict.fromkeys([*draft.functions, function]))
    try:
        parse_scenario(call, functions)
        if expected:
            parse_expected(expected)
    except MalformedDeclaration as error:
        draft.left.append(f"{place} : {error.message}")
        return
    draft.functions = functions
    draft.understood.append(f"{place} : {call[:80]}")
    cases.append((function, call, expected))


def _add_checks(draft: Draft, cases: Sequence[tuple[str, str, str]], **more: Any) -> None:
    """Make a check of each function's cases, at most as many as a check may have."""
    by_function: dict[str, list[tuple[str, str]]] = {}
    for function, call, expected in cases:
        by_function.setdefault(function, []).append((call, expected))
    for function, own in by_function.items():
        if len(draft.checks) == MAX_CHECKS:
            draft.left.append(f"{function} : plus de {MAX_CHECKS} vérifications")
            continue
        if len(own) > MAX_CASES:
            draft.left.append(f"{function} : {len(own) - MAX_CASES} cas de plus que les {MAX_CASES} d’une vérification")
        kept = own[:MAX_CASES]
        title = f"{function} : les cas importés"
        check = {"id": f"v{len(draft.checks) + 1}", "titre": title, "cas": [call for call, _ in kept]}
        draft.checks.append(check | {"attendus": [expected for _, expected in kept]} | more)


def _coderunner(data: bytes) -> Iterator[Draft]:
    """Read Moodle XML: the questions of Python; of others, say that they are left."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise ImportRefused("ce XML définit des entités : il n’est pas lu")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise ImportRefused(f"ce fichier n’est pas du XML : {error}") from error
    for number, question in enumerate(root.iter("question"), 1):
        if question.get("type") == "coderunner":
            yield _coderunner_question(question, f"question {number}")


def _coderunner_question(question: ElementTree.Element, place: str) -> Draft:
    draft = Draft(_text_of(question, "name/text") or place)
    draft.statement = _text_of(question, "questiontext/text")
    draft.solution = _text_of(question, "answer")
    kind = _text_of(question, "coderunnertype")
    if not kind.startswith("python3"):
        draft.left.append(f"{place} : type « {kind} », qui n’est pas du Python")
        return draft
    if _text_of(question, "template"):
        draft.to_look_at.append(f"{place} : un gabarit de correction, qui n’est pas lu")
    if draft.statement:
        draft.to_look_at.append(f"{place} : l’énoncé est en HTML")
    cases: list[tuple[str, str, str]] = []
    printed: list[tuple[str, str, str]] = []
    for number, test in enumerate(question.iter("testcase"), 1):
        _read_testcase(draft, f"{place}, test {number}", test, cases, printed)
    _add_checks(draft, cases)
    _add_checks(draft, printed, regarder="affichage")
    return draft


def _text_of(element: ElementTree.Element, path: str) -> str:
    return (element.findtext(path) or "").strip()


def _read_testcase(
    draft: Draft,
    place: str,
    test: ElementTree.Element,
    cases: list[tuple[str, str, str]],
    printed: list[tuple[str, str, str]],
) -> None:
    code, expected = _text_of(test, "testcode/text"), _text_of(test, "expected/text")
    if _text_of(test, "stdin/text") or not code:
        draft.left.append(f"{place} : un programme entier, qui lit ce que l’on tape ; écrivez-le comme une fonction")
        return
    shown = _printed_expression(code)
    functions = _called_functions(code, draft.solution)
    if not functions:
        draft.left.append(f"{place} : aucune fonction de la solution n’y est appelée")
        return
    draft.functions = list(dict.fromkeys([*draft.functions, *functions]))
    if shown is not None and (value := _readable(expected)) is not None:
        _add_case(draft, place, functions[0], shown, value, cases)
    elif shown is not None:
        _add_case(draft, place, functions[0], shown, python_text(expected), cases)
    else:
        _add_case(draft, place, functions[0], code, python_text(expected), printed)


def _printed_expression(code: str) -> str | None:
    """Return the code with its last `print(x)` as `x`; None where it prints otherwise."""
    try:
        body = ast.parse(code).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    last = body[-1].value if body and isinstance(body[-1], ast.Expr) else None
    calls = [node for node in ast.walk(ast.Module(body, [])) if isinstance(node, ast.Call)]
    prints = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "print"]
    if not isinstance(last, ast.Call) or prints != [last] or len(last.args) != 1 or last.keywords:
        return None
    return "\n".join([*map(ast.unparse, body[:-1]), ast.unparse(last.args[0])])


def _called_functions(code: str, solution: str) -> list[str]:
    """Return the functions and classes of the solution that the code names, in order; any called name without one."""
    try:
        tree, defined = ast.parse(code), ast.parse(solution)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    own = {node.name for node in defined.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    called = [node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    return list(dict.fromkeys(name for name in called if name != "print" and (not own or name in own)))


def _readable(expected: str) -> str | None:
    """Return what was printed as a literal, where it is one."""
    try:
        parse_expected(expected)
    except MalformedDeclaration:
        return None
    return expected


def _notebook(data: bytes) -> Iterator[Draft]:
    """Read nbgrader's cells: solutions between marks, `assert f(x) == y` in the cells of tests, text as statement."""
    content = _json(data)
    cells = content.get("cells") if isinstance(content, dict) else None
    if not isinstance(cells, list):
        raise ImportRefused("ce fichier n’est pas un notebook : il n’a pas de « cells »")
    draft, cases = Draft("Exercice d’un notebook"), list[tuple[str, str, str]]()
    for index, cell in enumerate(cells):
        if isinstance(cell, dict):
            _read_cell(draft, f"cellule {index + 1}", cell, cases)
    _add_checks(draft, cases)
    if draft.functions:
        yield draft


def _read_cell(draft: Draft, place: str, cell: dict[str, Any], cases: list[tuple[str, str, str]]) -> None:
    source = cell.get("source", "")
    text = "".join(map(str, source)) if isinstance(source, list) else str(source)
    metadata = cell.get("metadata")
    marks = metadata.get("nbgrader", {}) if isinstance(metadata, dict) else {}
    if cell.get("cell_type") == "markdown":
        draft.statement += text + "\n\n"
    elif isinstance(marks, dict) and marks.get("solution"):
        draft.solution += re.sub(r"^\s*###? (BEGIN|END) SOLUTION.*\n", "", text, flags=re.MULTILINE) + "\n"
    elif isinstance(marks, dict) and marks.get("grade"):
        _read_assertions(draft, place, text, cases)


def _read_assertions(draft: Draft, place: str, text: str, cases: list[tuple[str, str, str]]) -> None:
    try:
        body = ast.parse(text).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        draft.left.append(f"{place} : ce n’est pas du Python seul")
        return
    for node in body:
        where, test = f"{place}, ligne {node.lineno}", node.test if isinstance(node, ast.Assert) else None
        if isinstance(test, ast.Compare) and len(test.ops) == 1 and isinstance(test.ops[0], ast.Eq):
            call, expected = ast.unparse(test.left), ast.unparse(test.comparators[0])
            functions = _called_functions(call, draft.solution)
            if functions:
                _add_case(draft, where, functions[0], call, expected, cases)
                continue
        draft.left.append(f"{where} : « {ast.unparse(node)[:80]} » n’est pas « assert f(…) == … »")
