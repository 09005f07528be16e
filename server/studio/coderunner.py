"""CodeRunner's questions, of an export of Moodle in XML: functions, classes, printed text and whole programs."""

from __future__ import annotations

import ast
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

from graders.core.compare.python_values import python_text
from graders.core.declared.scenarios import FILE, PROGRAM, TYPE
from graders.core.syntax_trees import parse_source
from server.studio.html_text import html_to_markdown
from server.studio.import_drafts import (
    UNREADABLE,
    ImportDraft,
    ImportRefused,
    UnderstoodCase,
    find_called_functions,
    format_program_call,
    literal_or_none,
)

PRINTED = (("regarder", "affichage"),)
#: Bytes of a file that goes with a question.
MAX_FILE_BYTES = 2000


def read_questions(data: bytes) -> Iterator[ImportDraft]:
    """Read Moodle XML: the questions of Python; of others, say that they are left. Raises ImportRefused."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise ImportRefused("ce XML définit des entités, et ne vient donc pas de Moodle : il n’est pas lu")
    if b"\0" in data:  # of another encoding, in which entities were not seen
        raise ImportRefused("ce XML n’est pas en UTF-8 : exportez-le de nouveau depuis Moodle")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        line = getattr(error, "position", (1, 0))[0]
        words = f"ce fichier n’est pas du XML (ligne {line}) : exportez les questions au format « Moodle XML »"
        raise ImportRefused(words) from error
    for number, question in enumerate(root.iter("question"), 1):
        if question.get("type") == "coderunner":
            yield _read_question(question, f"question {number}")


@dataclass(frozen=True)
class _QuestionParts:
    """What the tests of a question share: its draft, the functions that print, the statements that give it files."""

    draft: ImportDraft
    printing: frozenset[str]
    files: str
    is_program: bool


def _read_question(question: ElementTree.Element, place: str) -> ImportDraft:
    draft = ImportDraft(_element_text(question, "name/text") or place)
    draft.solution = _element_text(question, "answer")
    kind = _element_text(question, "coderunnertype")
    if not kind.startswith("python3") or kind == "python3_tkinter":
        draft.left.append(f"{place} : une question de type « {kind} » ; seules celles de Python se reprennent")
        return draft
    if _element_text(question, "prototypetype") not in ("", "0"):
        draft.left.append(f"{place} : un modèle (« prototype »), et non une question")
        return draft
    draft.statement = html_to_markdown(_element_text(question, "questiontext/text"))
    if _element_text(question, "template"):
        draft.to_look_at.append(
            f"{place} : son gabarit (« template ») n’est pas repris ; vérifiez que les cas suffisent"
        )
    if draft.statement:
        draft.to_look_at.append(f"{place} : relisez l’énoncé, qui était en HTML")
    tests = list(question.iter("testcase"))
    for name in {_element_text(test, "extra/text") for test in tests}:
        _drop_last_call(draft, place, name)
    codes = [_code_of_test(test) for test in tests]
    is_program = bool(codes) and not any(find_called_functions(code, draft.solution) for code in codes)
    files = "; ".join(_iter_file_statements(draft, place, question))
    shared = _QuestionParts(draft, _find_printing_functions(draft.solution), f"{files}; " if files else "", is_program)
    for number, (test, code) in enumerate(zip(tests, codes, strict=True), 1):
        _read_test(shared, f"{place}, test {number}", test, code)
    draft.group_cases_into_checks()
    return draft


def _element_text(element: ElementTree.Element, path: str) -> str:
    return (element.findtext(path) or "").strip()


def _drop_last_call(draft: ImportDraft, place: str, call: str) -> None:
    """Drop the call that ends the solution, where the tests make it themselves."""
    body = _parse_statements(draft.solution)
    last = body[-1] if call and body else None
    if isinstance(last, ast.Expr) and ast.unparse(last) == call:
        draft.solution = "".join(draft.solution.splitlines(keepends=True)[: last.lineno - 1]).rstrip() + "\n"
        draft.to_look_at.append(
            f"{place} : `{call}`, à la fin de la solution, est retiré : ce sont les tests qui l’appellent"
        )


def _code_of_test(test: ElementTree.Element) -> str:
    """Return the code of a test; its extra where the code is a comment alone."""
    code, extra = _element_text(test, "testcode/text"), _element_text(test, "extra/text")
    try:
        return code if parse_source(code).body or not parse_source(extra).body else extra
    except UNREADABLE:
        return code


def _find_printing_functions(solution: str) -> frozenset[str]:
    """Return the functions of a solution in which something is printed."""
    try:
        tree = parse_source(solution)
    except UNREADABLE:
        return frozenset()
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    calls = {
        function.name: {_called_name(node.func) for node in ast.walk(function) if isinstance(node, ast.Call)}
        for function in functions
    }
    printing = {"print"}
    for _ in functions:
        printing |= {name for name, called in calls.items() if called & printing}
    return frozenset(printing)


def _called_name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def _iter_file_statements(draft: ImportDraft, place: str, question: ElementTree.Element) -> Iterator[str]:
    """Yield the statements that give a question's files to its cases."""
    for file in question.iterfind("testcases/file"):
        name = file.get("name", "")
        try:
            text = b64decode(file.text or "", validate=False).decode("utf-8")
        except ValueError:
            text = ""
        if 0 < len(text) <= MAX_FILE_BYTES:
            yield f"{FILE}({python_text(name)}, {python_text(text)})"
        else:
            draft.left.append(
                f"{place} : le fichier « {name} » n’est pas repris : {MAX_FILE_BYTES} octets de texte au plus"
            )


def _read_test(question: _QuestionParts, place: str, test: ElementTree.Element, code: str) -> None:
    draft, typed, expected = question.draft, _stdin_of_test(test), (test.findtext("expected/text") or "").rstrip()
    if question.is_program:
        has_code = bool(_parse_statements(code))
        if has_code:
            draft.left.append(f"{place} : « {code[:80]} » n’appelle aucune fonction de la solution")
            return
        shown = python_text(expected) if expected else ""
        draft.add_case(place, UnderstoodCase(PROGRAM, f"{question.files}{format_program_call(typed)}", shown))
        return
    lines = ", ".join(python_text(line) for line in typed.splitlines())
    prepared = question.files + (f"{TYPE}({lines}); " if lines else "")
    functions = find_called_functions(code, draft.solution)
    if not functions:
        draft.left.append(f"{place} : aucune fonction de la solution n’y est appelée")
        return
    prints = bool(_called_names(code) & (question.printing - {"print"}))
    shown_value = None if prints else _replace_prints_by_expression(code)
    if shown_value is None:
        wanted = python_text(expected) if expected else ""
        draft.add_case(place, UnderstoodCase(functions[0], prepared + code, wanted, PRINTED, functions[1:]))
        return
    call, count = shown_value
    if count > 1:
        draft.to_look_at.append(
            f"{place} : ce test affiche plusieurs valeurs ; le résultat attendu sera celui de la solution"
        )
        wanted = ""
    else:
        wanted = literal_or_none(expected) or python_text(expected)
    draft.add_case(place, UnderstoodCase(functions[0], prepared + call, wanted, others=functions[1:]))


def _called_names(code: str) -> set[str]:
    """Return the names of the functions and methods that are called."""
    return {
        _called_name(node.func)
        for part in _parse_statements(code)
        for node in ast.walk(part)
        if isinstance(node, ast.Call)
    }


def _stdin_of_test(test: ElementTree.Element) -> str:
    return (test.findtext("stdin/text") or "").strip("\n")


def _parse_statements(code: str) -> list[ast.stmt]:
    try:
        return parse_source(code).body
    except UNREADABLE:
        return [ast.Pass()]


def _replace_prints_by_expression(code: str) -> tuple[str, int] | None:
    """Return the code with each `print(x)` of its own as `x`, and how many there are; None where it prints otherwise.

    Without a print, its last expression is what counts.
    """
    body, shown = _parse_statements(code), 0
    lines = []
    for node in body:
        call = node.value if isinstance(node, ast.Expr) else None
        if isinstance(call, ast.Call) and _called_name(call.func) == "print":
            if len(call.args) != 1 or call.keywords:
                return None
            shown += 1
            lines.append(ast.unparse(call.args[0]))
        else:
            lines.append(ast.unparse(node))
    nested = sum(
        isinstance(node, ast.Call) and _called_name(node.func) == "print" for part in body for node in ast.walk(part)
    )
    if nested != shown or not body or not isinstance(body[-1], ast.Expr):
        return None
    return "\n".join(lines), shown
