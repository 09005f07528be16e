"""Statements that are put together once: doing so takes longer than asking them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, TypeVarTuple

from sqlalchemy import bindparam, or_
from sqlalchemy.orm import make_transient_to_detached
from sqlalchemy.orm.attributes import instance_dict

from server.database.base import Base, table_of

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, CursorResult
    from sqlalchemy.orm import InstrumentedAttribute, Session
    from sqlalchemy.sql.dml import UpdateBase
    from sqlalchemy.sql.selectable import TypedReturnsRows

P = ParamSpec("P")
T = TypeVar("T")
Model = TypeVar("Model", bound=Base)
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


def one_of(column: InstrumentedAttribute[Any], values: Collection[object]) -> ColumnElement[bool]:
    """Whether it holds one of a few constants. With `in_`, the text of a statement is made anew each time that it is
    asked, as there may be any number of values: that takes longer than asking it."""
    return or_(*(column == value for value in values))


def loaded(model: type[Model], values: Iterable[tuple[str, object]]) -> Model:
    """What a session gives of these columns of a row, once it is closed: in a third of the time, where nobody changes
    it. A column that was not asked for is an error, and never None."""
    found = model()
    instance_dict(found).update(values)
    make_transient_to_detached(found)
    return found


@cache
def _names(model: type[Base]) -> tuple[str, ...]:
    return tuple(table_of(model).c.keys())


def rows_of(model: type[Model], rows: Iterable[Sequence[Any]]) -> Iterator[tuple[Model, Sequence[Any]]]:
    """`loaded` of rows that begin with all the columns of a model's table; with what comes after these."""
    names = _names(model)
    for row in rows:
        yield loaded(model, zip(names, row, strict=False)), row[len(names) :]


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
