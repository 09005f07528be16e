"""What a declared exercise is: its functions, checks, rules, solution and known mistakes, read from plain data.

The same data is a TOML file in a course's folder and a record of a teacher's library; `to_data` gives it back.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.plain_values import SamePlainValue
from graders.core.contract.values import Value
from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared.case_reading import parse_expected, parse_scenario
from graders.core.declared.draws_reading import parse_draws
from graders.core.declared.generators import Draws, Variables
from graders.core.declared.imports import Imports, read_imports
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.rules import Rule
from graders.core.declared.scenarios import PROGRAM, Scenario
from graders.core.declared.tolerances import CaseTolerance

FUNCTION = re.compile(r"[^\W\d]\w*")
IDENTITY = re.compile(r"[a-z0-9_]+")
#: Bounds of a declaration: checks, cases of one, draws of one, mistakes, characters of a program, of a text.
MAX_CHECKS, MAX_CASES, MAX_DRAWS, MAX_MISTAKES, MAX_PROGRAM, MAX_WORDS = 12, 60, 60, 20, 20_000, 2000
DEFAULT_DRAWS = 12
Watched = Literal["value", "printed", "written"]


@dataclass(frozen=True)
class DrawnCase:
    """The values of drawn variables, and the case that they make."""

    variables: Variables
    scenario: Scenario


@dataclass(frozen=True)
class DrawnCases:
    """Cases made of drawn variables: `call` is a case in which the variables stand for their values."""

    draws: Draws
    call: str
    count: int
    functions: tuple[str, ...]
    imports: Imports = field(default_factory=dict)

    def make_case(self, variables: Variables) -> DrawnCase:
        read = parse_scenario(self.call, self.functions, variables=variables, imports=self.imports)
        return DrawnCase(variables, Scenario(read))

    def draw(self, rng: np.random.Generator) -> Iterator[DrawnCase]:
        """Yield the cases of one grading."""
        for _ in range(self.count):
            yield self.make_case(self.draws.draw(rng))

    def iter_simpler_cases(self, case: DrawnCase) -> Iterator[DrawnCase]:
        """Yield allowed cases that are simpler in one variable."""
        return map(self.make_case, self.draws.iter_simpler_variables(case.variables))


@dataclass(frozen=True)
class DeclaredCheck:
    """A check: cases written by hand, then drawn ones, compared with the solution's answers.

    `tolerance`, where there is one, depends on the case: see `with_tolerance_of_case`.
    """

    id: str
    title: str
    points: float
    hint: str
    cases: tuple[Scenario, ...]
    drawn: DrawnCases | None
    comparator: SamePlainValue
    watched: Watched = "value"
    tolerance: CaseTolerance | None = None

    def with_tolerance_of_case(self, case: Scenario) -> DeclaredCheck:
        """Return the check with the tolerance of a case, where that depends on what the case gives."""
        if self.tolerance is None:
            return self
        return replace(self, comparator=replace(self.comparator, tolerance=self.tolerance.tolerance_of_scenario(case)))


@dataclass(frozen=True)
class DeclaredMistake:
    """A known mistake: a program that makes it, and its words."""

    id: str
    title: str
    explanation: str
    question: str
    program: str


@dataclass(frozen=True)
class Declaration:
    """A declared exercise."""

    functions: tuple[str, ...]
    checks: tuple[DeclaredCheck, ...]
    rules: tuple[Rule, ...]
    solution: str
    mistakes: tuple[DeclaredMistake, ...]
    data: Mapping[str, Any] = field(compare=False)

    @cached_property
    def imported_names(self) -> dict[str, tuple[str, str]]:
        """The names that the solution imports: cases may use them."""
        return read_imports(self.solution)

    @property
    def is_program(self) -> bool:
        """Whether the student writes a whole program."""
        return is_whole_program(self.functions)


class _TableReader:
    """The members of one table, each taken once; at the end of the block, one that is left is an error."""

    def __init__(self, data: object, place: str) -> None:
        if not isinstance(data, dict):
            raise MalformedDeclaration("il faut une table", place)
        self._left, self.place = dict(data), place

    def __enter__(self) -> _TableReader:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if error is None and self._left:
            raise MalformedDeclaration(f"clé inconnue : « {min(self._left)} »", self.place)

    def place_of(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key

    def read_text(self, key: str, default: str | None = None, *, longest: int = MAX_WORDS) -> str:
        value = self._left.pop(key, default)
        if not isinstance(value, str):
            reason = "il manque ce texte" if value is None else "il faut un texte"
            raise MalformedDeclaration(reason, self.place_of(key))
        if len(value) > longest:
            raise MalformedDeclaration(f"{len(value)} caractères ; {longest} au plus", self.place_of(key))
        return value

    def read_number(self, key: str, default: float) -> float:
        value = self._left.pop(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1e12:
            raise MalformedDeclaration("il faut un nombre positif", self.place_of(key))
        return float(value)

    def read_expression(self, key: str) -> str:
        """Return a text in place of a number; empty for a number."""
        return self.read_text(key) if isinstance(self._left.get(key), str) else ""

    def read_flag(self, key: str, default: bool) -> bool:
        value = self._left.pop(key, default)
        if not isinstance(value, bool):
            raise MalformedDeclaration("il faut true ou false", self.place_of(key))
        return value

    def read_choice(self, key: str, options: Mapping[str, Any], default: str) -> Any:
        value = self.read_text(key, default)
        if value not in options:
            raise MalformedDeclaration(f"« {value} » : {', '.join(options)}", self.place_of(key))
        return options[value]

    def read_texts(self, key: str, *, most: int) -> tuple[str, ...]:
        values = self._left.pop(key, [])
        if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
            raise MalformedDeclaration("il faut une liste de textes", self.place_of(key))
        if len(values) > most:
            raise MalformedDeclaration(f"{len(values)} éléments ; {most} au plus", self.place_of(key))
        return tuple(values)

    def read_tables(self, key: str, *, most: int) -> list[tuple[str, object]]:
        values = self._left.pop(key, [])
        if not isinstance(values, list) or len(values) > most:
            raise MalformedDeclaration(f"il faut au plus {most} tables", self.place_of(key))
        return [(f"{self.place_of(key)}[{index}]", value) for index, value in enumerate(values)]

    def read_files(self, key: str) -> tuple[tuple[str, str], ...]:
        values = self._left.pop(key, {})
        if not isinstance(values, dict) or not all(isinstance(it, str) for pair in values.items() for it in pair):
            raise MalformedDeclaration("il faut des noms de fichiers et leurs textes", self.place_of(key))
        return tuple(values.items())

    def read_lines(self, key: str) -> tuple[str, ...] | None:
        return self.read_texts(key, most=MAX_CASES) if key in self._left else None


_ORDERS = {"oui": "same", "non": "any", "ensemble": "set"}
_WATCHED: dict[str, Watched] = {"valeur": "value", "affichage": "printed", "fichiers": "written"}


def is_whole_program(functions: Sequence[str]) -> bool:
    """Whether a student's file is run whole, and none of its functions is called."""
    return tuple(functions) == (PROGRAM,)


def read_declaration(data: Mapping[str, Any]) -> Declaration:
    """Read a declaration. Raises MalformedDeclaration, with the place of what is wrong."""
    with _TableReader(dict(data), "") as table:
        functions = table.read_texts("fonctions", most=MAX_CHECKS)
        if not functions or not all(FUNCTION.fullmatch(name) for name in functions):
            raise MalformedDeclaration("au moins une fonction, par son nom", "fonctions")
        solution = table.read_text("solution", longest=MAX_PROGRAM)
        imports = read_imports(solution)
        checks = tuple(
            _read_check(*entry, functions, solution, imports)
            for entry in table.read_tables("verifications", most=MAX_CHECKS)
        )
        rules = (
            *_read_rules(table.read_texts("interdits", most=MAX_CASES), "interdits", required=False),
            *_read_rules(table.read_texts("demandes", most=MAX_CASES), "demandes", required=True),
        )
        mistakes = tuple(_read_mistake(*entry) for entry in table.read_tables("erreurs", most=MAX_MISTAKES))
    _require_distinct([check.id for check in checks], "verifications")
    _require_distinct([mistake.id for mistake in mistakes], "erreurs")
    total = sum(check.points for check in checks)
    if abs(total - MAX_POINTS) > 1e-9:
        raise MalformedDeclaration(f"les points font {total:g} ; il en faut {MAX_POINTS:g}", "verifications")
    return Declaration(functions, checks, rules, solution, mistakes, dict(data))


def _read_check(place: str, data: object, functions: tuple[str, ...], solution: str, imports: Imports) -> DeclaredCheck:
    with _TableReader(data, place) as table:
        identity = _read_identifier(table)
        lines, files = table.read_lines("entrees"), table.read_files("fichiers")
        written = table.read_texts("cas", most=MAX_CASES)
        expected = table.read_texts("attendus", most=MAX_CASES) or ("",) * len(written)
        if len(expected) != len(written):
            raise MalformedDeclaration(f"{len(expected)} pour {len(written)} cas", f"{place}.attendus")
        cases = tuple(
            Scenario(_read_case(text, functions, imports, f"{place}.cas[{index}]"), lines, files)
            for index, text in enumerate(written)
        )
        drawn = _read_drawn_cases(table, functions, imports)
        prints = is_whole_program(functions) and all(case.ends_with_program for case in cases)
        watched = table.read_choice("regarder", _WATCHED, "affichage" if prints else "valeur")
        cases = tuple(
            replace(
                case, lines=() if lines is None and watched == "written" else lines,
                expected=_read_expected(answer, watched, f"{place}.attendus[{index}]"),
            )
            for index, (case, answer) in enumerate(zip(cases, expected, strict=True))
        )  # fmt: skip
        if not cases and drawn is None:
            raise MalformedDeclaration("il faut au moins un cas, ou des tirages", place)
        tolerance = table.read_expression("tolerance")
        comparator = SamePlainValue(
            tolerance=TOLERANCE if tolerance else table.read_number("tolerance", TOLERANCE),
            absolute=table.read_flag("absolue", False),
            order=table.read_choice("ordre", _ORDERS, "oui"),
            strict=table.read_flag("types_stricts", False),
            spaces=table.read_flag("espaces", True),
        )
        title, hint = table.read_text("titre"), table.read_text("indice", "")
        return DeclaredCheck(
            identity, title, table.read_number("points", MAX_POINTS), hint, cases, drawn, comparator, watched,
            _read_tolerance(tolerance, solution, table.place_of("tolerance")),
        )  # fmt: skip


def _read_drawn_cases(table: _TableReader, functions: tuple[str, ...], imports: Imports) -> DrawnCases | None:
    text, call = table.read_text("tirages", ""), table.read_text("appel", "")
    conditions, count = table.read_texts("conditions", most=MAX_CASES), int(table.read_number("combien", DEFAULT_DRAWS))
    if not text and not call:
        return None
    if not (text and call):
        raise MalformedDeclaration("« tirages » et « appel » vont ensemble", table.place)
    if not 0 < count <= MAX_DRAWS:
        raise MalformedDeclaration(f"de 1 à {MAX_DRAWS}", table.place_of("combien"))
    try:
        drawn = DrawnCases(parse_draws(text, conditions), call, count, functions, imports)
        next(drawn.draw(np.random.default_rng(0)))
    except MalformedDeclaration as error:
        raise error.below_place(table.place_of("tirages")) from error
    return drawn


def _read_case(text: str, functions: tuple[str, ...], imports: Imports, place: str) -> Any:
    try:
        return parse_scenario(text, functions, imports=imports)
    except MalformedDeclaration as error:
        raise error.below_place(place) from error


def _read_expected(text: str, watched: Watched, place: str) -> tuple[Value, ...]:
    """Return what a case must give, where it is said: none for an empty text.

    Of what is printed, a text need not be quoted.
    """
    if not text.strip():
        return ()
    try:
        expected = parse_expected(text)
    except MalformedDeclaration as error:
        if watched == "printed":
            return (text,)
        raise error.below_place(place) from error
    return (expected if watched != "printed" or isinstance(expected, str) else text,)


def _read_tolerance(text: str, solution: str, place: str) -> CaseTolerance | None:
    try:
        return CaseTolerance.read(text, solution) if text else None
    except MalformedDeclaration as error:
        raise error.below_place(place) from error


def _read_rules(words: Sequence[str], place: str, *, required: bool) -> Iterator[Rule]:
    for index, word in enumerate(words):
        try:
            yield Rule.read(word, required=required)
        except MalformedDeclaration as error:
            raise error.below_place(f"{place}[{index}]") from error


def _read_mistake(place: str, data: object) -> DeclaredMistake:
    with _TableReader(data, place) as table:
        return DeclaredMistake(
            _read_identifier(table),
            table.read_text("titre"),
            table.read_text("explication"),
            table.read_text("question"),
            table.read_text("programme", longest=MAX_PROGRAM),
        )


def _read_identifier(table: _TableReader) -> str:
    identity = table.read_text("id")
    if not IDENTITY.fullmatch(identity):
        raise MalformedDeclaration(
            f"« {identity} » : des minuscules sans accent, des chiffres et « _ »", table.place_of("id")
        )
    return identity


def _require_distinct(names: Sequence[str], place: str) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise MalformedDeclaration(f"deux fois le même « id » : {', '.join(twice)}", place)
