"""Statements that are put together once: doing so takes longer than asking them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from inspect import Parameter, signature
from typing import Any, ParamSpec, TypeVar

from sqlalchemy import bindparam

P = ParamSpec("P")
T = TypeVar("T")


def prepared(build: Callable[P, T]) -> Callable[P, tuple[T, dict[str, Any]]]:
    """Of a function that makes a statement, one that gives it with its parameters: `db.execute(*statement(…))`.

    What `build` is given in order stands for the values of each time, which are compared with columns; what it is given
    by name is the same constant for all who ask so, and each makes a statement of its own.
    """
    parameters = signature(build).parameters.values()
    names = [one.name for one in parameters if one.kind is not Parameter.KEYWORD_ONLY]

    @cache
    def statement(**constants: Any) -> T:
        return build(*map(bindparam, names), **constants)  # type: ignore[arg-type]

    @wraps(build)
    def bound(*values: P.args, **constants: P.kwargs) -> tuple[T, dict[str, Any]]:
        return statement(**constants), dict(zip(names, values, strict=True))  # type: ignore[arg-type]

    return bound
