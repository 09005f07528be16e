"""Rewriting of a program in the form that a student would give it: other names, other habits, the same answers.

The seed decides the form, so that two readers see two programs and one reader always sees the same. What a program
answers does not change: only local variables and helper functions get other names, an assignment of several names
becomes several assignments where their order is free, and a returned expression may be stored first.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from graders.core.syntax_trees import parse_source

#: Names that students give to what the course's programs name otherwise.
SYNONYMS: Mapping[str, tuple[str, ...]] = {
    "c": ("co", "cosinus", "ct"), "s": ("si", "sinus", "st"), "x": ("px", "xx"), "y": ("py", "yy"),
    "dx": ("delta_x", "ecart_x"), "dy": ("delta_y", "ecart_y"), "theta": ("th", "angle", "cap"), "A": ("M", "mat"),
    "n": ("N", "nb", "taille"), "B": ("M2", "mat_b"), "d": ("dist", "delta"), "H": ("mat_h", "Hk"), "w": ("p", "poids"),
    "cap": ("direction", "angle"), "J": ("jac", "Jac"), "S": ("mat_s", "Sk"), "R": ("rot", "Rot"), "t": ("tr", "trans"),
    "K": ("gain_k", "k_gain"), "ecarts": ("diff", "deltas"), "poids": ("w", "ws"), "moyenne": ("moy", "m"),
    "i": ("k", "idx"), "j": ("m", "jj"), "k": ("i", "num"), "somme": ("total", "S"), "resultat": ("res", "sortie"),
    "total": ("somme", "tot"), "nouvelles": ("res", "nouv"), "nouvelle": ("res", "nouv"), "angle": ("a", "alpha"),
    "ramener": ("normaliser", "mod_angle", "replier"), "e": ("err", "erreur"), "p": ("pt", "centre_p"),
    "q": ("qt", "centre_q"), "U": ("u", "mat_u"), "Vt": ("vt", "V_t"), "V": ("v", "mat_v"), "D": ("diag", "dd"),
    "distance": ("d", "dist"), "valeurs": ("vals", "liste"), "variance": ("var", "v2"), "m": ("moy", "mu"),
}  # fmt: skip
#: A name that has no synonym is cut to so many letters by some students, if it has two more.
SHORT_NAME = 4
MEANINGLESS = ("res", "resultat", "sortie", "rep")


def rewrite_as_student_form(source: str, function: str, seed: int, *, public: Collection[str] = ()) -> str:
    """Return the part of a program that `function` needs, as a student would write it.

    Of a name that is defined twice at the top level, the last definition counts. `public` names keep theirs.
    """
    rng = np.random.default_rng(seed)
    body = _statements_needed_by(parse_source(source).body, function)
    taken = _all_names(body) | set(dir(builtins)) | {"np", "math"}
    helpers = [node.name for node in body if isinstance(node, ast.FunctionDef) and node.name not in {function, *public}]
    new_helpers = _draw_new_names(helpers, taken, rng)
    stores = bool(rng.integers(2))
    splits = bool(rng.integers(4))
    functions = [_rewrite_statement(node, taken, new_helpers, rng, stores=stores, splits=splits) for node in body]
    lines = [ast.unparse(ast.fix_missing_locations(node)) for node in functions]
    joints = ["\n\n\n" if isinstance(node, ast.FunctionDef | ast.ClassDef) else "\n" for node in functions[1:]]
    return "".join(text for pair in zip(lines, [*joints, "\n"], strict=True) for text in pair)


def _statements_needed_by(body: Sequence[ast.stmt], function: str) -> list[ast.stmt]:
    """Return the statements at the top level on which a function may depend, each name by its last definition."""
    last: dict[str, ast.stmt] = {}
    for node in body:
        for name in _iter_defined_names(node):
            last[name] = node
    names, needed = [function], set[int]()
    while names:
        definition = last.get(names.pop())
        if definition is not None and id(definition) not in needed:
            needed.add(id(definition))
            names += _all_names([definition])
    return [node for node in body if id(node) in needed]


def _iter_defined_names(node: ast.stmt) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.Import | ast.ImportFrom):
        yield from (name.asname or name.name.partition(".")[0] for name in node.names)
    else:
        yield from (n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))


def _all_names(body: Sequence[ast.stmt]) -> set[str]:
    """Return all names of some statements: variables, arguments, attributes, keywords."""
    found = set()
    for node in body:
        for part in ast.walk(node):
            found |= {
                text
                for field in ("id", "name", "arg", "attr", "asname")
                if isinstance(text := getattr(part, field, None), str)
            }
    return found


def _draw_new_names(names: Sequence[str], taken: set[str], rng: np.random.Generator) -> dict[str, str]:
    """Return another name for each, none of them taken; the new ones are added to those that are."""
    drawn = {}
    for name in names:
        ways = [*SYNONYMS.get(name, ())]
        rng.shuffle(ways)
        ways += [name[:SHORT_NAME]] if len(name) > SHORT_NAME + 1 and rng.integers(2) else [name]
        new = next((way for way in ways if way not in taken), name)
        taken.add(new)
        drawn[name] = new
    return drawn


def _rewrite_statement(
    node: ast.stmt, taken: set[str], helpers: Mapping[str, str], rng: np.random.Generator, *, stores: bool, splits: bool
) -> ast.stmt:
    if not isinstance(node, ast.FunctionDef):
        _Renamer(helpers).visit(node)
        return node
    used = set(taken)
    locals_ = _local_names(node)
    renaming = _Renamer({**helpers, **_draw_new_names(locals_, used, rng)})
    result = next((word for word in MEANINGLESS if word not in used), "") if stores else ""
    renaming.visit(node)
    _StudentHabits(result, splits=splits).visit(node)
    if ast.get_docstring(node) is not None and len(node.body) > 1:
        node.body = node.body[1:]
    return node


def _local_names(node: ast.FunctionDef) -> list[str]:
    """Return the variables of a function that it alone has: no argument of it or of a function inside."""
    arguments = {argument.arg for argument in ast.walk(node) if isinstance(argument, ast.arg)}
    outer = {name for part in ast.walk(node) if isinstance(part, ast.Global | ast.Nonlocal) for name in part.names}
    inner = {part.name for part in ast.walk(node) if isinstance(part, ast.FunctionDef) and part is not node}
    stored = (
        part.id
        for part in ast.walk(node)
        if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store) and part.id not in arguments | outer | inner
    )
    return list(dict.fromkeys(stored))


class _Renamer(ast.NodeTransformer):
    """Gives variables and functions their other names."""

    def __init__(self, names: Mapping[str, str]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.AST:
        node.id = self._names.get(node.id, node.id)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.name = self._names.get(node.name, node.name)
        node.returns = None
        return self.generic_visit(node)


class _StudentHabits(ast.NodeTransformer):
    """Stores what is returned under a name, and assigns one name a line."""

    def __init__(self, result: str, *, splits: bool) -> None:
        self._result, self._splits = result, splits

    def visit_Return(self, node: ast.Return) -> ast.AST | list[ast.stmt]:
        if not self._result or node.value is None or isinstance(node.value, ast.Name | ast.Constant):
            return node
        stored = ast.Assign([ast.Name(self._result, ast.Store())], node.value)
        return [stored, ast.Return(ast.Name(self._result, ast.Load()))]

    def visit_Assign(self, node: ast.Assign) -> ast.AST | list[ast.stmt]:
        pair = _MultipleAssignment.from_node(node) if self._splits else None
        return node if pair is None or not pair.is_free else pair.assignments


class _MultipleAssignment:
    """An assignment of several names at once, `a, b = f, g`."""

    def __init__(self, targets: Sequence[ast.Name], values: Sequence[ast.expr]) -> None:
        self._targets, self._values = targets, values

    @classmethod
    def from_node(cls, node: ast.Assign) -> _MultipleAssignment | None:
        target = node.targets[0]
        if len(node.targets) != 1 or not isinstance(target, ast.Tuple) or not isinstance(node.value, ast.Tuple):
            return None
        names = [item for item in target.elts if isinstance(item, ast.Name)]
        stars = any(isinstance(item, ast.Starred) for item in node.value.elts)
        return None if stars or len(names) != len(target.elts) else cls(names, node.value.elts)

    @cached_property
    def is_free(self) -> bool:
        """Whether no value reads a name that is assigned before it."""
        before: set[str] = set()
        for target, value in zip(self._targets, self._values, strict=True):
            if before & {part.id for part in ast.walk(value) if isinstance(part, ast.Name)}:
                return False
            before.add(target.id)
        return True

    @property
    def assignments(self) -> list[ast.stmt]:
        return [ast.Assign([target], value) for target, value in zip(self._targets, self._values, strict=True)]
