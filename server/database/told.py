"""Rows as a database tells them. They cost half as much as rows that are read, and are the same as long as nothing has
changed: what is made of many rows can be kept, and made again only where they are told otherwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeAlias, TypeVar

from sqlalchemy import JSON, ColumnElement, type_coerce
from sqlalchemy.orm import Session
from sqlalchemy.types import NullType

from server.database.base import Base, CachedUuid, UtcDateTime, table_of
from server.database.prepared import loaded

Model = TypeVar("Model", bound=Base)
Told: TypeAlias = tuple[Any, ...]
#: The types of which a database tells something else than what is read.
READ = (CachedUuid, UtcDateTime, JSON)


class Telling:
    """Of these columns: how they are asked for, and how what is told is read."""

    def __init__(self, *columns: ColumnElement[Any]) -> None:
        self._columns = columns
        self._read = [place for place, one in enumerate(columns) if isinstance(one.type, READ)]

    @property
    def asked(self) -> Sequence[ColumnElement[Any]]:
        read = set(self._read)
        return [type_coerce(one, NullType) if place in read else one for place, one in enumerate(self._columns)]

    def reader(self, db: Session) -> Callable[[Told], Sequence[Any]]:
        dialect = db.get_bind().dialect
        types = ((place, self._columns[place].type.dialect_impl(dialect)) for place in self._read)
        found = ((place, kind.result_processor(dialect, None)) for place, kind in types)
        processors = [(place, processor) for place, processor in found if processor is not None]

        def read(told: Told) -> Sequence[Any]:
            values = list(told)
            for place, processor in processors:
                values[place] = processor(values[place])
            return values

        return read


class Copies(Telling, Generic[Model]):
    """Of a model's rows. The objects that are made of them are of no session: what is kept of one transaction for
    another neither expires nor is written."""

    def __init__(self, model: type[Model]) -> None:
        columns = table_of(model).columns
        super().__init__(*columns)
        self._model, self._names = model, columns.keys()

    def made(self, db: Session, rows: Sequence[Told]) -> Sequence[Model]:
        read = self.reader(db)
        return [loaded(self._model, zip(self._names, read(row), strict=True)) for row in rows]
