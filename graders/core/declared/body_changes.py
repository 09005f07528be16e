"""Changes of whole functions: a body that always returns the same, a parameter that is not read, or not as given.

A student's program that does so is right wherever the cases show nothing else: a test of emptiness that always says
True, a bisection that never looks at its precision. What a case shows already is not tried.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from graders.core.alterations.alterations import Alteration
from graders.core.alterations.text import Change, ProgramText
from graders.core.compare.python_values import MORE, OpaqueObject, RaisedException
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck, is_whole_program
from graders.core.declared.judging import Case
from graders.core.declared.playing import PlayedScenario
from graders.core.declared.scenario_values import NestedCall, Reference, value_text
from graders.core.declared.state_changes import STALE, insert_first, iter_forgetful_changes
from graders.core.syntax_trees import evaluate_literal, parse_source

CONSTANT, UNREAD, PREPARED = "résultat constant", "paramètre non lu", "paramètre modifié"
#: The operators of this module.
WHOLE_BODY = frozenset({CONSTANT, UNREAD, PREPARED, STALE})
#: Values that a body may always return, besides those of the examples; values of the examples of one function;
#: characters of a value; changes in all.
USUAL_CONSTANTS, MAX_VALUES, MAX_VALUE, MAX_BODY_CHANGES = ("None", "True", "False", "0"), 3, 200, 40
#: Characters of a value in words; the method that makes an object.
MAX_SHOWN, MAKER = 40, "__init__"


@dataclass(frozen=True)
class SeenCall:
    """A call of a function in a known case. `refuses` says whether a value that it would return instead is refused;
    `value` is what the solution returns, None where that is not shown."""

    name: str
    arguments: Mapping[int | str, Value]
    value: Value = None
    refuses: Callable[[Value], bool] | None = None

    def argument_values(self, position: int, name: str) -> list[Value]:
        """Return the argument of a parameter; none where it is not given, or no plain data and no function."""
        argument = self.arguments.get(position, self.arguments.get(name))
        return [] if argument is None or isinstance(argument, NestedCall | Reference) else [argument]


@dataclass(frozen=True)
class BodyChange:
    """A change of one function, in `words`: « `est_vide` renvoie toujours `True` ».

    `is_asked`: students write the function, and some input must show the change.
    """

    alteration: Alteration
    words: str
    is_asked: bool


def iter_seen_calls(known: Sequence[tuple[DeclaredCheck, Case, PlayedScenario]]) -> Iterator[SeenCall]:
    """Yield the calls of the known cases, by the last part of what is called: « empiler » of « p.empiler »."""
    for check, case, right in known:
        last = len(case.scenario.statements) - 1
        for step, statement in enumerate(case.scenario.statements):
            if statement.kind != "call":
                continue
            arguments: dict[int | str, Value] = dict(enumerate(statement.arguments))
            arguments.update(statement.named)
            value = right.values[step] if step < len(right.values) else None
            is_seen = statement.is_shown and check.watched == "value" and (value is not None or step == last)
            is_seen &= step < len(right.values) or (right.fault is not None and step == len(right.values))
            yield SeenCall(
                statement.callee.rpartition(".")[2],
                arguments,
                value,
                _make_refusal_test(check.with_tolerance_of_case(case.scenario), right, step) if is_seen else None,
            )


def _make_refusal_test(check: DeclaredCheck, right: PlayedScenario, step: int) -> Callable[[Value], bool]:
    """Return whether a value in place of the solution's answer in a step fails the check."""
    if step >= len(right.values) or isinstance(right.values[step], RaisedException):
        return lambda _: True  # an exception is expected
    return lambda other: check.comparator(right.values[step], other) is not None


def change_bodies(
    solution: str, functions: Sequence[str], calls: Sequence[SeenCall], printed: Sequence[str] = ()
) -> list[BodyChange]:
    """Return the solution with one function that always returns the same or does not read a parameter.

    `functions` are those that students write; `printed` is what a whole program displays in its cases. Raises
    SyntaxError for an invalid solution.
    """
    if is_whole_program(functions):
        return list(_iter_constant_programs(solution, printed))
    text = ProgramText(solution)
    same = ast.dump(text.tree)
    found: dict[str, BodyChange] = {}
    methods = list(_iter_functions_and_methods(text.tree, functions))
    names = Counter(method.name for method in methods)
    for method in methods:
        seen = [call for call in calls if call.name == method.called]
        changes = [
            *_iter_constant_bodies(text, method, seen, names[method.name] == 1),
            *_iter_bodies_ignoring_parameter(text, method, seen),
            *_iter_bodies_preparing_parameter(text, method, seen),
        ]
        for change, words in changes:
            altered = text.apply(change)
            if _is_different_program(altered, same):
                alteration = Alteration(solution, altered, change.operator, False, method.node.lineno, method.name)
                is_asked = method.is_asked and change.operator != PREPARED
                found.setdefault(altered, BodyChange(alteration, words, is_asked))
    for change, node, words in _iter_forgetful_classes(text, functions):
        alteration = Alteration(solution, text.apply(change), STALE, False, node.lineno, node.name)
        found.setdefault(alteration.altered, BodyChange(alteration, words, is_asked=False))
    return list(found.values())[:MAX_BODY_CHANGES]


def _iter_forgetful_classes(
    text: ProgramText, functions: Sequence[str]
) -> Iterator[tuple[Change, ast.FunctionDef, str]]:
    for node in text.tree.body:
        if isinstance(node, ast.ClassDef) and node.name in functions:
            yield from iter_forgetful_changes(text, node)


@dataclass(frozen=True)
class _CalledFunction:
    """A function or a method: the name by which it is called, the parameters that a caller gives, and whether students
    write it and its answer depends on what is given."""

    node: ast.FunctionDef
    called: str
    parameters: Sequence[ast.arg]
    is_asked: bool

    @property
    def name(self) -> str:
        return self.node.name


def _iter_functions_and_methods(tree: ast.Module, asked: Sequence[str]) -> Iterator[_CalledFunction]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            parameters = _parameters(node)
            yield _CalledFunction(node, node.name, parameters, node.name in asked and bool(parameters))
        elif isinstance(node, ast.ClassDef):
            for method in node.body:
                if isinstance(method, ast.FunctionDef):
                    is_static = any(ast.unparse(each) == "staticmethod" for each in method.decorator_list)
                    is_made = method.name == MAKER
                    is_asked = node.name in asked and (is_made or not method.name.startswith("_"))
                    parameters = _parameters(method)[0 if is_static else 1 :]
                    yield _CalledFunction(method, node.name if is_made else method.name, parameters, is_asked)


def _parameters(node: ast.FunctionDef) -> list[ast.arg]:
    return [*node.args.posonlyargs, *node.args.args]


def _iter_constant_bodies(
    text: ProgramText, method: _CalledFunction, seen: Sequence[SeenCall], is_alone: bool
) -> Iterator[tuple[Change, str]]:
    """Yield bodies that return a constant, or a parameter, which no call that was seen refuses."""
    if method.name == MAKER:
        return
    shown = [(call, call.refuses) for call in seen if call.refuses is not None]
    texts = dict.fromkeys((*_literal_texts([call.value for call, _ in shown]), *USUAL_CONSTANTS))
    returns = any(isinstance(part, ast.Return) and part.value is not None for part in ast.walk(method.node))
    asked = shown if is_alone else []
    for constant in texts:
        value = evaluate_literal(constant)
        if not any(refuses(value) for _, refuses in asked):
            words = (
                "ne fait rien"
                if constant == "None" and not returns
                else f"renvoie toujours `{_shorten_text(constant)}`"
            )
            yield _replace_body(text, method.node, f"return {constant}"), f"`{method.name}` {words}"
    for position, parameter in enumerate(method.parameters):
        given = [(refuses, call.argument_values(position, parameter.arg)) for call, refuses in asked]
        if not any(arguments and refuses(arguments[0]) for refuses, arguments in given):
            change = _replace_body(text, method.node, f"return {parameter.arg}")
            yield change, f"`{method.name}` renvoie `{parameter.arg}`"


def _literal_texts(values: Sequence[Value]) -> list[str]:
    """Return some of the values as literals."""
    texts = (value_text(value, None) for value in values if not isinstance(value, OpaqueObject | RaisedException))
    return [text for text in dict.fromkeys(texts) if _is_literal(text)][:MAX_VALUES]


def _is_literal(text: str) -> bool:
    if len(text) > MAX_VALUE or MORE in text:
        return False
    try:
        evaluate_literal(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return False
    return True


def _replace_body(text: ProgramText, node: ast.FunctionDef, statement: str) -> Change:
    return Change(text.span(node.body[0])[0], text.span(node.body[-1])[1], statement, CONSTANT)


def _iter_bodies_ignoring_parameter(
    text: ProgramText, method: _CalledFunction, seen: Sequence[SeenCall]
) -> Iterator[tuple[Change, str]]:
    """Yield bodies in which a parameter has its usual value, whatever is given: its default, or the most frequent."""
    defaults = method.node.args.defaults
    by_default = dict(zip([each.arg for each in reversed(method.parameters)], reversed(defaults), strict=False))
    for position, parameter in enumerate(method.parameters):
        values = [argument for call in seen for argument in call.argument_values(position, parameter.arg)]
        usual = Counter(filter(_is_writable_value, (value_text(value, None) for value in values))).most_common(1)
        default = text.source_of(by_default[parameter.arg]) if parameter.arg in by_default else ""
        value = default or (usual[0][0] if usual else "")
        if value and _is_parameter_read(method, parameter):
            change = insert_first(text, method.node, f"{parameter.arg} = {value}", UNREAD)
            yield change, f"`{parameter.arg}` de `{method.called}` vaut toujours `{_shorten_text(value)}`"


def _iter_bodies_preparing_parameter(
    text: ProgramText, method: _CalledFunction, seen: Sequence[SeenCall]
) -> Iterator[tuple[Change, str]]:
    """Yield bodies that first change what is given: a text in lower case, a list in order or without repetitions."""
    for position, parameter in enumerate(method.parameters):
        values = [argument for call in seen for argument in call.argument_values(position, parameter.arg)]
        name = parameter.arg
        if not values or not _is_parameter_read(method, parameter):
            continue
        for does_apply, expression, words in _PREPARATIONS:
            if does_apply(values):
                change = insert_first(text, method.node, f"{name} = {expression.format(name)}", PREPARED)
                yield change, f"`{method.called}` {words.format(f'`{name}`')}"


def _are_texts(values: Sequence[Value]) -> bool:
    return all(isinstance(value, str) for value in values)


def _are_sortable(values: Sequence[Value]) -> bool:
    """Whether values are lists of numbers or of texts, some with several items."""
    items = [item for value in values if isinstance(value, list) for item in value]
    is_list = all(isinstance(value, list) for value in values) and any(len(value) > 1 for value in values)
    return is_list and (_are_texts(items) or all(isinstance(item, int | float) for item in items))


#: When a parameter is changed first, how, and in which words.
_PREPARATIONS: tuple[tuple[Callable[[Sequence[Value]], bool], str, str], ...] = (
    (
        lambda values: _are_texts(values) and any(map(str.isalpha, "".join(values))),
        "{}.lower()",
        "lit {} en minuscules",
    ),
    (lambda values: _are_texts(values) and " " in "".join(values), "{}.strip()", "ôte les espaces aux bouts de {}"),
    (_are_sortable, "sorted({})", "trie d’abord {}"),
    (_are_sortable, "[x for i, x in enumerate({0}) if x not in {0}[:i]]", "ôte d’abord les répétitions de {}"),
)


def _is_parameter_read(method: _CalledFunction, parameter: ast.arg) -> bool:
    return any(isinstance(part, ast.Name) and part.id == parameter.arg for part in ast.walk(method.node))


def _is_writable_value(text: str) -> bool:
    return _is_literal(text) or (text.startswith("lambda ") and len(text) <= MAX_VALUE)


def _shorten_text(text: str) -> str:
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 1]}{MORE}"


def _iter_constant_programs(solution: str, printed: Sequence[str]) -> Iterator[BodyChange]:
    """Yield the program that displays the same whatever is typed, where no two cases display other things."""
    if len(set(printed)) == 1:
        altered = f"print({printed[0]!r}, end='')\n"
        words = f"le programme affiche toujours `{_shorten_text(printed[0].strip())}`"
        yield BodyChange(Alteration(solution, altered, CONSTANT, False, 1, ""), words, is_asked=True)


def _is_different_program(altered: str, same: str) -> bool:
    try:
        return ast.dump(parse_source(altered)) != same
    except (SyntaxError, ValueError):
        return False
