"""Fast statements for the hot path, from a submission to its verdict; other code should use the ORM or `select`.

Three shortcuts: statements are built once and take bind parameters, rows are read as columns on the session's
connection, and ORM objects are built from columns, detached. Together they save 10 to 17 ms of processor time of a
submission that is stored, recorded and read again (8 against 20 at the least, quiet machine), and 6 ms normalised of
the median from submit to verdict over HTTP (13.6 against 19.6; row `http` of `tests/benchmarks/all.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, wraps
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, TypeVarTuple

from sqlalchemy import bindparam
from sqlalchemy.orm import make_transient_to_detached

from server.database.base import Base, table_of

if TYPE_CHECKING:
    from sqlalchemy import CursorResult
    from sqlalchemy.orm import Session
    from sqlalchemy.sql.dml import UpdateBase
    from sqlalchemy.sql.selectable import TypedReturnsRows

P = ParamSpec("P")
T = TypeVar("T")
Model = TypeVar("Model", bound=Base)
Ts = TypeVarTuple("Ts")


def select_core(db: Session, statement: TypedReturnsRows[*Ts], values: Mapping[str, Any]) -> CursorResult[*Ts]:
    """Execute a statement that returns columns, in the session's transaction, after a flush, without the ORM."""
    db.flush()
    return db.connection().execute(statement, values)


def write_core(db: Session, statement: UpdateBase, values: Mapping[str, Any] | Sequence[Mapping[str, Any]]) -> None:
    """Execute an INSERT, UPDATE or DELETE, once for each of `values`, in the session's transaction, without the ORM."""
    db.flush()
    db.connection().execute(statement, values)


def detached_instance(model: type[Model], values: Iterable[tuple[str, object]]) -> Model:
    """Build a detached, read-only ORM object of these columns. Any other column raises DetachedInstanceError."""
    instance = model()
    vars(instance).update(values)
    make_transient_to_detached(instance)
    return instance


@cache
def _column_names(model: type[Base]) -> tuple[str, ...]:
    return tuple(table_of(model).c.keys())


def detached_instances(model: type[Model], rows: Iterable[Sequence[Any]]) -> Iterator[tuple[Model, Sequence[Any]]]:
    """Yield the `detached_instance` of rows that begin with all columns of a table, with the columns that follow."""
    names = _column_names(model)
    for row in rows:
        yield detached_instance(model, zip(names, row, strict=False)), row[len(names) :]


def prepared_statement(build: Callable[P, T]) -> Callable[P, tuple[T, dict[str, Any]]]:
    """Decorate a function that builds a statement, so that it is built once: `db.execute(*statement(…))`.

    Positional arguments become bind parameters. Keyword arguments are constants: each combination is one statement.
    """
    parameters = signature(build).parameters.values()
    names = [parameter.name for parameter in parameters if parameter.kind is not Parameter.KEYWORD_ONLY]

    @cache
    def statement(**constants: Any) -> T:
        return build(*map(bindparam, names), **constants)  # type: ignore[arg-type]

    @wraps(build)
    def bound(*values: P.args, **constants: P.kwargs) -> tuple[T, dict[str, Any]]:
        return statement(**constants), dict(zip(names, values, strict=True))  # type: ignore[arg-type]

    return bound
