"""The data of a verdict's figures: what is drawn from them is the business of `server.figures`."""

from typing import Any

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.gradebook import repository
from server.gradebook.schemas import Attempt

NO_FIGURE = "Cette figure n’existe pas."


def figure_data(db: Session, attempt: Attempt, name: str) -> dict[str, Any]:
    """The stored data of a figure of this attempt's verdict; raises NotFound."""
    data = None if attempt.grading is None else repository.figures_of(db, attempt.grading.id).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data
