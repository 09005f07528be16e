"""What the workers of other machines count, kept in the database: what they know of themselves ends with them."""

import logging

from sqlalchemy.exc import SQLAlchemyError

from server.database import Database
from server.health import repository

log = logging.getLogger(__name__)

RENEWALS = "template_renewals"


class EventCounter:
    """For several threads. A count that cannot be written is lost, and costs no verdict."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def count_template_renewal(self, why: str) -> None:
        """A template of the sandbox was replaced."""
        try:
            with self._database.write() as db:
                repository.increment_count(db, RENEWALS, why)
        except SQLAlchemyError:
            log.warning("a renewed template (%s) is not counted", why, exc_info=True)
