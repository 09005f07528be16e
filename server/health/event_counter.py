"""Event counts of workers on other machines, kept in the database: a worker's memory ends with it."""

import logging

from sqlalchemy.exc import SQLAlchemyError

from server.database import Database
from server.health import repository

log = logging.getLogger(__name__)

RENEWALS = "template_renewals"


class TemplateRenewalCounter:
    """Thread-safe. A count that cannot be written is lost, and fails no verdict."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def count_template_renewal(self, why: str) -> None:
        """Count a replaced template of the sandbox."""
        try:
            with self._database.write() as db:
                repository.increment_count(db, RENEWALS, why)
        except SQLAlchemyError:
            log.warning("a renewed template (%s) is not counted", why, exc_info=True)
