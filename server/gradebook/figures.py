"""The data of a verdict's figures: what is drawn from them is the business of `server.figures`."""

from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.gradebook import repository
from server.gradebook.schemas import Attempt

NO_FIGURE = "Cette figure n’existe pas."


def figure_data(db: Session, attempt: Attempt, name: str, grading: UUID | None = None) -> dict[str, Any]:
    """The stored data of a figure of this attempt's verdict; raises NotFound.

    Of one of its gradings, where that is named: a page that is open shows what it said, whatever counts since.
    """
    counting = None if attempt.grading is None else attempt.grading.id
    if grading is not None and grading != counting and not repository.is_of(db, grading, attempt.submission.id):
        raise NotFound(NO_FIGURE)
    shown = grading or counting
    data = None if shown is None else repository.figures_of(db, shown).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data
