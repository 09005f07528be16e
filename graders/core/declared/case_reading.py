"""Reading of cases and expected values, in Python's notation, as data: nothing of them runs here."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from graders.core.compare.python_values import RaisedException
from graders.core.contract.values import Value
from graders.core.declared.imports import ALWAYS, Imports, import_advice
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.notation import parse_python, refusal_error, unwrap_call
from graders.core.declared.powers import TOO_LARGE, bounded_power
from graders.core.declared.scenario_values import FunctionSource, NestedCall, Reference
from graders.core.declared.scenarios import PREPARATIONS, PRINT, PROGRAM, Statement

#: Bounds of a case as it is written: characters, statements, nested brackets.
MAX_CASE, MAX_STATEMENTS, MAX_NESTING = 4000, 60, 40
#: The names of functions that make a value.
_MAKERS = ("set", "array", "float", "bytes", "dict", "range", "list", "tuple")
#: Calls of NumPy that are read here, and not played.
_ARRAYS = ("np.array", "np.zeros", "np.ones")
AS_A_PROGRAM = 'votre solution est un programme entier ; si l’on y tape 3, puis 4, écrivez programme("3", "4")'


def parse_scenario(
    text: str,
    functions: Sequence[str],
    *,
    variables: Mapping[str, Value] | None = None,
    imports: Imports = ALWAYS,
) -> tuple[Statement, ...]:
    """Read the statements of a case that calls some of `functions`.

    `variables` are values that stand for names; `imports` are names of modules, besides `np` and `math`. Raises
    MalformedDeclaration.
    """
    tree = _parse_case(text)
    reader = _CaseReader(frozenset(functions), dict(variables or {}), {**ALWAYS, **imports})
    try:
        statements = tuple(reader.read_statement(node) for node in tree.body)
    except RecursionError as error:
        raise MalformedDeclaration("ce cas est trop imbriqué") from error
    if not any(statement.called_program_name for statement in statements):
        if tuple(functions) == (PROGRAM,):
            raise MalformedDeclaration(f"« {text.strip()[:80]} » : {AS_A_PROGRAM}")
        raise MalformedDeclaration(
            f"« {text.strip()[:80]} » n’appelle aucune de vos fonctions : {', '.join(functions)}"
        )
    return statements


def parse_expected(text: str) -> Value:
    """Read a literal, or the name of an exception of Python, which is expected. Raises MalformedDeclaration."""
    kind = getattr(builtins, text.strip(), None)
    if isinstance(kind, type) and issubclass(kind, BaseException):
        return RaisedException(text.strip())
    tree = _parse_case(text)
    if len(tree.body) != 1 or not isinstance(tree.body[0], ast.Expr):
        raise MalformedDeclaration(f"« {text.strip()[:80]} » n’est pas une valeur")
    return _CaseReader(frozenset(), {}, {}).read_value(tree.body[0].value)


def _parse_case(text: str) -> ast.Module:
    if len(text) > MAX_CASE:
        raise MalformedDeclaration(f"ce cas a {len(text)} caractères ; {MAX_CASE} au plus")
    if _nesting_depth(text) > MAX_NESTING:
        raise MalformedDeclaration(f"ce cas a plus de {MAX_NESTING} parenthèses imbriquées")
    tree = parse_python(text, described=" n’est pas du Python")
    if not 0 < len(tree.body) <= MAX_STATEMENTS:
        raise MalformedDeclaration(f"un cas a de 1 à {MAX_STATEMENTS} instructions")
    return tree


def _nesting_depth(text: str) -> int:
    depth = deepest = 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        deepest = max(deepest, depth)
    return deepest


class _CaseReader:
    """Reads the syntax tree of a case."""

    def __init__(self, functions: frozenset[str], variables: dict[str, Value], imports: Imports) -> None:
        self._functions, self._variables, self._assigned = functions, variables, set[str]()
        self._imports = imports
        self._is_program, self._has_run = functions == {PROGRAM}, False

    def read_statement(self, node: ast.stmt) -> Statement:
        into = ""
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Attribute):
            path = self._callee_text(node.targets[0])
            if path is not None:
                return Statement("set", path, value=self.read_value(node.value))
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
            into, expression = node.targets[0].id, node.value
        elif isinstance(node, ast.Expr):
            expression = node.value
        else:
            raise refusal_error(node, "écrivez des appels, ou « nom = … »")
        read = self._read_expression(expression, into)
        if into:
            self._assigned.add(into)
            self._variables.pop(into, None)
        return read

    def _read_expression(self, node: ast.expr, into: str) -> Statement:
        node = unwrap_call(node, self._functions)
        callee = self._callee_text(node.func) if isinstance(node, ast.Call) else None
        if callee is None:
            return Statement("value", into, value=self.read_value(node))
        assert isinstance(node, ast.Call)
        arguments, named = self._read_arguments(node)
        kind = self._statement_kind(callee)
        self._has_run |= kind == "program"
        if kind != "call":
            _require_texts(node, kind, (*arguments, *named), into)
        return Statement(kind, into, callee, arguments, named)

    def _read_arguments(self, node: ast.Call) -> tuple[tuple[Value, ...], tuple[tuple[str, Value], ...]]:
        if any(isinstance(argument, ast.Starred) for argument in node.args) or not all(it.arg for it in node.keywords):
            raise refusal_error(node, "« * » et « ** » ne se lisent pas ici")
        named = tuple((str(key.arg), self.read_value(key.value)) for key in node.keywords)
        return tuple(map(self.read_value, node.args)), named

    def _statement_kind(self, callee: str) -> str:
        if callee == PROGRAM and self._is_program:
            return "program"
        return "call" if self._is_known_name(callee) else PREPARATIONS.get(callee, "call")

    def _is_known_name(self, name: str) -> bool:
        return name in self._functions or name in self._assigned

    def _callee_text(self, node: ast.expr) -> str | None:
        """Return what is called, where it is of the program: « Pile », « p.empiler »."""
        path: list[str] = []
        while isinstance(node, ast.Attribute):
            path.insert(0, node.attr)
            node = node.value
        if not isinstance(node, ast.Name) or (not path and node.id in _MAKERS and node.id not in self._functions):
            return None
        if node.id in self._imports and not self._is_known_name(node.id):
            return None
        if not path and (node.id in PREPARATIONS or node.id == PRINT):
            return node.id
        if not self._is_known_name(node.id) and not self._has_run:
            known = ", ".join(sorted(self._functions))
            raise refusal_error(node, f"« {node.id} » n’est pas une de vos fonctions ({known})")
        if any(name.startswith("__") for name in path):
            raise refusal_error(node, "pas de nom qui commence par deux soulignés")
        return ".".join([node.id, *path])

    def read_value(self, node: ast.expr) -> Value:
        """Return the value that an expression writes."""
        readers: dict[type[ast.expr], Callable[[Any], Value]] = {
            ast.Constant: self._read_constant,
            ast.List: self._read_items,
            ast.Tuple: self._read_items,
            ast.Set: self._read_items,
            ast.Dict: self._read_dict,
            ast.Lambda: self._read_lambda,
            ast.UnaryOp: self._read_number_expression,
            ast.BinOp: self._read_number_expression,
            ast.Name: self._read_name,
            ast.Attribute: self._read_name,
            ast.Call: self._read_constructor_call,
        }
        reader = readers.get(type(node))
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and isinstance(node.ops[0], ast.Eq):
            sides = (ast.unparse(side)[:80] for side in (node.left, node.comparators[0]))
            raise refusal_error(node, "écrivez {} comme appel, et {} comme résultat attendu".format(*sides))
        if reader is None:
            raise refusal_error(node, "ce n’est ni un nombre, ni un texte, ni une liste, ni une fonction « lambda »")
        return reader(node)

    def _read_lambda(self, node: ast.Lambda) -> FunctionSource:
        """Return a function with the names that it needs. Raises MalformedDeclaration for one that nothing gives."""
        names = _free_names(node)
        imported = [name for name in names if name in self._imports and not self._is_known_name(name)]
        left = [name for name in names if name not in imported and not hasattr(builtins, name)]
        unknown = next((name for name in left if not self._is_known_name(name) and not self._has_run), None)
        if unknown is not None:
            raise refusal_error(node, f"« {unknown} » n’est pas connu ici : {import_advice(unknown)}")
        imports = tuple((name, *self._imports[name]) for name in imported if name not in ALWAYS)
        return FunctionSource(ast.unparse(node), imports, tuple(left))

    def _read_constant(self, node: ast.Constant) -> Value:
        if node.value is ...:
            raise refusal_error(node, "« ... » n’est pas une valeur")
        return node.value

    def _read_dict(self, node: ast.Dict) -> Value:
        if None in node.keys:
            raise refusal_error(node, "« ** » ne se lit pas ici")
        pairs = zip(node.keys, node.values, strict=True)
        read = self.read_value
        return {_require_hashable(node, read(key)): read(item) for key, item in pairs if key is not None}

    def _read_items(self, node: ast.List | ast.Tuple | ast.Set) -> Value:
        items = [self.read_value(item) for item in node.elts]
        if isinstance(node, ast.Set):
            return {_require_hashable(node, item) for item in items}
        return tuple(items) if isinstance(node, ast.Tuple) else items

    def _read_number_expression(self, node: ast.UnaryOp | ast.BinOp) -> Value:
        """Return -3, 1 + 2j, 2 ** 0.5 or 3 / 4: arithmetic of two small numbers."""
        if isinstance(node, ast.UnaryOp):
            operand = self.read_value(node.operand)
            if isinstance(node.op, ast.USub) and _is_number(operand):
                return -operand
            raise refusal_error(node, "seul le signe « - » se lit devant un nombre")
        left, right = self.read_value(node.left), self.read_value(node.right)
        if not (_is_number(left) and _is_number(right)):
            raise refusal_error(node, "un calcul n’a ici que des nombres")
        if isinstance(node.op, ast.Add):
            return left + right
        if isinstance(node.op, ast.Sub):
            return left - right
        if isinstance(node.op, ast.Mult):
            return left * right
        if isinstance(node.op, ast.Div) and right != 0:
            return left / right
        if isinstance(node.op, ast.Pow):
            power = bounded_power(left, right)
            if _is_number(power):
                return power
            raise refusal_error(node, TOO_LARGE)
        raise refusal_error(node, "ce calcul ne se lit pas ici : écrivez-le avec +, -, *, / et **")

    def _read_name(self, node: ast.Name | ast.Attribute) -> Value:
        text = ast.unparse(node)
        if text in ("np.pi", "pi", "math.pi"):
            return float(np.pi)
        if text in ("np.nan", "np.inf"):
            return float(text.removeprefix("np."))
        first = text.partition(".")[0]
        if text in self._variables:
            return self._variables[text]
        if first in self._assigned or text in self._functions or (self._has_run and first.isidentifier()):
            if "__" in text:
                raise refusal_error(node, "pas de nom qui contient deux soulignés")
            return Reference(text)
        if first in self._imports:
            return Reference(text, self._resolve_import(node, text))
        if self._functions and "__" not in text and callable(getattr(builtins, text, None)):
            return Reference(text, ("builtins", text))
        advice = import_advice(text) if hasattr(np, text) else "un texte s’écrit entre guillemets"
        raise MalformedDeclaration(f"« {text} » n’est pas connu ici ; {advice}")

    def _resolve_import(self, node: ast.expr, text: str) -> tuple[str, str]:
        """Return the module and the attribute of what an imported name, or a path below it, stands for."""
        first, _, rest = text.partition(".")
        if "__" in rest:
            raise refusal_error(node, "pas de nom qui contient deux soulignés")
        module, attribute = self._imports[first]
        return module, ".".join(filter(None, (attribute, rest)))

    def _read_nested_call(self, node: ast.Call) -> NestedCall | None:
        """Return a call of the program whose value is an argument, or on whose value a method is called."""
        path: list[str] = []
        base = node.func
        while isinstance(base, ast.Attribute):
            path.insert(0, base.attr)
            base = base.value
        if isinstance(base, ast.Call) and path and not any(name.startswith("__") for name in path):
            inner = self._read_nested_call(base)
            return None if inner is None else NestedCall(".".join(path), *self._read_arguments(node), inner)
        if isinstance(base, ast.Name) and self._is_known_name(base.id) and not self._is_program:
            return NestedCall(self._callee_text(node.func) or "", *self._read_arguments(node))
        text = ast.unparse(node.func)
        if isinstance(base, ast.Name) and base.id in self._imports and text not in _ARRAYS:
            return NestedCall(text, *self._read_arguments(node), imported=self._resolve_import(node, text))
        return None

    def _read_constructor_call(self, node: ast.Call) -> Value:
        """Return set(…), np.array(…), float("nan")…: a function of Python that makes a value."""
        nested = self._read_nested_call(node)
        if nested is not None:
            return nested
        maker = ast.unparse(node.func).removeprefix("np.")
        arguments = [self.read_value(argument) for argument in node.args]
        try:
            if maker == "set" and len(arguments) <= 1:
                return set(*arguments)
            if maker == "array" and len(arguments) == 1:
                return _make_array(node, arguments[0])
            if maker in ("zeros", "ones") and len(arguments) == 1 and np.prod(arguments[0]) <= MAX_CASE:
                return np.full(arguments[0], float(maker == "ones"))
            if maker == "float" and arguments in (["nan"], ["inf"], ["-inf"]):
                return float(arguments[0])
            if maker == "bytes" and len(arguments) == 1 and isinstance(arguments[0], list):
                return bytes(arguments[0])
        except (TypeError, ValueError) as error:
            raise refusal_error(node, str(error)) from error
        raise refusal_error(
            node, "de fonctions de Python, seules set, bytes, np.array, np.zeros, np.ones se lisent ici"
        )


def _make_array(node: ast.Call, content: Value) -> Value:
    array = np.array(content, dtype=_read_dtype(node))
    if array.dtype.hasobject:
        raise refusal_error(node, "un tableau ne tient ici que des nombres, des booléens ou des textes")
    return array


def _read_dtype(node: ast.Call) -> Any:
    named = {key.arg: ast.unparse(key.value) for key in node.keywords}
    if not named:
        return None
    kinds = {"float": float, "int": int, "bool": bool, "complex": complex}
    if set(named) != {"dtype"} or named["dtype"] not in kinds:
        raise refusal_error(node, "dtype=float, int, bool ou complex")
    return kinds[named["dtype"]]


def _free_names(node: ast.expr) -> list[str]:
    """Return the names that an expression reads, and does not bind itself."""
    names = [each for each in ast.walk(node) if isinstance(each, ast.Name)]
    bound = {each.arg for each in ast.walk(node) if isinstance(each, ast.arg)}
    bound |= {name.id for name in names if isinstance(name.ctx, ast.Store)}
    return list(dict.fromkeys(name.id for name in names if name.id not in bound))


def _require_texts(node: ast.Call, kind: str, arguments: Sequence[Any], into: str) -> None:
    """Refuse what is no list of lines, or no file's name and text."""
    plain = all(isinstance(value, str | int | float) for value in arguments)
    if into or not plain or (kind == "file" and len(arguments) != 2):
        words = 'écrivez clavier("3", "4"), fichier("notes.txt", "12\\n"), arguments("-v") ou programme("3", "4")'
        raise refusal_error(node, words)


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float | complex) and not isinstance(value, bool) and abs(value) < 1e300


def _require_hashable(node: ast.expr, value: Value) -> Value:
    try:
        hash(value)
    except TypeError:
        raise refusal_error(
            node, "une liste, un ensemble ou un dictionnaire ne peut pas être ici : prenez un n-uplet"
        ) from None
    return value
