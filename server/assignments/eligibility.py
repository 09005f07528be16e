"""Who may begin a test: somebody whose account says who they are, once under each name of the class.

Whoever has the join code of a class may give themselves any name: a guest begins no test, and an account that only its
owner has named begins none under the name of a student of the list, nor of somebody who has begun it already. Both
would be a second clock, or a place taken from somebody else. Functions work inside the caller's transaction.
"""

from __future__ import annotations

from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import sitting_repository
from server.assignments.models import Assignment
from server.base.errors import Forbidden
from server.classes import repository as classes
from server.classes.models import Membership
from server.classes.namesakes import find_namesakes
from server.classes.schemas import Member
from server.identity import repository as identity
from server.identity.models import Account

GUEST = (
    "Un invité ne commence pas de contrôle : n’importe qui peut s’être donné ce nom. Connectez-vous, ou choisissez "
    "votre mot de passe avec la fiche de connexion que votre enseignant vous a remise ; sans compte, créez-en "
    "un. Votre travail vous suit."
)
NAMESAKE = (
    "Un autre élève de cette classe s’appelle « {name} », et son compte est celui de la liste, ou a déjà commencé ce "
    "contrôle. Si c’est vous, connectez-vous avec ce compte-là. Sinon, votre enseignant le confirme sur la page des "
    "élèves de la classe : « Ce n’est pas la même personne »."
)
ENDED = "Ce compte est suspendu, ou va être effacé : il ne commence pas de contrôle."


def explain_begin_refusal(db: Session, test: Assignment, account: Account, membership: Membership) -> str:
    """Return why an account may not begin a test now; empty where it may, or has begun it."""
    if sitting_repository.load_sitting(db, test.id, account.id) is not None:
        return ""
    if account.is_guest:
        return GUEST
    if not membership.is_confirmed and (namesake := _find_conflicting_namesake(db, test, account.id)) is not None:
        return NAMESAKE.format(name=namesake.name)
    return ""


def require_may_begin(db: Session, test: Assignment, account: Account, membership: Membership) -> None:
    """Raise Forbidden where an account may not begin a test.

    Two accounts of one name, and an account that is about to be erased, wait for each other's commit.
    """
    if not membership.is_confirmed:
        classes.lock_class(db, test.class_id)
    current = identity.lock_account(db, account.id)
    if current is None or current.disabled_at is not None:
        raise Forbidden(ENDED)
    refusal = explain_begin_refusal(db, test, account, membership)
    if refusal:
        raise Forbidden(refusal)


def _find_conflicting_namesake(db: Session, test: Assignment, account_id: UUID) -> Member | None:
    """Return another student of one of the account's names, who is of the list or has begun the test."""
    begun = sitting_repository.load_sittings(db, [test.id])
    namesakes = find_namesakes(classes.load_members(db, test.class_id), account_id)
    return next(
        (member for member in namesakes if member.membership.is_confirmed or (test.id, member.id) in begun), None
    )
