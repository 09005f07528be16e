"""How a transaction of SQLite begins. Its driver would open it by itself, too late; were that told by an event, each
statement would take a third longer: all of them then look for events."""

from sqlalchemy import Engine, PoolProxiedConnection
from sqlalchemy.dialects import registry
from sqlalchemy.dialects.sqlite.pysqlite import SQLiteDialect_pysqlite

DRIVER = "balise"


class Reading(SQLiteDialect_pysqlite):
    """Transactions read what is there when they first look; they write where nobody else has meanwhile."""

    supports_statement_cache = True

    def do_begin(self, dbapi_connection: PoolProxiedConnection) -> None:
        dbapi_connection.execute("BEGIN")


class Writing(Reading):
    """Transactions wait for their turn to write before they begin."""

    supports_statement_cache = True

    def do_begin(self, dbapi_connection: PoolProxiedConnection) -> None:
        dbapi_connection.execute("BEGIN IMMEDIATE")


registry.register(f"sqlite.{DRIVER}", __name__, Reading.__name__)


def writing(engine: Engine) -> Engine:
    """The same engine, whose transactions begin as those that write. What it learns of the database, both know."""
    found = engine.execution_options()
    if isinstance(engine.dialect, Reading):
        found.dialect = dialect = Writing.__new__(Writing)
        dialect.__dict__ = vars(engine.dialect)
    return found
