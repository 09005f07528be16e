"""Statements that are put together once: doing so takes longer than asking them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, TypeVarTuple

from sqlalchemy import bindparam

if TYPE_CHECKING:
    from sqlalchemy import CursorResult
    from sqlalchemy.orm import Session
    from sqlalchemy.sql.dml import UpdateBase
    from sqlalchemy.sql.selectable import TypedReturnsRows

P = ParamSpec("P")
T = TypeVar("T")
Ts = TypeVarTuple("Ts")


def ask(db: Session, statement: TypedReturnsRows[*Ts], values: Mapping[str, Any]) -> CursorResult[*Ts]:
    """Asks for columns, and for no object, in the session's transaction: without what the session does for objects,
    which takes longer than the question. What it has not written yet is written first, as it always is."""
    db.flush()
    return db.connection().execute(statement, values)


def change(db: Session, statement: UpdateBase, values: Mapping[str, Any]) -> None:
    """The same of a statement that writes one row of a table, and gives nothing back."""
    db.flush()
    db.connection().execute(statement, values)


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
