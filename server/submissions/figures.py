"""The data of a verdict's figures: what is drawn from them is the business of `server.figures`."""

from typing import Any

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.submissions import repository
from server.submissions.models import Submission

NO_FIGURE = "Cette figure n’existe pas."


def figure_data(db: Session, submission: Submission, name: str) -> dict[str, Any]:
    """The stored data of a figure of this submission's verdict; raises NotFound."""
    data = repository.figures_of(db, submission.id).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data
