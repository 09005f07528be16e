"""The service of accounts, tied to what other rooms know of a person: work, rights, the audit log."""

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.settings import Settings
from server.database import Database
from server.identity.models import Account
from server.identity.service import AccountService
from server.personal.guest_adoption import adopt_guest_data, require_joinable
from server.rights import slips

BY_LINK = "lien à usage unique"


def make_account_service(database: Database, settings: Settings) -> AccountService:
    """Return the service that signs people up, and logs them in."""
    return AccountService(
        database,
        settings,
        adopt_guest_data=adopt_guest_data,
        is_link_in_force=slips.is_password_link_in_force,
        check_join=require_joinable,
        record_invited=_record_invitation_used,
    )


def _record_invitation_used(db: Session, account: Account) -> None:
    """Record in the administrators' log that an invitation was used: who is there now, with which role."""
    audit.record_event(
        db, None, account.id, AuditAction.account_created, student=account.id, about=BY_LINK,
        after={"role": account.role},
    )  # fmt: skip
