"""The data of a verdict's figures and films: what is drawn of them is the business of `server.figures`."""

from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.gradebook import repository
from server.gradebook.schemas import Attempt

NO_FIGURE = "Cette figure n’existe pas."
NO_FILM = "Il n’y a rien à revoir ici."


def load_figure_data(db: Session, attempt: Attempt, name: str, grading: UUID | None = None) -> dict[str, Any]:
    """The stored data of a figure of this attempt's verdict; raises NotFound.

    Of one of its gradings, where that is named: a page that is open shows what it said, whatever counts since.
    """
    shown = _shown(db, attempt, grading)
    data = None if shown is None else repository.figures_of(db, shown).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data


def load_film_data(
    db: Session, attempt: Attempt, check: str, grading: UUID | None = None
) -> tuple[dict[str, Any], str]:
    """The same of a film, with the title of its check."""
    shown = _shown(db, attempt, grading)
    found = None if shown is None else repository.film_of(db, shown, check)
    if found is None or not isinstance(found[0], dict):
        raise NotFound(NO_FILM)
    film, verdict = found
    titles = {one["id"]: one["title"] for one in verdict["checks"]}
    return film, titles.get(check, check)


def _shown(db: Session, attempt: Attempt, grading: UUID | None) -> UUID | None:
    """The grading that is looked at: none of an attempt that a test holds back, whichever is named."""
    counting = None if attempt.grading is None else attempt.grading.id
    if grading is None or grading == counting:
        return counting
    return grading if attempt.held is None and repository.is_of(db, grading, attempt.submission.id) else None
