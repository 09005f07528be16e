"""Forms of several values together, and forms that are told in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from graders.core.compare.forms import NOTHING, TEXT, AcceptedVariant, ArrayForm, NumberForm, RefusedAnswer, ValueForm
from graders.core.contract.values import Value


@dataclass(frozen=True, kw_only=True)
class TupleForm(ValueForm):
    """Several values by their names; those that are all numbers may also be one array."""

    parts: dict[str, ValueForm]

    _COUNTS: ClassVar[dict[int, str]] = {2: "la paire", 3: "le triplet"}

    @property
    def description(self) -> str:
        names = ", ".join(self.parts)
        inside = " ; ".join(f"{name}, {form.description}" for name, form in self.parts.items())
        return f"{self._COUNTS[len(self.parts)]} ({names}) : {inside}"

    @property
    def _holds_numbers_only(self) -> bool:
        return all(isinstance(form, NumberForm) for form in self.parts.values())

    @property
    def accepted_alternatives(self) -> str:
        whole = "tuple, liste ou tableau" if self._holds_numbers_only else "tuple ou liste"
        nested = any(isinstance(form, ArrayForm) for form in self.parts.values())
        return f"{whole}, dans cet ordre{' ; pour un tableau, des listes conviennent' if nested else ''}"

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        return type(value) is tuple and all(
            form.matches(item, sizes) for form, item in zip(self.parts.values(), value, strict=True)
        )

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        series = [list(form.accepted_variants(item)) for form, item in zip(self.parts.values(), value, strict=True)]
        for k in range(max(map(len, series))):
            turn = [forms[k % len(forms)] for forms in series]
            name = ", ".join(f"{part} : {recast.name}" for part, recast in zip(self.parts, turn, strict=True))
            items = [recast.value for recast in turn]
            yield AcceptedVariant(f"un tuple ({name})", tuple(items))
            yield AcceptedVariant(f"une liste ({name})", items)
        if self._holds_numbers_only:
            yield AcceptedVariant("un tableau", np.array([float(np.asarray(item).item()) for item in value]))

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        whole = (*self.parts, "paire", "triplet", "deux")
        for outsider in (NOTHING, TEXT):
            yield outsider._replace(words=(*outsider.words, *whole))
        yield RefusedAnswer("une valeur de moins", tuple(value)[:-1], whole)
        yield RefusedAnswer("une valeur de trop", (*value, 0.0), whole)
        for k, (name, form) in enumerate(self.parts.items()):
            for outsider in form.refused_answers(value[k]):
                items = [*value[:k], outsider.value, *value[k + 1 :]]
                yield RefusedAnswer(f"{name} : {outsider.name}", tuple(items), (name, *outsider.words))

    def precision_text(self) -> str:
        told = {name: form.precision_text() for name, form in self.parts.items()}
        if len(set(told.values())) == 1 or self.precision or self.tolerance is not None:
            return super().precision_text() or next(iter(told.values()))
        return " ".join(f"{name} : {text[0].lower()}{text[1:]}" for name, text in told.items() if text)


@dataclass(frozen=True, kw_only=True)
class OtherForm(ValueForm):
    """A form that is told in words: `given` tells those that programs get, `recasts` makes the others of an answer."""

    told: str
    accepts: str = ""
    given: Callable[[Value], bool] = lambda value: True
    recasts: Callable[[Value], Iterator[AcceptedVariant]] = lambda value: iter(())
    outsiders: Callable[[Value], Iterator[RefusedAnswer]] = lambda value: iter((NOTHING, TEXT))

    @property
    def description(self) -> str:
        return self.told

    @property
    def accepted_alternatives(self) -> str:
        return self.accepts

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        return self.given(value)

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        return self.recasts(value)

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        return self.outsiders(value)
