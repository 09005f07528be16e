"""Transfer of a guest's data to the account that the same person has opened."""

from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import exemption_service, sittings
from server.audit import repository as audit
from server.classes import service as classes
from server.comments import service as comments
from server.gradebook import service as gradebook
from server.lesson import repository as lessons
from server.marks import service as marks
from server.polls import repository as polls


def adopt_guest_data(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move attempts, variants, poll answers, comments, sittings, memberships, exemptions, marks and visits.

    Runs inside the caller's transaction.
    """
    comments.adopt(db, guest_id, account_id)
    gradebook.adopt_attempts(db, guest_id, account_id)
    sittings.adopt(db, guest_id, account_id)
    classes.adopt(db, guest_id, account_id)
    exemption_service.adopt(db, guest_id, account_id)
    marks.adopt_marks(db, guest_id, account_id)
    polls.move_answers(db, guest_id, account_id)
    lessons.move_visits(db, guest_id, account_id)
    audit.move_events(db, guest_id, account_id)
