"""Alembic's entry point: the connection is given by `server.database.migrate`.

The rooms stand above this one: whoever compares them with the database gives their `metadata` along.
"""

from alembic import context

given = context.config.attributes
context.configure(connection=given["connection"], target_metadata=given.get("metadata"), render_as_batch=True)
context.run_migrations()
