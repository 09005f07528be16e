"""Needless copies, names that hide a function of Python, an inverse that a solver spares. Pure."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator

from graders.core.advice.edits import Advice, AdviceKind, list_functions, make_advice, replace_expressions

COPY = "Cette copie est de trop : `{inner}` rend déjà un tableau neuf, que rien d’autre ne partage."
NAME = "`{name}` est une fonction de Python : votre variable la cache dans toute la fonction. Un autre nom l’évite."
INVERSE = "Pour multiplier par un inverse, `np.linalg.solve` résout le système sans le former : il arrondit moins."
#: Functions of numpy that return a new array.
FRESH = frozenset({
    "array", "zeros", "ones", "eye", "full", "arange", "linspace", "concatenate", "stack", "vstack", "hstack",
    "column_stack", "cumsum", "outer", "where", "zeros_like", "ones_like", "full_like",
})  # fmt: skip
#: Functions of Python that names often hide, each with a name to use.
HIDDEN = {
    "sum": "somme", "list": "liste", "max": "maximum", "min": "minimum", "len": "longueur", "dict": "dictionnaire",
    "set": "ensemble", "range": "portee", "map": "carte", "filter": "filtre", "round": "arrondi", "input": "entree",
    "id": "numero", "next": "suivant", "type": "sorte", "abs": "valeur_absolue", "pow": "puissance", "tuple": "couple",
    "all": "tous", "any": "un_seul", "iter": "tours", "str": "texte", "int": "entier", "float": "nombre",
}  # fmt: skip


def list_copies(source: str, tree: ast.Module) -> Iterator[Advice]:
    """Yield the copies of arrays that were just made."""
    for node in ast.walk(tree):
        inner = None
        match node:
            case ast.Call(func=ast.Attribute(value=ast.Name(id="np"), attr="array" | "copy"), args=[made], keywords=[]):
                inner = made
            case ast.Call(func=ast.Attribute(value=made, attr="copy"), args=[], keywords=[]):
                inner = made
        if isinstance(node, ast.Call) and isinstance(inner, ast.Call) and _makes_new_array(inner):
            text = ast.get_source_segment(source, inner) or ""
            sentence = COPY.format(inner=ast.unparse(inner.func))
            advice = make_advice(AdviceKind.copy, source, replace_expressions(source, [(node, text)]), sentence)
            if advice is not None:
                yield advice


def _makes_new_array(call: ast.Call) -> bool:
    """Whether a call makes a new array; `copy=False` may not."""
    if any(keyword.arg == "copy" for keyword in call.keywords):
        return False
    match call.func:
        case ast.Attribute(value=ast.Name(id="np"), attr=name):
            return name in FRESH
    return False


def list_hiding_names(source: str, tree: ast.Module, given: Collection[str]) -> Iterator[Advice]:
    """Yield the local variables that hide a function of Python; `given` are the functions that the statement asks."""
    for function in list_functions(tree):
        if any(isinstance(node, ast.FunctionDef | ast.Lambda | ast.Global | ast.Nonlocal) and node is not function
               for node in ast.walk(function)):  # fmt: skip
            continue
        names = [node for node in ast.walk(function) if isinstance(node, ast.Name)]
        args = [node for node in ast.walk(function.args) if isinstance(node, ast.arg)]
        asked = {arg.arg for arg in args} if function.name in given else set()
        bound = {node.id for node in names if isinstance(node.ctx, ast.Store)}
        taken = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} | {arg.arg for arg in args}
        for name in sorted(bound & HIDDEN.keys() - asked):
            other = HIDDEN[name]
            if other in taken or name in {arg.arg for arg in args}:
                continue
            edits = [(node, other) for node in names if node.id == name]
            edited = replace_expressions(source, edits)
            advice = make_advice(AdviceKind.name, source, edited, NAME.format(name=name))
            if advice is not None:
                yield advice


def list_inverses(source: str, tree: ast.Module) -> Iterator[Advice]:
    """Yield the products by an inverse that a solver spares."""
    for node in ast.walk(tree):
        match node:
            case ast.BinOp(left=ast.Call(func=function, args=[matrix], keywords=[]), op=ast.MatMult(), right=right):
                if ast.unparse(function) not in {"np.linalg.inv", "numpy.linalg.inv"}:
                    continue
                text = f"np.linalg.solve({ast.unparse(matrix)}, {ast.unparse(right)})"
                edited = replace_expressions(source, [(node, text)])
                advice = make_advice(AdviceKind.inverse, source, edited, INVERSE)
                if advice is not None:
                    yield advice
