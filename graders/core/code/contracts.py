"""What an exercise promises of each function: what it is given, what it may return, which edges are judged or free.

`code(…, contracts=…)` completes them from the checks and the solution: tolerances are those of comparators, default
values those of the solution. Students read them under the statement; `promises.py` holds them to what the checks really
ask.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from graders.core.code.checks import Cases, Check, Untouched
from graders.core.compare.forms import ValueForm, join_with_and, with_tolerance
from graders.core.syntax_trees import parse_source

#: The types of what programs are given.
PLAIN = "Sauf mention contraire, un nombre est un flottant, et un tableau en contient : c’est un tableau numpy."


@dataclass(frozen=True)
class Boundary:
    """An edge of what a statement asks, in French (« un demi-tour exact »).

    It is judged by a fixed case, of which `holds` tells the arguments; or it is `free`, and the text says what is free.
    """

    words: str
    holds: Callable[..., bool] | None = None
    free: str = ""


class PromiseLine(NamedTuple):
    """A line of what is promised, in French: « Renvoie », « une pose (3,) »."""

    label: str
    text: str


@dataclass(frozen=True)
class FunctionContract:
    """What is promised of one function.

    `takes` are its arguments by name, in order; `returns` is the form of its answer. `defaults` and `untouched` are
    completed from the solution and the checks.
    """

    function: str
    takes: Mapping[str, ValueForm]
    returns: ValueForm
    boundaries: tuple[Boundary, ...] = ()
    relaunched: str = ""
    defaults: tuple[tuple[str, str], ...] = ()
    untouched: bool = False

    def promise_lines(self) -> tuple[PromiseLine, ...]:
        """Return what students are told of it."""
        return tuple(PromiseLine(label, text) for label, text in self._iter_labelled_lines() if text)

    def _iter_labelled_lines(self) -> Iterator[tuple[str, str]]:
        intact = " Vos arguments doivent rester intacts." if self.untouched else ""
        yield "Reçoit", f"{_parameters_text(self.takes)}. {PLAIN}{intact}"
        yield "Sans valeur donnée", join_with_and([f"{name} vaut {value}" for name, value in self.defaults] or [""])
        lasting = " Un résultat renvoyé ne doit plus changer." if self.untouched else ""
        yield "Renvoie", f"{self.returns.description}.{lasting}"
        yield "Convient", self.returns.accepted_alternatives
        yield "Précision", self.returns.precision_text()
        yield "Jugé aussi", " ; ".join(edge.words for edge in self.boundaries if edge.holds)
        yield "Libre", " ; ".join(f"{edge.words} : {edge.free}" for edge in self.boundaries if edge.free)
        yield "Votre fichier", self.relaunched


def _parameters_text(takes: Mapping[str, ValueForm]) -> str:
    """« a et b, une pose (3,) ; L, un nombre »."""
    groups: dict[str, list[str]] = {}
    for name, form in takes.items():
        groups.setdefault(form.description, []).append(name)
    return " ; ".join(f"{join_with_and(names)} : {words}" for words, names in groups.items())


def add_defaults_and_tolerances(
    contracts: Sequence[FunctionContract], checks: Sequence[Check], solution: str
) -> tuple[FunctionContract, ...]:
    """Return the contracts with what the checks and the solution say already."""
    defaults = _read_default_values(solution)
    kept = {name for check in checks if isinstance(check, Untouched) for name in check.functions}
    return tuple(
        replace(
            contract,
            returns=_returns_with_tolerance(contract, checks),
            defaults=tuple(pair for pair in defaults.get(contract.function, ()) if pair[0] in contract.takes),
            untouched=contract.function in kept,
        )
        for contract in contracts
    )


def _returns_with_tolerance(contract: FunctionContract, checks: Sequence[Check]) -> ValueForm:
    """Return the form of the answers with the tolerance of the comparators, where these have one."""
    tolerances = [
        tolerance
        for check in checks
        if isinstance(check, Cases) and check.functions == (contract.function,)
        if (tolerance := getattr(check.compare, "tolerance", None)) is not None
    ]
    return with_tolerance(contract.returns, min(tolerances)) if tolerances else contract.returns


def _read_default_values(solution: str) -> dict[str, tuple[tuple[str, str], ...]]:
    """Return the default values of the functions of a solution, as they are written."""
    found = {}
    for node in parse_source(solution).body:
        if isinstance(node, ast.FunctionDef) and node.args.defaults:
            names = [argument.arg for argument in node.args.args[-len(node.args.defaults) :]]
            values = [ast.unparse(value).replace(".", ",") for value in node.args.defaults]
            found[node.name] = tuple(zip(names, values, strict=True))
    return found
