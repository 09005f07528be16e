"""Changes of a student's program at one place that may mend it: mistakes of the catalogue undone, then any other.

A change proves nothing: `mending` runs the changed programs.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

from graders.core.alterations import alterations, reversals
from graders.core.alterations.text import Change, ProgramText
from graders.core.code.mutations import Model
from graders.core.code.repairs import MAX_SOURCE, find_repairs
from graders.core.code.variants import NOTE

#: Changes of one program; repairs of one mistake of the catalogue.
MAX_CHANGES, MAX_REPAIRS = 2500, 25
#: The call by which each loop of a changed program counts its turns.
TURN = "_tour()"
_LIKELY = (*alterations.RULES, *reversals.LIKELY)


@dataclass(frozen=True)
class ProgramChange:
    """A changed program and the first changed line of the original.

    In `text_with_counters` its loops count their turns. `operator` says what kind of thing was changed, `mistake` is
    the id of the undone mistake of the catalogue, if any, which may change `further_lines`. A change that
    `is_unlikely` is of a kind that may make up for a mistake of another line.
    """

    text: str
    text_with_counters: str
    line: int
    operator: str
    mistake: str = ""
    further_lines: tuple[int, ...] = ()
    is_unlikely: bool = False


def find_changes(
    source: str,
    functions: Sequence[str],
    model: Model | None,
    is_time_spent: Callable[[], bool],
    excluded: Collection[str] = (),
) -> list[ProgramChange]:
    """Return the changes of a program that may mend these functions, the likeliest first; none of one too long.

    Functions that are `apart` are left as they are, though these call them.
    """
    if len(source) > MAX_SOURCE:
        return []
    text = ProgramText.parse_or_none(source)
    if text is None:
        return []
    nodes = sorted(_iter_reachable_nodes(text, functions, excluded), key=lambda node: getattr(node, "lineno", 0))
    lines = {getattr(node, "lineno", 0) for node in nodes}
    undone = (
        change
        for change in _iter_mistake_repairs(source, functions, model, is_time_spent)
        if lines.issuperset((change.line, *change.further_lines))
    )
    changes: dict[str, ProgramChange] = {}
    for change in itertools.islice(itertools.chain(undone, _iter_rule_changes(text, nodes)), MAX_CHANGES):
        changes.setdefault(change.text, change)
    return list(changes.values())


def _iter_mistake_repairs(
    source: str, functions: Sequence[str], model: Model | None, spent: Callable[[], bool]
) -> Iterator[ProgramChange]:
    for mistake in dict.fromkeys(edit.id for edit in model.edits) if model else ():
        repairs = find_repairs(model, mistake, functions, source, spent) if model else iter(())
        for repair in itertools.islice(repairs, MAX_REPAIRS):
            first, *others = repair.lines
            yield ProgramChange(repair.text, add_loop_counters(repair.text), first, "", mistake, tuple(others))


def _iter_rule_changes(text: ProgramText, nodes: Sequence[ast.AST]) -> Iterator[ProgramChange]:
    counters = locate_loop_counters(text)
    for rules in (_LIKELY, reversals.UNLIKELY):
        for node in nodes:
            for rule in rules:
                for change in rule(text, node):
                    line = text.raw.count(b"\n", 0, change.start) + 1
                    counted = _apply_with_counters(text, change, counters)
                    yield ProgramChange(
                        text.apply(change), counted, line, change.operator, is_unlikely=rules is reversals.UNLIKELY
                    )


def _iter_reachable_nodes(text: ProgramText, functions: Sequence[str], apart: Collection[str]) -> Iterator[ast.AST]:
    """Yield the nodes of these functions, of those that they call but those `apart`, and of the top level."""
    every = {node.name: node for node in text.tree.body if isinstance(node, ast.FunctionDef)}
    defined = {name: node for name, node in every.items() if name not in apart}
    reached, waiting = set[str](), [name for name in functions if name in defined]
    while waiting:
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            names = {node.id for node in ast.walk(defined[name]) if isinstance(node, ast.Name)}
            waiting += names & defined.keys() - reached
    others = {node for name, node in every.items() if name not in reached}
    left_out = {part for node in others for part in ast.walk(node)}
    yield from (node for node in text.iter_alterable_nodes() if node not in left_out)


def locate_loop_counters(text: ProgramText) -> list[tuple[int, bytes]]:
    """Return where the loops of a program count their turns: byte offsets and texts, in order."""
    counters = []
    for node in ast.walk(text.tree):
        if isinstance(node, ast.For | ast.While):
            first = node.body[0]
            start = text.span(first)[0]
            is_simple = not isinstance(
                first, ast.If | ast.For | ast.While | ast.With | ast.Try | ast.FunctionDef | ast.ClassDef | ast.Match
            )
            end = "; " if is_simple else "\n" + " " * first.col_offset
            counters.append((start, f"{TURN}{end}".encode()))
    return sorted(counters)


def insert_variable_recorder(source: str, line: int) -> tuple[str, list[str]] | None:
    """Return a program that notes its variables where a line begins, and the variables that the line reads or sets.

    None where no simple statement begins there.
    """
    text = ProgramText.parse_or_none(source)
    if text is None:
        return None
    statement = next(
        (
            node
            for node in ast.walk(text.tree)
            if isinstance(node, ast.Assign | ast.AugAssign | ast.Return | ast.Expr) and node.lineno == line
        ),
        None,
    )
    if statement is None:
        return None
    start = text.span(statement)[0]
    counters = [(start, f"{NOTE}; ".encode())]
    read = sorted((node for node in ast.walk(statement) if isinstance(node, ast.Name)), key=text.span)
    names = [node.id for node in read]
    known = [name for name in dict.fromkeys(names) if name in text.visible_variable_names(statement)]
    return insert_with_loop_counters(text, counters), known


def insert_with_loop_counters(text: ProgramText, added: Sequence[tuple[int, bytes]]) -> str:
    """Return a program whose loops count their turns, with further texts at these byte offsets."""
    return _apply_with_counters(
        text, Change(0, 0, "", ""), sorted([*locate_loop_counters(text), *added], key=lambda pair: pair[0])
    )


def add_loop_counters(source: str) -> str:
    """Return a program whose loops count their turns; as it is where it does not parse."""
    text = ProgramText.parse_or_none(source)
    if text is None:
        return source
    return _apply_with_counters(text, Change(0, 0, "", ""), locate_loop_counters(text))


def _apply_with_counters(text: ProgramText, change: Change, counters: Sequence[tuple[int, bytes]]) -> str:
    """Return a changed program whose loops count their turns, but for those within the change."""
    pieces, last = [], 0
    kept = [(at, at, added) for at, added in counters if not change.start < at < change.end]
    for start, end, new in sorted([*kept, (change.start, change.end, change.text.encode())], key=lambda edit: edit[:2]):
        pieces += [text.raw[last:start], new]
        last = end
    return b"".join([*pieces, text.raw[last:]]).decode()
