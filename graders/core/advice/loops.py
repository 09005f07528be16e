"""Loops that one line of numpy does, and work that a loop repeats. Pure: an edit is a candidate, to be tried."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from graders.core.advice.edits import (
    Advice,
    AdviceKind,
    list_functions,
    make_advice,
    numpy_function_name,
    replace_expressions,
    replace_statement,
    stored_names,
)

SUM = "Cette boucle fait une somme, élément par élément : numpy la fait en une ligne, sans boucle Python."
FILL = "Cette boucle remplit un tableau case par case : numpy calcule toutes les cases en une ligne."
LIST = "Cette boucle bâtit une liste élément par élément : la même expression, sur le tableau entier, les donne tous."
REPEATED_MANY = "{calls} ne changent pas d’un tour à l’autre : calculez-les une fois, avant la boucle."
REPEATED = "{calls} ne change pas d’un tour à l’autre : calculez-le une fois, avant la boucle."
#: Functions whose value does not change from one turn of a loop to the next if their arguments do not.
STEADY = frozenset({"inv", "det", "norm", "pinv"})


class CannotVectorise(Exception):
    """A loop is not one that this module knows how to write for a whole array."""


@dataclass
class Vectoriser(ast.NodeTransformer):
    """Rewrites the body of a loop for all its turns at once.

    `index` is the name of the counter ("" for none), `cut` the slice that it runs through; `elements` are the names of
    elements, each with the array through which it runs; `vectors` the names that the body has computed.
    """

    index: str
    cut: ast.expr | None
    elements: Mapping[str, ast.expr]
    vectors: set[str] = field(default_factory=set)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id == self.index:
            raise CannotVectorise
        return copy.deepcopy(self.elements.get(node.id, node))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        parts = list(node.slice.elts) if isinstance(node.slice, ast.Tuple) else [node.slice]
        if isinstance(node.value, ast.Name) and node.value.id in self.elements:
            if any(not _is_same_in_all_turns(part, self) for part in parts):
                raise CannotVectorise
            array = copy.deepcopy(self.elements[node.value.id])
            return _subscript(array, [ast.Slice(), *parts])
        is_index = [isinstance(part, ast.Name) and part.id == self.index for part in parts]
        if not isinstance(node.value, ast.Name) or is_index.count(True) != 1 or not is_index[0]:
            if any(is_index) or not all(_is_same_in_all_turns(part, self) for part in (node.value, *parts)):
                raise CannotVectorise
            return node
        if not all(_is_same_in_all_turns(part, self) for part in parts[1:]):
            raise CannotVectorise
        if self.cut is None and len(parts) == 1:
            return node.value
        return _subscript(node.value, [self.cut or ast.Slice(), *parts[1:]])

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = numpy_function_name(node)
        if not name:
            raise CannotVectorise
        function = ast.Attribute(ast.Name("np", ast.Load()), name, ast.Load())
        return ast.Call(function, [self.visit(arg) for arg in node.args], [])

    def generic_visit(self, node: ast.AST) -> ast.AST:
        if not isinstance(
            node, ast.BinOp | ast.UnaryOp | ast.Constant | ast.Attribute | ast.operator | ast.unaryop | ast.expr_context
        ) or (isinstance(node, ast.Attribute) and ast.unparse(node) not in {"np.pi", "math.pi"}):
            raise CannotVectorise
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            raise CannotVectorise
        return super().generic_visit(node)


def _is_same_in_all_turns(node: ast.expr, loop: Vectoriser) -> bool:
    moving = {loop.index, *loop.elements, *loop.vectors}
    return not any(isinstance(part, ast.Name) and part.id in moving for part in ast.walk(node))


def _subscript(array: ast.expr, parts: list[ast.expr]) -> ast.expr:
    index = parts[0] if len(parts) == 1 else ast.Tuple(parts, ast.Load())
    return ast.Subscript(array, index, ast.Load())


def list_loop_advice(source: str, tree: ast.Module) -> Iterator[Advice]:
    """Yield the loops of a program that one line of numpy may do."""
    for block in _iter_blocks(tree):
        for place, node in enumerate(block):
            if not isinstance(node, ast.For) or node.orelse:
                continue
            before = block[place - 1] if place else None
            try:
                sentence, first, others = _rewrite_without_loop(node, before)
            except CannotVectorise:
                continue
            advice = make_advice(AdviceKind.loop, source, replace_statement(source, first, others, node), sentence)
            if advice is not None:
                yield advice


def _iter_blocks(tree: ast.Module) -> Iterator[list[ast.stmt]]:
    for function in list_functions(tree):
        for node in ast.walk(function):
            for name in ("body", "orelse"):
                block = getattr(node, name, None)
                if isinstance(block, list):
                    yield block


def _rewrite_without_loop(node: ast.For, before: ast.stmt | None) -> tuple[str, ast.stmt, list[ast.stmt]]:
    """Return why, the first statement that is replaced, and those that replace it. Raises CannotVectorise."""
    loop = _read_header(node)
    lines: list[ast.stmt] = []
    for statement in node.body[:-1]:
        lines.append(_vectorise_assignment(loop, statement))
    last = node.body[-1]
    match last:
        case ast.AugAssign(target=ast.Name(id=name), op=ast.Add(), value=value) if name not in loop.vectors:
            if any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(value)):
                raise CannotVectorise
            total = ast.Call(
                ast.Attribute(ast.Name("np", ast.Load()), "sum", ast.Load()), [_vectorise_expression(loop, value)], []
            )
            return SUM, node, [*lines, ast.AugAssign(last.target, ast.Add(), total)]
        case ast.Assign(targets=[ast.Subscript(value=ast.Name(id=out)) as target], value=value):
            if any(isinstance(part, ast.Name) and part.id == out for part in ast.walk(value)):
                raise CannotVectorise
            left = loop.visit(target)
            if isinstance(left, ast.Name):
                left = _subscript(left, [ast.Slice()])
            return FILL, node, [*lines, ast.Assign([left], _vectorise_expression(loop, value), lineno=0)]
        case ast.Expr(ast.Call(func=ast.Attribute(value=ast.Name(id=out), attr="append"), args=[value], keywords=[])):
            match before:
                case ast.Assign(targets=[ast.Name(id=name)], value=ast.List(elts=[])) if name == out:
                    made = ast.Assign([ast.Name(out, ast.Store())], _vectorise_expression(loop, value), lineno=0)
                    return LIST, before, [*lines, made]
    raise CannotVectorise


def _vectorise_expression(loop: Vectoriser, value: ast.expr) -> ast.expr:
    """Return an expression for all turns, which must depend on the turn. Raises CannotVectorise."""
    if _is_same_in_all_turns(value, loop):
        raise CannotVectorise
    if isinstance(value, ast.Call) and ast.unparse(value.func) == "np.array" and len(value.args) == 1:
        value = value.args[0]
    if isinstance(value, ast.List | ast.Tuple):
        columns = ast.List([loop.visit(part) for part in value.elts], ast.Load())
        axis = ast.keyword("axis", ast.UnaryOp(ast.USub(), ast.Constant(1)))
        return ast.Call(ast.Attribute(ast.Name("np", ast.Load()), "stack", ast.Load()), [columns], [axis])
    whole: ast.expr = loop.visit(copy.deepcopy(value))
    return whole


def _read_header(node: ast.For) -> Vectoriser:
    """Read through what a loop runs. Raises CannotVectorise."""
    match node.target, node.iter:
        case ast.Name(id=index), ast.Call(func=ast.Name(id="range"), args=[stop], keywords=[]):
            match stop:
                case ast.Call(func=ast.Name(id="len"), args=[ast.Name()]):
                    return Vectoriser(index, None, {})
                case ast.Name() | ast.Constant():
                    return Vectoriser(index, ast.Slice(None, stop), {})
        case ast.Name(id=name), ast.Name() as array:
            return Vectoriser("", None, {name: array})
        case ast.Tuple(elts=names), ast.Call(func=ast.Name(id="zip"), args=arrays, keywords=[]):
            if len(names) == len(arrays) and all(isinstance(part, ast.Name) for part in (*names, *arrays)):
                pairs = zip(names, arrays, strict=True)
                return Vectoriser("", None, {name.id: array for name, array in pairs if isinstance(name, ast.Name)})
        case ast.Tuple(elts=names), ast.Name() as array:
            if all(isinstance(part, ast.Name) for part in names):
                columns = [_subscript(array, [ast.Slice(), ast.Constant(k)]) for k in range(len(names))]
                pairs = zip(names, columns, strict=True)
                return Vectoriser("", None, {name.id: column for name, column in pairs if isinstance(name, ast.Name)})
    raise CannotVectorise


def _vectorise_assignment(loop: Vectoriser, node: ast.stmt) -> ast.stmt:
    """Return the assignment of a temporary name for all turns. Raises CannotVectorise."""
    match node:
        case ast.Assign(targets=[ast.Name(id=name) as target], value=value) if name not in loop.vectors:
            if any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(value)):
                raise CannotVectorise
            made = ast.Assign([target], _vectorise_expression(loop, value), lineno=0)
            loop.vectors.add(name)
            return made
    raise CannotVectorise


def list_repeated_work(source: str, tree: ast.Module) -> Iterator[Advice]:
    """Yield the calls that every turn of a loop makes with the same arguments, and so need be made once."""
    for function in list_functions(tree):
        for node in ast.walk(function):
            if isinstance(node, ast.For | ast.While):
                advice = _hoist_calls_advice(source, function, node)
                if advice is not None:
                    yield advice


def _hoist_calls_advice(source: str, function: ast.FunctionDef, node: ast.For | ast.While) -> Advice | None:
    stored = stored_names(node) | _names_bound_inside(node)
    calls: dict[str, ast.Call] = {}
    for statement in node.body:
        for part in ast.walk(statement):
            if isinstance(part, ast.Call) and _is_pure(part) and not _names_read(part) & stored and _names_read(part):
                calls.setdefault(ast.unparse(part), part)
    inner = {text for text, call in calls.items() for part in ast.walk(call) if part is not call
             and isinstance(part, ast.Call) and ast.unparse(part) in calls for text in [ast.unparse(part)]}  # fmt: skip
    wanted = {text: call for text, call in calls.items() if text not in inner}
    if not wanted:
        return None
    taken = {part.id for part in ast.walk(function) if isinstance(part, ast.Name)}
    taken |= {arg.arg for arg in ast.walk(function) if isinstance(arg, ast.arg)}
    names: dict[str, str] = {}
    for text, call in wanted.items():
        name = _choose_variable_name(call, taken)
        names[text] = name
        taken.add(name)
    outer = [
        call
        for call in _iter_calls_in_body(node)
        if ast.unparse(call) in names and not _is_within_named_call(call, node, names)
    ]
    replaced = replace_expressions(source, [(call, names[ast.unparse(call)]) for call in outer])
    lines = replaced.splitlines(keepends=True)
    if not replaced or lines[node.lineno - 1].encode()[: node.col_offset].strip():
        return None
    indent = lines[node.lineno - 1].encode()[: node.col_offset].decode()
    made = [f"{indent}{name} = {text}\n" for text, name in names.items()]
    edited = "".join([*lines[: node.lineno - 1], *made, *lines[node.lineno - 1 :]])
    listed = " et ".join(f"`{text}`" for text in list(wanted)[:2])
    sentence = (REPEATED if len(wanted) == 1 else REPEATED_MANY).format(calls=listed)
    return make_advice(AdviceKind.repeated, source, edited, sentence)


def _iter_calls_in_body(node: ast.For | ast.While) -> Iterator[ast.Call]:
    """Yield the calls in the body of a loop."""
    return (part for statement in node.body for part in ast.walk(statement) if isinstance(part, ast.Call))


def _is_within_named_call(call: ast.Call, node: ast.For | ast.While, names: Mapping[str, str]) -> bool:
    """Whether a call stands within another one that gets a name."""
    others = (other for other in _iter_calls_in_body(node) if other is not call and ast.unparse(other) in names)
    return any(part is call for other in others for part in ast.walk(other))


def _is_pure(call: ast.Call) -> bool:
    steady = (
        isinstance(call.func, ast.Attribute)
        and ast.unparse(call.func.value) in {"np.linalg", "numpy.linalg"}
        and call.func.attr in STEADY
    )
    if not steady and numpy_function_name(call) in {"", "abs"}:
        return False
    simple = (ast.Name, ast.Constant, ast.Attribute, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop,
              ast.expr_context, ast.Call)  # fmt: skip
    inside = [part for arg in call.args for part in ast.walk(arg)]
    return all(isinstance(part, simple) and (not isinstance(part, ast.Call) or _is_pure(part)) for part in inside)


def _names_read(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)} - {"np", "numpy", "math"}


def _names_bound_inside(node: ast.AST) -> set[str]:
    """Return the names that comprehensions, lambdas and functions inside a statement bind."""
    return {part.arg for part in ast.walk(node) if isinstance(part, ast.arg)}


def _choose_variable_name(call: ast.Call, taken: set[str]) -> str:
    word = call.func.attr if isinstance(call.func, ast.Attribute) else "valeur"
    stem = {"inv": "inverse", "cos": "cosinus", "sin": "sinus", "exp": "exponentielle", "sqrt": "racine",
            "norm": "norme", "det": "determinant", "log": "logarithme"}.get(word, f"valeur_{word}")  # fmt: skip
    argument = call.args[0] if call.args else None
    name = f"{stem}_{argument.id}" if isinstance(argument, ast.Name) else stem
    number = 2
    base = name
    while name in taken:
        name, number = f"{base}_{number}", number + 1
    return name
