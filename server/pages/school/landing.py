"""The page to which somebody who has arrived from a platform goes."""

from __future__ import annotations

from urllib.parse import urlencode

from sqlalchemy.orm import Session

from server.federation import contexts
from server.federation.arrivals import Arrival
from server.federation.models import ProviderContext
from server.federation.schemas import CourseRole
from server.identity.models import Account

COURSE_PATH = "/etablissement/cours/{context_id}"
COURSES_PATH = "/etablissement/cours"


def choose_landing_page(
    db: Session, arrival: Arrival, role: CourseRole, requested_path: str, visitor: Account | None
) -> str:
    """Return the page of an arrival: the wanted one, the class of the course, or first the questions to be asked.

    A teacher of a course that no class is tied to is asked for one; a new account is asked whether it is another one's
    where this browser, or the class's list, has such an account.
    """
    tied = [context for context in arrival.contexts if context.class_id is not None]
    context = next(iter(tied or arrival.contexts), None)
    page = requested_path
    if len(arrival.contexts) > 1 and role is CourseRole.teacher and not tied:
        page = f"{COURSES_PATH}?{urlencode({'suite': requested_path})}"
    elif context is not None and role is CourseRole.teacher and context.class_id is None:
        page = f"{COURSE_PATH.format(context_id=context.id)}?{urlencode({'suite': requested_path})}"
    elif context is not None and requested_path == "/" and context.class_id is not None:
        page = f"/classes/{context.class_id}"
    if arrival.is_new and _may_have_another_account(db, arrival, context, visitor):
        login = visitor.login if visitor is not None and visitor.login else ""
        return f"/compte/rejoindre?{urlencode({'identifiant': login, 'suite': page})}"
    return page


def _may_have_another_account(
    db: Session, arrival: Arrival, context: ProviderContext | None, visitor: Account | None
) -> bool:
    """Whether this browser was logged in to another account, or the class has a member of the same name."""
    if visitor is not None and visitor.login is not None and visitor.id != arrival.opened.account.id:
        return True
    if context is None or context.class_id is None:
        return False
    return contexts.may_duplicate_listed_member(db, context.class_id, arrival.opened.account.id)
