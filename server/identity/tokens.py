"""API tokens: a few for each account, with an expiry. Functions work inside the caller's transaction."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.base.settings import Settings
from server.base.turns import record_sender
from server.database import Database, utc_now
from server.identity import repository, secrets
from server.identity.models import Account, ApiToken
from server.identity.schemas import RefusedForm, validate_token_label

#: How often the last use of a token is written: most requests write nothing.
LAST_USE_INTERVAL = timedelta(hours=1)
FULL = "Vous avez déjà {most} jetons : révoquez-en un d’abord."


def create_token(db: Session, account: Account, label: str, settings: Settings) -> tuple[ApiToken, str]:
    """Create a token, and return its row and its secret, which is never stored. Raises RefusedForm."""
    name, now = validate_token_label(label), utc_now()
    repository.lock_account(db, account.id)
    repository.delete_expired_tokens(db, account.id, now)
    if repository.count_tokens(db, account.id) >= settings.api_tokens:
        raise RefusedForm({"label": FULL.format(most=settings.api_tokens)})
    secret = secrets.draw_secret_token(secrets.API_PREFIX)
    ends = now + timedelta(days=settings.api_token_days)
    token = ApiToken(account_id=account.id, label=name, token_digest=secrets.sha256_hex(secret), expires_at=ends)
    db.add(token)
    db.flush()
    return token, secret


def load_tokens(db: Session, account: Account) -> Sequence[ApiToken]:
    """Load the valid tokens of an account, oldest first."""
    return repository.load_valid_tokens(db, account.id, utc_now())


def revoke_token(db: Session, account: Account, token_id: UUID) -> None:
    """Raises NotFound."""
    if not repository.delete_token(db, account.id, token_id):
        raise NotFound("Ce jeton n’existe pas, ou a déjà été révoqué.")


def find_token_owner(database: Database, secret: str) -> Account | None:
    """Return the account of a token; its last use is recorded now and then."""
    digest, now = secrets.sha256_hex(secret), utc_now()
    with database.read() as db:
        row = repository.find_account_by_token(db, digest, now)
    if row is None:
        return None
    account, last_used_at = row
    record_sender(secret, account.id, is_guest=account.is_guest)
    if _is_last_use_update_due(last_used_at, now):
        with database.write() as db:
            repository.update_token_last_use(db, digest, now)
    return account


def _is_last_use_update_due(last_used_at: datetime | None, now: datetime) -> bool:
    return last_used_at is None or now - last_used_at > LAST_USE_INTERVAL
