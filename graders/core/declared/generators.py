"""Drawn inputs, declared as data: « n = entier(1, 9) », « t = liste(reel(0, 1), n, n) », on condition that « a < b ».

Each kind of generator draws a value, says whether a value is one that it may draw, so that a simplified counterexample
stays an input which the statement allows, and proposes simpler ones.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.compare.shrinking import shrink_plain_value
from graders.core.contract.values import Value
from graders.core.declared.malformed import MalformedDeclaration

#: Items of one drawn value; draws until a condition holds.
MAX_ITEMS, MAX_TRIES = 2000, 2000
#: Of drawn words: the shares of those that were drawn before and of those that are made of letters; of double spaces.
REPEATED, MIXED, GAP = 0.3, 0.25, 0.3
Variables = dict[str, Value]
#: A bound: a number, or what makes one from the variables drawn before.
Bound = Callable[[Mapping[str, Value]], float]


class Generator(ABC):
    """A kind of value that is drawn; bounds may depend on variables drawn before."""

    @abstractmethod
    def draw(self, rng: np.random.Generator, variables: Variables) -> Value:
        """Return a value."""

    @abstractmethod
    def contains(self, value: Value, variables: Variables) -> bool:
        """Whether it may draw this value."""

    def iter_simpler_values(self, value: Value) -> Iterator[Value]:
        """Yield simpler values, which it may draw or not."""
        return shrink_plain_value(value)


@dataclass(frozen=True)
class DrawnInteger(Generator):
    low: Bound
    high: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> int:
        low, high = int(self.low(variables)), int(self.high(variables))
        if high < low:
            raise MalformedDeclaration(f"entier({low}, {high}) : rien entre ces deux bornes")
        return int(rng.integers(low, high, endpoint=True))

    def contains(self, value: Value, variables: Variables) -> bool:
        return type(value) is int and self.low(variables) <= value <= self.high(variables)


@dataclass(frozen=True)
class DrawnReal(Generator):
    low: Bound
    high: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> float:
        return float(rng.uniform(self.low(variables), self.high(variables)))

    def contains(self, value: Value, variables: Variables) -> bool:
        return type(value) is float and self.low(variables) <= value <= self.high(variables)


@dataclass(frozen=True)
class DrawnBoolean(Generator):
    def draw(self, rng: np.random.Generator, variables: Variables) -> bool:
        return bool(rng.integers(2))

    def contains(self, value: Value, variables: Variables) -> bool:
        return type(value) is bool


@dataclass(frozen=True)
class DrawnText(Generator):
    alphabet: str
    shortest: Bound
    longest: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> str:
        length = _draw_length(rng, self.shortest, self.longest, variables)
        return "".join(self.alphabet[k] for k in rng.integers(len(self.alphabet), size=length))

    def contains(self, value: Value, variables: Variables) -> bool:
        fits = type(value) is str and self.shortest(variables) <= len(value) <= self.longest(variables)
        return fits and set(value) <= set(self.alphabet)


@dataclass(frozen=True)
class DrawnWords(Generator):
    """A text of given words and of others made of their letters; `gaps`: more than one space may separate them."""

    words: tuple[str, ...]
    shortest: Bound
    longest: Bound
    gaps: bool = False

    def draw(self, rng: np.random.Generator, variables: Variables) -> str:
        drawn: list[str] = []
        for kind in rng.random(_draw_length(rng, self.shortest, self.longest, variables)):
            others = drawn if drawn and kind < REPEATED else self.words
            word = others[int(rng.integers(len(others)))]
            drawn.append(self._draw_mixed_word(rng, len(word)) if kind >= 1.0 - MIXED else word)
        spaces = [" " * (1 + int(self.gaps and rng.random() < GAP)) for _ in drawn]
        return "".join(space + word for space, word in zip(["", *spaces[1:]], drawn, strict=False))

    def _draw_mixed_word(self, rng: np.random.Generator, length: int) -> str:
        """Return another word of about so many of the letters."""
        letters = "".join(self.words)
        return "".join(letters[k] for k in rng.integers(len(letters), size=max(1, length + int(rng.integers(-1, 2)))))

    def contains(self, value: Value, variables: Variables) -> bool:
        if type(value) is not str or not self.shortest(variables) <= len(value.split()) <= self.longest(variables):
            return False
        letters = {letter for word in self.words for letter in word}
        if not all(set(word) <= letters for word in value.split()):
            return False
        return self.gaps or value == " ".join(value.split())

    def iter_simpler_values(self, value: Value) -> Iterator[Value]:
        """Yield texts with a word less, then with fewer letters."""
        words = value.split(" ")
        yield from (" ".join([*words[:at], *words[at + 1 :]]) for at in range(len(words)) if len(words) > 1)
        yield from shrink_plain_value(value)


@dataclass(frozen=True)
class DrawnList(Generator):
    """A list; `kind` is list, tuple or set."""

    item: Generator
    shortest: Bound
    longest: Bound
    kind: type[list[Any]] | type[set[Any]] = list
    ordered: bool = False
    distinct: bool = False

    def draw(self, rng: np.random.Generator, variables: Variables) -> Value:
        length = _draw_length(rng, self.shortest, self.longest, variables)
        items: list[Value] = []
        for _ in range(10 * length + 10):
            if len(items) == length:
                break
            item = self.item.draw(rng, variables)
            if not (self.distinct or self.kind is set) or item not in items:
                items.append(item)
        return self.kind(sorted(items) if self.ordered else items)

    def contains(self, value: Value, variables: Variables) -> bool:
        if type(value) is not self.kind or not self.shortest(variables) <= len(value) <= self.longest(variables):
            return False
        items = list(value)
        if self.ordered and any(after < before for before, after in itertools.pairwise(items)):
            return False
        if self.distinct and any(items.count(item) > 1 for item in items):
            return False
        return all(self.item.contains(item, variables) for item in items)


@dataclass(frozen=True)
class DrawnDictionary(Generator):
    key: Generator
    item: Generator
    shortest: Bound
    longest: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> dict[Value, Value]:
        keys = DrawnList(self.key, self.shortest, self.longest, distinct=True).draw(rng, variables)
        return {key: self.item.draw(rng, variables) for key in keys}

    def contains(self, value: Value, variables: Variables) -> bool:
        if type(value) is not dict or not self.shortest(variables) <= len(value) <= self.longest(variables):
            return False
        return all(self.key.contains(k, variables) and self.item.contains(v, variables) for k, v in value.items())


@dataclass(frozen=True)
class DrawnTuple(Generator):
    items: tuple[Generator, ...]

    def draw(self, rng: np.random.Generator, variables: Variables) -> tuple[Value, ...]:
        return tuple(item.draw(rng, variables) for item in self.items)

    def contains(self, value: Value, variables: Variables) -> bool:
        if type(value) is not tuple or len(value) != len(self.items):
            return False
        return all(item.contains(part, variables) for item, part in zip(self.items, value, strict=True))


@dataclass(frozen=True)
class DrawnArray(Generator):
    """An array of floats in an interval; `shape` may depend on variables."""

    shape: tuple[Bound, ...]
    low: Bound
    high: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> Value:
        shape = tuple(max(0, int(side(variables))) for side in self.shape)
        _require_bounded_size(int(np.prod(shape)))
        return rng.uniform(self.low(variables), self.high(variables), shape)

    def contains(self, value: Value, variables: Variables) -> bool:
        if not isinstance(value, np.ndarray) or value.dtype != np.float64:
            return False
        fits = value.shape == tuple(int(side(variables)) for side in self.shape)
        return fits and bool(((value >= self.low(variables)) & (value <= self.high(variables))).all())


@dataclass(frozen=True)
class DrawnGrid(Generator):
    """A grid of truth values, as many rows and columns as asked; True with this probability."""

    rows: Bound
    columns: Bound
    probability: Bound

    def draw(self, rng: np.random.Generator, variables: Variables) -> Value:
        shape = int(self.rows(variables)), int(self.columns(variables))
        _require_bounded_size(shape[0] * shape[1])
        return rng.random(shape) < self.probability(variables)

    def contains(self, value: Value, variables: Variables) -> bool:
        shape = int(self.rows(variables)), int(self.columns(variables))
        return isinstance(value, np.ndarray) and value.dtype == np.bool_ and value.shape == shape


@dataclass(frozen=True)
class DrawnChoice(Generator):
    options: tuple[Value, ...]

    def draw(self, rng: np.random.Generator, variables: Variables) -> Value:
        return self.options[int(rng.integers(len(self.options)))]

    def contains(self, value: Value, variables: Variables) -> bool:
        return any(type(value) is type(option) and value == option for option in self.options)

    def iter_simpler_values(self, value: Value) -> Iterator[Value]:
        return iter(self.options[: self.options.index(value)] if value in self.options else ())


@dataclass(frozen=True)
class Draws:
    """Variables drawn in turn, under conditions."""

    generators: tuple[tuple[str, Generator], ...]
    conditions: tuple[Callable[[Mapping[str, Value]], Any], ...] = ()

    def draw(self, rng: np.random.Generator) -> Variables:
        """Return the values of the variables. Raises MalformedDeclaration where the conditions hardly ever hold."""
        try:
            for _ in range(MAX_TRIES):
                variables: Variables = {}
                for name, generator in self.generators:
                    variables[name] = generator.draw(rng, variables)
                if self._meets_conditions(variables):
                    return variables
        except (TypeError, ValueError, ArithmeticError) as error:
            raise MalformedDeclaration(f"ces tirages ne se font pas : {error}") from error
        raise MalformedDeclaration(f"la condition n’est presque jamais vraie : {MAX_TRIES} tirages n’y ont pas suffi")

    def allows(self, variables: Variables) -> bool:
        """Whether these values may be drawn."""
        before: Variables = {}
        for name, generator in self.generators:
            if not generator.contains(variables[name], before):
                return False
            before[name] = variables[name]
        return self._meets_conditions(variables)

    def _meets_conditions(self, variables: Variables) -> bool:
        return all(condition(variables) for condition in self.conditions)

    def iter_simpler_variables(self, variables: Variables) -> Iterator[Variables]:
        """Yield allowed values with one variable simplified."""
        for name, generator in self.generators:
            for simpler in generator.iter_simpler_values(variables[name]):
                changed = {**variables, name: simpler}
                if self.allows(changed):
                    yield changed


def _draw_length(rng: np.random.Generator, shortest: Bound, longest: Bound, variables: Variables) -> int:
    low, high = int(shortest(variables)), int(longest(variables))
    _require_bounded_size(high)
    if not 0 <= low <= high:
        raise MalformedDeclaration(f"longueurs de {low} à {high} : rien entre ces deux bornes")
    return int(rng.integers(low, high, endpoint=True))


def _require_bounded_size(items: int) -> None:
    if items > MAX_ITEMS:
        raise MalformedDeclaration(f"une valeur de {items} éléments ; {MAX_ITEMS} au plus")
