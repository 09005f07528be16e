"""Reading of draws: « n = entier(1, 9); t = liste(reel(0, 1), n, n) », and of conditions such as « a < b »."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from graders.core.contract.values import Value
from graders.core.declared.generators import (
    Bound,
    DrawnArray,
    DrawnBoolean,
    DrawnChoice,
    DrawnDictionary,
    DrawnGrid,
    DrawnInteger,
    DrawnList,
    DrawnReal,
    DrawnText,
    DrawnTuple,
    DrawnWords,
    Draws,
    Generator,
)
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.notation import parse_python, refusal_error

#: Characters of a declaration of draws.
MAX_TEXT = 2000
#: What an expression over variables may hold.
_EXPRESSIONS = "+, -, *, %, comparaisons, and, or, not, len, abs, sum, min, max"


def parse_draws(text: str, conditions: Sequence[str] = ()) -> Draws:
    """Read « a = entier(0, 5); t = liste(reel(0, 1), 0, 8) » and its conditions. Raises MalformedDeclaration."""
    generators: list[tuple[str, Generator]] = []
    known: set[str] = set()
    for node in _parse_draws_text(text).body:
        if not (isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name)):
            raise refusal_error(node, "écrivez « nom = entier(0, 9) »")
        name = node.targets[0].id
        generators.append((name, _DrawsReader(known).read_generator(node.value)))
        known.add(name)
    return Draws(tuple(generators), tuple(_compile_condition(condition, known) for condition in conditions))


def _parse_draws_text(text: str) -> ast.Module:
    if len(text) > MAX_TEXT:
        raise MalformedDeclaration(f"{len(text)} caractères ; {MAX_TEXT} au plus")
    return parse_python(text)


def _compile_condition(text: str, known: set[str]) -> Callable[[Mapping[str, Value]], Any]:
    return parse_expression_of(text, known, "une condition")


def parse_expression_of(
    text: str, names: Iterable[str], what: str = "un calcul"
) -> Callable[[Mapping[str, Value]], Any]:
    """Return what evaluates an expression over the variables of these names. Raises MalformedDeclaration."""
    body = _parse_draws_text(text).body
    if len(body) != 1 or not isinstance(body[0], ast.Expr):
        raise MalformedDeclaration(f"« {text} » n’est pas {what}")
    return _DrawsReader(set(names)).compile_expression(body[0].value)


class _DrawsReader:
    """Reads generators, and bounds and conditions over the variables `known` so far."""

    def __init__(self, known: set[str]) -> None:
        self._known = frozenset(known)

    def read_generator(self, node: ast.expr) -> Generator:
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _GENERATORS):
            raise refusal_error(node, f"de générateurs, il y a {', '.join(_GENERATORS)}")
        reader = _GENERATORS[node.func.id]
        named = {str(key.arg): key.value for key in node.keywords}
        try:
            return reader(self, node.args, named)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            raise refusal_error(node, f"paramètres de {node.func.id} : {_USAGE[node.func.id]}") from error

    def read_bounds(self, nodes: Sequence[ast.expr], default: tuple[float, float] | None = None) -> tuple[Bound, Bound]:
        if not nodes and default is not None:
            return (lambda _: default[0]), (lambda _: default[1])
        low, high = (self.compile_expression(node) for node in nodes)
        return low, high

    def compile_expression(self, node: ast.expr) -> Callable[[Mapping[str, Value]], Any]:
        """Return what evaluates arithmetic, comparisons and `len` over the variables."""
        readers: dict[type[ast.expr], Callable[[Any], Callable[[Mapping[str, Value]], Any] | None]] = {
            ast.Constant: self._compile_constant,
            ast.Name: self._compile_variable,
            ast.BinOp: self._compile_operation,
            ast.UnaryOp: self._compile_negation,
            ast.BoolOp: self._compile_conjunction,
            ast.Compare: self._compile_comparison,
            ast.Call: self._compile_function_call,
        }
        reader = readers.get(type(node))
        read = reader(node) if reader else None
        if read is None:
            known = ", ".join(sorted(self._known)) or "aucune"
            raise refusal_error(node, f"ici, des nombres, les variables tirées avant ({known}), {_EXPRESSIONS}")
        return read

    def _compile_constant(self, node: ast.Constant) -> Callable[[Mapping[str, Value]], Any] | None:
        constant = node.value
        return (lambda _: constant) if isinstance(constant, int | float | str) else None

    def _compile_variable(self, node: ast.Name) -> Callable[[Mapping[str, Value]], Any] | None:
        name = node.id
        return (lambda variables: variables[name]) if name in self._known else None

    def _compile_operation(self, node: ast.BinOp) -> Callable[[Mapping[str, Value]], Any] | None:
        operation, parts = (
            _OPERATIONS.get(type(node.op)),
            (self.compile_expression(node.left), self.compile_expression(node.right)),
        )
        if operation is None:
            return None
        return lambda variables: operation(parts[0](variables), parts[1](variables))

    def _compile_negation(self, node: ast.UnaryOp) -> Callable[[Mapping[str, Value]], Any] | None:
        operand, negates = self.compile_expression(node.operand), isinstance(node.op, ast.USub)
        if not isinstance(node.op, ast.USub | ast.Not):
            return None
        return lambda variables: -operand(variables) if negates else not operand(variables)

    def _compile_conjunction(self, node: ast.BoolOp) -> Callable[[Mapping[str, Value]], Any]:
        values, every = [self.compile_expression(value) for value in node.values], isinstance(node.op, ast.And)
        return lambda variables: (all if every else any)(value(variables) for value in values)

    def _compile_function_call(self, node: ast.Call) -> Callable[[Mapping[str, Value]], Any] | None:
        function = _FUNCTIONS.get(node.func.id) if isinstance(node.func, ast.Name) else None
        arguments = [self.compile_expression(argument) for argument in node.args]
        if function is None:
            return None
        return lambda variables: function(*(argument(variables) for argument in arguments))

    def _compile_comparison(self, node: ast.Compare) -> Callable[[Mapping[str, Value]], bool]:
        parts = [self.compile_expression(part) for part in (node.left, *node.comparators)]
        known = [_COMPARISONS[type(comparison)] for comparison in node.ops if type(comparison) in _COMPARISONS]
        if len(known) < len(node.ops):
            raise refusal_error(node, "comparez par <, <=, >, >=, ==, != ou in")

        def compare(variables: Mapping[str, Value]) -> bool:
            values = [part(variables) for part in parts]
            triples = zip(values, known, values[1:], strict=False)
            return all(bool(comparison(left, right)) for left, comparison, right in triples)

        return compare


def _restrict_to_numbers(operation: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Return the operation on numbers alone: a repeated or formatted text has no bound."""

    def apply(left: Any, right: Any) -> Any:
        if not (isinstance(left, int | float) and isinstance(right, int | float)):
            raise MalformedDeclaration("un calcul n’a ici que des nombres")
        return operation(left, right)

    return apply


_OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: _restrict_to_numbers(operator.add),
    ast.Sub: _restrict_to_numbers(operator.sub),
    ast.Mult: _restrict_to_numbers(operator.mul),
    ast.Mod: _restrict_to_numbers(operator.mod),
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {"len": len, "abs": abs, "sum": sum, "min": min, "max": max}


def _read_literals(nodes: Sequence[ast.expr]) -> tuple[Value, ...]:
    return tuple(ast.literal_eval(node) for node in nodes)


def _read_flag(named: Mapping[str, ast.expr], name: str) -> bool:
    return name in named and ast.literal_eval(named[name]) is True


def _read_list(
    reader: _DrawsReader,
    nodes: Sequence[ast.expr],
    named: Mapping[str, ast.expr],
    kind: type[Any],
) -> Generator:
    shortest, longest = reader.read_bounds(nodes[1:], (0, 8))
    flags = (_read_flag(named, "triee"), _read_flag(named, "distincts"))
    return DrawnList(reader.read_generator(nodes[0]), shortest, longest, kind, *flags)


def _read_text(reader: _DrawsReader, nodes: Sequence[ast.expr], named: Mapping[str, ast.expr]) -> Generator:
    alphabet = ast.literal_eval(nodes[0])
    if not isinstance(alphabet, str) or not alphabet:
        raise ValueError("no alphabet")
    return DrawnText(alphabet, *reader.read_bounds(nodes[1:], (0, 12)))


def _read_words(reader: _DrawsReader, nodes: Sequence[ast.expr], named: Mapping[str, ast.expr]) -> Generator:
    words = tuple(ast.literal_eval(nodes[0]).split())
    if not words:
        raise ValueError("no word")
    return DrawnWords(words, *reader.read_bounds(nodes[1:], (0, 6)), _read_flag(named, "espaces"))


def _read_array(reader: _DrawsReader, nodes: Sequence[ast.expr], named: Mapping[str, ast.expr]) -> Generator:
    shape = nodes[0].elts if isinstance(nodes[0], ast.Tuple) else [nodes[0]]
    return DrawnArray(tuple(map(reader.compile_expression, shape)), *reader.read_bounds(nodes[1:], (-10.0, 10.0)))


def _reader_of_fixed_array(size: int) -> Callable[..., Generator]:
    def read(reader: _DrawsReader, nodes: Sequence[ast.expr], named: Mapping[str, ast.expr]) -> Generator:
        return DrawnArray((lambda _: size,), *reader.read_bounds(nodes, (-10.0, 10.0)))

    return read


_USAGE = {
    "entier": "entier(bas, haut), bornes comprises",
    "reel": "reel(bas, haut)",
    "booleen": "booleen()",
    "texte": 'texte("abc ", longueur min, longueur max)',
    "mots": 'mots("le chat dort", nombre min, nombre max, espaces=True)',
    "liste": "liste(entier(0, 9), longueur min, longueur max, triee=True, distincts=True)",
    "nuplet": "nuplet(entier(0, 9), reel(0, 1))",
    "ensemble": "ensemble(entier(0, 9), taille min, taille max)",
    "dictionnaire": 'dictionnaire(texte("abc"), entier(0, 9), taille min, taille max)',
    "tableau": "tableau((3, 2), bas, haut)",
    "point": "point(bas, haut)",
    "pose": "pose(bas, haut)",
    "grille": "grille(lignes, colonnes, probabilité de True)",
    "choix": 'choix("a", "b", 3)',
}
_GENERATORS: dict[str, Callable[[_DrawsReader, Sequence[ast.expr], Mapping[str, ast.expr]], Generator]] = {
    "entier": lambda reader, nodes, named: DrawnInteger(*reader.read_bounds(nodes)),
    "reel": lambda reader, nodes, named: DrawnReal(*reader.read_bounds(nodes)),
    "booleen": lambda reader, nodes, named: DrawnBoolean(),
    "texte": _read_text,
    "mots": _read_words,
    "liste": lambda reader, nodes, named: _read_list(reader, nodes, named, list),
    "nuplet": lambda reader, nodes, named: DrawnTuple(tuple(map(reader.read_generator, nodes))),
    "ensemble": lambda reader, nodes, named: _read_list(reader, nodes, named, set),
    "dictionnaire": lambda reader, nodes, named: DrawnDictionary(
        reader.read_generator(nodes[0]), reader.read_generator(nodes[1]), *reader.read_bounds(nodes[2:], (0, 5))
    ),
    "tableau": _read_array,
    "point": _reader_of_fixed_array(2),
    "pose": _reader_of_fixed_array(3),
    "grille": lambda reader, nodes, named: DrawnGrid(*map(reader.compile_expression, nodes)),
    "choix": lambda reader, nodes, named: DrawnChoice(_read_literals(nodes)),
}
