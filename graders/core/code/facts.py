"""Facts that a failed submission establishes by itself, told with or without a name for its mistake.

A fact is read in the verdict's own failed checks (a returned None, a modified argument, values right to some digits
only), or in the file where these bear it out (a default value). Its words claim no more.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from graders.core.code.checks import Check
from graders.core.compare.slips import SLIPS, Slip
from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome
from graders.core.syntax_trees import evaluate_literal, parse_or_none
from graders.typography import elided

MODIFIED_ARGUMENT, NOTHING, SHORT, IMPRECISE = "argument_modifie", "sans_retour", "simple_precision", "precision_perdue"
NO_DEFAULT, OTHER_DEFAULT = "defaut_manquant", "defaut_different"
IMPRECISIONS = (SHORT, IMPRECISE)
#: Relative error up to which values count as right to some digits only.
NEARLY_RIGHT = 1e-4
#: What a title says already, by fact: it is then not told a second time.
_ALREADY_TOLD = {
    MODIFIED_ARGUMENT: "modifi|écras|sur place",
    NOTHING: "renvoie rien|return|None|ne renvoie pas",
    SHORT: "précision|arrondi",
    IMPRECISE: "précision|arrondi|chiffres",
    NO_DEFAULT: "défaut",
    OTHER_DEFAULT: "défaut",
}
_SHORT_TYPES = re.compile(r"\b(float32|float16|single|half)\b|['\"][<>=]?f[24]['\"]")

Failed = Sequence[tuple[Check, Finding]]


@dataclass(frozen=True)
class Fact:
    """A fact in words, and the ids of the failed checks that it explains."""

    slip: Slip
    checks: tuple[str, ...]


def find_facts(failed: Failed, source: bytes, solution: str, named_titles: Sequence[str]) -> list[Fact]:
    """Return the facts that these failed checks establish, but those that one of the titles tells already."""
    text = source.decode("utf-8-sig", "replace")
    defaults = _defaults_by_function(solution)
    is_read = bool(defaults) or any(finding.cause is Outcome.INVALID_OUTPUT for _, finding in failed)
    mine = _functions_by_name(text) if is_read else {}
    facts = [
        *_iter_modified_argument_facts(failed),
        *_iter_missing_return_facts(failed, mine),
        *_iter_default_value_facts(failed, mine, defaults),
    ]
    if not facts:
        facts += _iter_lost_precision_facts(failed, text)
    return [fact for fact in facts if not is_stated_in_titles(fact, named_titles)]


def is_stated_in_titles(fact: Fact, titles: Iterable[str]) -> bool:
    """Whether one of the titles of mistakes says what a fact does."""
    return any(re.search(_ALREADY_TOLD[fact.slip.id], title, re.IGNORECASE) for title in titles)


def _functions_by_name(text: str) -> Mapping[str, ast.FunctionDef]:
    tree = parse_or_none(text)
    return {node.name: node for node in (tree.body if tree else ()) if isinstance(node, ast.FunctionDef)}


@cache
def _defaults_by_function(solution: str) -> Mapping[str, Mapping[str, str]]:
    """Return the default values of the functions that have some, by parameter."""
    values = {name: _default_values(function) for name, function in _functions_by_name(solution).items()}
    return {name: defaults for name, defaults in values.items() if defaults}


def _iter_modified_argument_facts(failed: Failed) -> Iterator[Fact]:
    checks = tuple(check.id for check, finding in failed if finding.slip == MODIFIED_ARGUMENT)
    if checks:
        yield Fact(SLIPS[MODIFIED_ARGUMENT], checks)


def _iter_missing_return_facts(failed: Failed, functions: Mapping[str, ast.FunctionDef]) -> Iterator[Fact]:
    """A function that returned None: it has no `return` at all, or reached none."""
    seen: dict[str, list[str]] = {}
    for check, finding in failed:
        if len(check.functions) == 1 and finding.cause is Outcome.INVALID_OUTPUT and _got_none(finding):
            seen.setdefault(check.functions[0], []).append(check.id)
    for name in sorted(seen.keys() & functions.keys()):
        returns = [node for node in ast.walk(functions[name]) if isinstance(node, ast.Return) and node.value]
        title = f"{name} ne renvoie rien" + (" dans certains cas" if returns else "")
        explanation = (
            f"{name} arrive à sa dernière ligne sans avoir rencontré de « return », et renvoie alors None."
            if returns
            else f"Il n'y a pas de « return » suivi d'une valeur dans {name} : elle renvoie None. Afficher un résultat "
            "avec print, ou le garder dans une variable, n'est pas le renvoyer."
        )
        yield Fact(replace(SLIPS[NOTHING], title=title, explanation=explanation), tuple(seen[name]))


def _got_none(finding: Finding) -> bool:
    example = finding.result.counterexample
    return example is not None and example.got is None and "None" in finding.result.message


def _iter_default_value_facts(
    failed: Failed, mine: Mapping[str, ast.FunctionDef], asked: Mapping[str, Mapping[str, str]]
) -> Iterator[Fact]:
    for name in sorted(mine.keys() & asked.keys()):
        given, parameters = _default_values(mine[name]), {argument.arg for argument in mine[name].args.args}
        messages = {
            check.id: finding.result.message
            for check, finding in failed
            if name in check.functions and finding.cause is Outcome.RUNTIME_ERROR
        }
        for parameter, wanted in asked[name].items():
            if parameter in parameters and parameter not in given:
                told = re.compile(rf"appel (?:de |d’){name}\s:[^.]*\b{parameter}\b")
                missed = tuple(check for check, said in messages.items() if told.search(said))
                if missed:
                    yield Fact(_missing_default_slip(name, parameter, wanted), missed)
            elif parameter in given and _parse_number(given[parameter]) not in (None, _parse_number(wanted)):
                blamed = tuple(check.id for check, _ in failed if check.functions == (name,))
                if blamed:
                    yield Fact(_different_default_slip(name, parameter, given[parameter]), blamed)


def _missing_default_slip(name: str, parameter: str, wanted: str) -> Slip:
    return Slip(
        NO_DEFAULT,
        f"La valeur par défaut de {parameter} manque",
        f"{name} est appelée aussi sans {parameter}, qui vaut alors {wanted}. Cela s'écrit dans la ligne « def », à "
        "côté du nom du paramètre.",
        f"Comment dit-on, dans « def {name}(...) », ce que vaut un paramètre qu'on ne donne pas ?",
    )


def _different_default_slip(name: str, parameter: str, given: str) -> Slip:
    return Slip(
        OTHER_DEFAULT,
        f"La valeur par défaut de {parameter} n'est pas celle de l'énoncé",
        f"Quand {parameter} n'est pas donné, il vaut {given} chez vous : relisez l'énoncé.",
        f"Que dit l'énoncé {elided('de', parameter)}, quand on appelle {name} sans le donner ?",
    )


def _default_values(function: ast.FunctionDef) -> dict[str, str]:
    arguments = function.args.args
    defaults = function.args.defaults
    pairs = zip(arguments[len(arguments) - len(defaults) :], defaults, strict=True)
    return {argument.arg: ast.unparse(value) for argument, value in pairs}


def _parse_number(text: str) -> float | None:
    try:
        return float(evaluate_literal(text))
    except (ValueError, TypeError, SyntaxError):
        return None


def _iter_lost_precision_facts(failed: Failed, text: str) -> Iterator[Fact]:
    """Values that are right to some digits only, in each failed check that compares numbers."""
    numeric = [finding for _, finding in failed if finding.cause is Outcome.WRONG_ANSWER and finding.slip != "memoire"]
    errors = [_relative_error(finding) for finding in numeric]
    if not errors or len(errors) < len(failed) or any(error is None or error > NEARLY_RIGHT for error in errors):
        return
    yield Fact(SLIPS[SHORT] if _SHORT_TYPES.search(text) else SLIPS[IMPRECISE], tuple(check.id for check, _ in failed))


def _relative_error(finding: Finding) -> float | None:
    """Return the largest relative error of a counterexample; None where it does not compare numbers."""
    example = finding.result.counterexample
    expected, got = (
        _flatten_numbers(value) for value in ((example.expected, example.got) if example else (None, None))
    )
    if not expected or len(expected) != len(got or ()):
        return None
    wanted, obtained = np.array(expected), np.array(got)
    if not np.all(np.isfinite(wanted)) or not np.all(np.isfinite(obtained)) or np.array_equal(wanted, obtained):
        return None
    with np.errstate(over="ignore"):  # a program may return numbers beyond every other
        return float(np.max(np.abs(obtained - wanted)) / max(1e-9, float(np.max(np.abs(wanted)))))


def _flatten_numbers(value: Any) -> list[float] | None:
    """Return the numbers of a JSON value, in order; None where it holds anything else."""
    if isinstance(value, bool) or value is None or isinstance(value, str | dict):
        return None
    if isinstance(value, int | float):
        return [float(value)]
    numbers: list[float] = []
    for item in value:
        inner = _flatten_numbers(item)
        if inner is None:
            return None
        numbers += inner
    return numbers
