"""TESTed's test suites (YAML), of Dodona: expressions, statements, what is typed, output, exceptions, files.

Each expected value becomes a case with all that was done before it in its context.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import yaml

from graders.core.compare.python_values import python_text
from graders.core.declared.scenarios import ARGUMENTS, FILE, PROGRAM
from graders.core.syntax_trees import parse_source
from server.studio.import_drafts import UNREADABLE, ImportDraft, ImportRefused, UnderstoodCase, format_program_call

PRINTED, WRITTEN = (("regarder", "affichage"),), (("regarder", "fichiers"),)
#: Values of a file, and levels of them.
MAX_NODES, MAX_LEVELS = 20_000, 40
_TABS, _CONTEXTS, _CASES = ("tabs", "units"), ("contexts", "cases"), ("testcases", "scripts", "items")
#: Keys that change no verdict.
_SILENT = {"description", "files", "tab", "unit", "name", "hidden", "definitions", "config", "language", "namespace"}
_MODULE = "submission."
TAKE_ZIP = "importez un ZIP de l’exercice où il est"
#: Keys of what a test does, of what it prepares, and of what it expects.
_ACTS, _INPUTS = {"expression", "statement"}, {"stdin", "arguments", "argv", "input_files"}
_EXPECTED = ("return", "return_raw", "stdout", "exception", "file", "output_files")


@dataclass(frozen=True)
class TaggedValue:
    """A value with a tag of its own, such as `!expression "{1, 2}"`."""

    tag: str
    value: Any


#: That of the C library where PyYAML has it: ten times as quick, and its nesting is bounded before it composes.
_SafeLoader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_SafeLoader):  # type: ignore[misc]
    """Reads plain values; tags that are not YAML's own are kept."""


def _construct_tagged_value(loader: _Loader, suffix: str, node: yaml.Node) -> TaggedValue:
    if isinstance(node, yaml.MappingNode):
        return TaggedValue(suffix, loader.construct_mapping(node, deep=True))
    if isinstance(node, yaml.SequenceNode):
        return TaggedValue(suffix, loader.construct_sequence(node, deep=True))
    return TaggedValue(suffix, node.value)


_Loader.add_multi_constructor("!", _construct_tagged_value)


def read_test_suite(
    data: bytes, find: Callable[[str], str | None] = lambda _: None, *, solution: str = "", statement: str = ""
) -> Iterator[ImportDraft]:
    """Read a test suite; `find` returns the text of a file beside it. Raises ImportRefused."""
    content = _load_yaml(data)
    tabs = _first_present_value(content, _TABS) if isinstance(content, dict) else content
    if not isinstance(tabs, list) or not all(isinstance(tab, dict) for tab in tabs):
        raise ImportRefused("ce YAML n’est pas une suite de TESTed : il n’a pas de « tabs »")
    draft = ImportDraft("Exercice de TESTed", statement=statement, solution=solution)
    contexts = [entry for number, tab in enumerate(tabs, 1) for entry in _iter_contexts(tab, f"onglet {number}")]
    is_program = any(_needs_program(cases) for _, cases in contexts)
    for place, cases in contexts:
        _ContextReader(draft, place, is_program, find).read_tests(cases)
    draft.group_cases_into_checks()
    missing = [words for words, text in (("l’énoncé", statement), ("la solution", solution)) if not text]
    if missing:
        draft.to_look_at.append(f"écrivez {' et '.join(missing)} : cette suite de tests n’en contient pas")
    yield draft


def _load_yaml(data: bytes) -> Any:
    try:
        text, levels = data.decode("utf-8"), 0
        for count, event in enumerate(yaml.parse(text, _SafeLoader)):
            levels += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if isinstance(event, yaml.AliasEvent):
                raise ImportRefused(
                    "ce YAML a des renvois (« *nom »), qui ne se lisent pas ici : recopiez ce à quoi ils renvoient"
                )
            if count > MAX_NODES or levels > MAX_LEVELS:
                raise ImportRefused("ce YAML est trop long, ou trop imbriqué")
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError, RecursionError, TypeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" (ligne {mark.line + 1})" if mark is not None else ""
        raise ImportRefused(f"ce fichier n’est pas du YAML{line} : vérifiez ses retraits et ses guillemets") from error


def _first_present_value(table: Mapping[str, Any], keys: Sequence[str]) -> Any:
    return next((table[key] for key in keys if table.get(key) is not None), None)


def _iter_contexts(tab: dict[str, Any], place: str) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the sequences of tests of a tab: its contexts, or each of its tests alone."""
    contexts = _first_present_value(tab, _CONTEXTS)
    if not isinstance(contexts, list):
        cases = _first_present_value(tab, _CASES)
        contexts = [{"testcases": [case]} for case in cases] if isinstance(cases, list) else []
        if cases and any(isinstance(case, dict) and "statement" in case for case in cases):
            contexts = [{"testcases": cases}]
    for number, context in enumerate(contexts, 1):
        cases = _first_present_value(context, _CASES) if isinstance(context, dict) else None
        if isinstance(cases, list):
            yield f"{place}, contexte {number}", [case for case in cases if isinstance(case, dict)]


def _needs_program(cases: Sequence[Mapping[str, Any]]) -> bool:
    """Whether a context runs the whole program: a test calls nothing of it, or looks at one of its variables."""
    statements = [str(case["statement"]) for case in cases if "statement" in case]
    assigned = {text.partition("=")[0].partition(":")[0].strip() for text in statements if "=" in text}
    for case in cases:
        if not _ACTS & set(case):
            return True
        name = str(case.get("expression", "")).partition("#")[0].strip()
        if name.isidentifier() and name not in assigned:
            return True
    return False


@dataclass
class _ContextReader:
    """Reads the tests of one context: each goes on where the one before has stopped."""

    draft: ImportDraft
    place: str
    is_program: bool
    find: Callable[[str], str | None]
    done: list[str] = field(default_factory=list)
    printed: str = ""
    names: set[str] = field(default_factory=set)

    def read_tests(self, cases: Sequence[dict[str, Any]]) -> None:
        for number, case in enumerate(cases, 1):
            place = f"{self.place}, test {number}"
            try:
                self._read_test(place, case)
            except _Unsupported as left:
                self.draft.left.append(f"{place} : {left}")
                return

    def _read_test(self, place: str, case: dict[str, Any]) -> None:
        expected: dict[str, Any] = {key: case[key] for key in _EXPECTED if key in case}
        for key, value in expected.items():
            if _has_oracle(value):
                raise _Unsupported(f"« {key} » est comparé par un programme (« oracle »), qui n’est pas repris")
        self._add_input_files(case)
        self._add_statement(case)
        call = "\n".join(self.done)
        functions = [PROGRAM] if self.is_program else self._called_functions(call)
        ignored = sorted(set(case) - _ACTS - _INPUTS - _SILENT - set(_EXPECTED))
        if ignored:
            self.draft.to_look_at.append(f"{place} : {', '.join(ignored)} n’est pas repris")
        read = list(self._iter_expected_cases(place, expected, call))
        if not read and "expression" in case:
            read = [UnderstoodCase("", call)]
            self.draft.to_look_at.append(f"{place} : sans résultat attendu ; ce sera celui de la solution")
        for each in read:
            self.draft.add_case(place, replace(each, function=functions[0], others=functions[1:]))

    def _add_input_files(self, case: Mapping[str, Any]) -> None:
        files = [file for file in _list_or_empty(case.get("input_files")) if isinstance(file, dict)]
        stdin = case.get("stdin")
        if isinstance(stdin, dict):
            files.append(stdin)
        for file in files:
            name = file.get("path", file.get("name"))
            content = file.get("content", self.find(str(name)))
            if isinstance(content, str) and name:
                self.done.append(f"{FILE}({python_text(str(name))}, {python_text(content)})")
            elif name:
                raise _Unsupported(f"le fichier « {name} » manque : {TAKE_ZIP}")

    def _add_statement(self, case: Mapping[str, Any]) -> None:
        if self.is_program and (not _ACTS & set(case) or not any(PROGRAM in line for line in self.done)):
            arguments = _list_or_empty(case.get("arguments", case.get("argv")))
            if arguments:
                self.done.append(f"{ARGUMENTS}({', '.join(python_text(str(it)) for it in arguments)})")
            self.done.append(format_program_call(self._read_text(case.get("stdin"))))
        written = case.get("expression", case.get("statement"))
        if isinstance(written, dict):
            written = written.get("python")
        if written is None and {"expression", "statement"} & set(case):
            raise _Unsupported("ce test n’a pas d’expression en Python")
        if written is not None:
            self.done.append(self._tidy_code(str(written)))

    def _tidy_code(self, text: str) -> str:
        """Return an expression or a statement as a case writes it: without the module's name nor a type."""
        try:
            (node,) = parse_source(text.replace(_MODULE, "").strip()).body
        except (*UNREADABLE, ValueError) as error:
            raise _Unsupported(f"« {text[:80]} » n’est pas une instruction de Python") from error
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            node = ast.copy_location(ast.Assign([node.target], node.value), node)
        if isinstance(node, ast.Assign):
            self.names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        return ast.unparse(ast.fix_missing_locations(node))

    def _called_functions(self, call: str) -> list[str]:
        """Return the functions and classes of the program that are called."""
        calls = [node.func for node in ast.walk(parse_source(call)) if isinstance(node, ast.Call)]
        names = [node.id for node in calls if isinstance(node, ast.Name) and node.id not in self.names]
        known = [name for name in names if name not in (FILE, ARGUMENTS, "set", "print")]
        if not known:
            raise _Unsupported("aucune fonction n’y est appelée")
        return known

    def _iter_expected_cases(self, place: str, expected: Mapping[str, Any], call: str) -> Iterator[UnderstoodCase]:
        """Yield the case of each thing that a test expects."""
        if "return" in expected or "return_raw" in expected:
            yield UnderstoodCase("", call, _format_value(expected.get("return", expected.get("return_raw"))))
        if "exception" in expected:
            yield UnderstoodCase("", call, self._expected_exception_name(place, expected["exception"]))
        if "stdout" in expected:
            self.printed += self._read_text(expected["stdout"])
            yield UnderstoodCase("", call, python_text(self.printed) if self.printed.strip() else "", PRINTED)
        if "output_files" in expected or "file" in expected:
            texts = self._expected_file_texts(expected)
            known = texts and all(isinstance(text, str) for text in texts.values())
            if not known:
                words = "le fichier attendu n’est pas dans ce YAML ; ce sera celui que la solution écrit"
                self.draft.to_look_at.append(f"{place} : {words}")
            yield UnderstoodCase("", call, python_text(texts) if known else "", WRITTEN)

    def _read_text(self, value: object) -> str:
        """Return what is typed or printed: the text itself, or that of a file beside the suite."""
        if isinstance(value, dict):
            path, text = value.get("path"), value.get("data", value.get("content"))
            value = self.find(str(path)) if text is None and path else text
            if value is None and path:
                raise _Unsupported(f"le fichier « {path} » manque : {TAKE_ZIP}")
        return "" if value is None else str(value)

    def _expected_file_texts(self, expected: Mapping[str, Any]) -> dict[str, str | None]:
        """Return the texts of the files that must be written, by their names; None for one that is not there."""
        files = [it for it in _list_or_empty(expected.get("output_files")) if isinstance(it, dict)]
        texts = {str(it.get("path")): it.get("content", self.find(str(it.get("path")))) for it in files}
        single = expected.get("file")
        if isinstance(single, dict) and single.get("location"):  # its content is the name of a file beside the suite
            texts[str(single["location"])] = self.find(str(single.get("content")))
        return texts

    def _expected_exception_name(self, place: str, expected: object) -> str:
        types = expected.get("types") if isinstance(expected, dict) else None
        name = types.get("python") if isinstance(types, dict) else None
        if not isinstance(name, str):
            self.draft.to_look_at.append(
                f"{place} : une exception est attendue, sans son nom ; ce sera celle de la solution"
            )
        return name if isinstance(name, str) else ""


class _Unsupported(Exception):
    """A test that a case cannot say; the message is French."""


def _has_oracle(value: object) -> bool:
    """Whether a program compares what is obtained."""
    if isinstance(value, TaggedValue):
        return value.tag == "oracle" or _has_oracle(value.value)
    return isinstance(value, dict) and value.get("oracle") in ("custom_check", "specific_check")


def _list_or_empty(value: object) -> list[Any]:
    if isinstance(value, dict):
        value = value.get("data")
    return value if isinstance(value, list) else []


def _format_value(value: Any) -> str:
    """Return a value as a case writes it."""
    if isinstance(value, TaggedValue) and value.tag == "expression":
        return str(value.value)
    if isinstance(value, dict) and set(value) & {"value", "oracle"} == {"value", "oracle"}:
        value = value["value"]
    return python_text(_plain_value(value), None)


def _plain_value(value: Any) -> Any:
    if isinstance(value, TaggedValue):
        makers: dict[str, Any] = {"set": set, "tuple": tuple, "list": list, "map": dict, "object": dict}
        content = _plain_value(value.value)
        if value.tag in makers and isinstance(content, list | dict):
            return makers[value.tag](content)
        is_written = isinstance(content, str) and value.tag not in ("text", "char")
        return _plain_value(yaml.safe_load(content)) if is_written else content
    if isinstance(value, dict):
        return {_plain_value(key): _plain_value(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain_value(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise _Unsupported(f"une valeur de type « {type(value).__name__} » ne se reprend pas")
