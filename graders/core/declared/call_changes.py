"""Changes of a program's calls that students make: the other end of a list, a look that removes nothing, a text that is
read as it was typed."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graders.core.alterations.alterations import Alteration
from graders.core.alterations.text import ProgramText

LIST_END, LOOK, RAW_TEXT = "bout de la liste", "élément non retiré", "texte non préparé"
ONCE, SORTED = "valeur déjà là", "valeurs rangées"
#: Calls that remove an element, and the index of that element where they have no argument.
REMOVERS = {"pop": "-1", "popleft": "0", "heappop": "0"}
#: Methods that prepare a text.
TEXT_METHODS = frozenset({"lower", "upper", "casefold", "strip", "lstrip", "rstrip"})


def change_calls(source: str) -> list[Alteration]:
    """Return the program changed at one location each. Raises SyntaxError for an invalid source."""
    text = ProgramText(source)
    changes = [
        (node, other, operator)
        for node in text.iter_alterable_nodes()
        for other, operator in _iter_replacements(text, node)
    ]
    changes.sort(key=lambda change: text.span(change[0]))
    return [
        Alteration(
            source,
            text.apply(text.replace_node(node, other, kind)),
            kind,
            False,
            _first_line(node),
            text.enclosing_function_name(node),
        )
        for node, other, kind in changes
    ]  # fmt: skip


def _first_line(node: ast.AST) -> int:
    return int(node.lineno)  # type: ignore[attr-defined]


def _iter_replacements(text: ProgramText, node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield what stands in place of a call or an index, and the kind of that change."""
    if isinstance(node, ast.Call) and not node.keywords:
        yield from ((other, LOOK) for other in _iter_reads_instead_of_removal(text, node))
        if isinstance(node.func, ast.Attribute):
            owner, method = text.source_of(node.func.value), node.func.attr
            if method in TEXT_METHODS and not node.args:
                yield owner, RAW_TEXT
            if method == "pop" and not node.args:
                yield f"{owner}.pop(0)", LIST_END
            elif method == "pop" and _is_number(node.args[0], 0):
                yield f"{owner}.pop()", LIST_END
            elif method == "append" and len(node.args) == 1:
                value = text.source_of(node.args[0])
                yield f"{owner}.insert(0, {value})", LIST_END
                if isinstance(node.func.value, ast.Attribute) and isinstance(text.parent(node), ast.Expr):
                    yield f"{owner}.append({value}) if {value} not in {owner} else None", ONCE
                    yield f"({owner}.append({value}), {owner}.sort())", SORTED
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        ends = {0: "-1", -1: "0"}
        other = next((word for end, word in ends.items() if _is_number(node.slice, end)), "")
        if other:
            yield f"{text.source_of(node.value)}[{other}]", LIST_END


def _iter_reads_instead_of_removal(text: ProgramText, call: ast.Call) -> Iterator[str]:
    """Yield what looks at the element that a call removes, where its value is used; elsewhere the call is dropped."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name not in REMOVERS or isinstance(text.parent(call), ast.Expr):
        return
    given = [text.source_of(argument) for argument in call.args]
    if name == "heappop":
        owners, indices = given[:1], given[1:]
    else:
        owners, indices = [text.source_of(part.value) for part in [call.func] if isinstance(part, ast.Attribute)], given
    if owners and len(indices) <= 1:
        yield f"{owners[0]}[{indices[0] if indices else REMOVERS[name]}]"


def _is_number(node: ast.AST, number: int) -> bool:
    return isinstance(node, ast.Constant | ast.UnaryOp) and ast.unparse(node) == str(number)
