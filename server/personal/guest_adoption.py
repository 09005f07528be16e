"""Transfer of a guest's data, or of an account opened by another system, to the account of the same person."""

from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import exemption_service, sitting_repository, sittings, team_repository
from server.audit import repository as audit
from server.base.errors import Conflict
from server.classes import service as classes
from server.comments import service as comments
from server.federation import personal_rows
from server.gradebook import service as gradebook
from server.lesson import repository as lessons
from server.marks import service as marks
from server.personal import erasure_repository
from server.polls import repository as polls
from server.recall import repository as recall

STAFF = (
    "Ce compte-ci enseigne déjà dans une classe, et ne peut plus en rejoindre un autre. Faites entrer l’autre compte "
    "dans vos classes (Réglages, « Équipe enseignante »)."
)
SAT_TWICE = (
    "Les deux comptes ont composé dans le même contrôle : ils restent séparés, pour que chaque copie garde son temps. "
    "Votre enseignant dit laquelle compte."
)


def require_joinable(db: Session, newcomer_id: UUID, account_id: UUID) -> None:
    """Raise Conflict where the data of an account cannot move to another one: it teaches, or both sat one test."""
    if erasure_repository.has_been_staff(db, newcomer_id):
        raise Conflict(STAFF)
    if sitting_repository.has_common_sitting(db, newcomer_id, account_id):
        raise Conflict(SAT_TWICE)


def adopt_guest_data(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move attempts, variants, answers, choices, comments, sittings, memberships, exemptions, marks and visits.

    Runs inside the caller's transaction.
    """
    comments.move_guest_threads(db, guest_id, account_id)
    gradebook.move_guest_attempts(db, guest_id, account_id)
    sittings.move_guest_sittings(db, guest_id, account_id)
    classes.move_guest_memberships(db, guest_id, account_id)
    exemption_service.move_guest_exemptions(db, guest_id, account_id)
    team_repository.move_team_places(db, guest_id, account_id)
    marks.move_guest_marks(db, guest_id, account_id)
    polls.move_poll_answers(db, guest_id, account_id)
    recall.move_answers_and_choices(db, guest_id, account_id)
    lessons.move_visits(db, guest_id, account_id)
    personal_rows.move_account_rows(db, guest_id, account_id)
    audit.move_events(db, guest_id, account_id)
