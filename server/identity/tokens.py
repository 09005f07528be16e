"""API tokens: a few for each account, good for a while. Functions work inside the caller's transaction."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.base.settings import Settings
from server.database import Database, utc_now
from server.identity import repository, secrets
from server.identity.models import Account, ApiToken
from server.identity.schemas import RefusedForm, validate_token_label

#: How late the page may be about when a token last served: what is asked with one writes nothing otherwise.
LAST_USE_INTERVAL = timedelta(hours=1)
FULL = "Vous avez déjà {most} jetons : révoquez-en un d’abord."


def create_token(db: Session, account: Account, label: str, settings: Settings) -> tuple[ApiToken, str]:
    """The token's row, and its secret: shown once, never stored. Raises RefusedForm."""
    name, now = validate_token_label(label), utc_now()
    repository.lock_account(db, account.id)
    repository.delete_ended_tokens(db, account.id, now)
    if repository.count_tokens(db, account.id) >= settings.api_tokens:
        raise RefusedForm({"label": FULL.format(most=settings.api_tokens)})
    secret = secrets.new_token(secrets.API_PREFIX)
    ends = now + timedelta(days=settings.api_token_days)
    token = ApiToken(account_id=account.id, label=name, token_digest=secrets.digest(secret), expires_at=ends)
    db.add(token)
    db.flush()
    return token, secret


def load_tokens(db: Session, account: Account) -> Sequence[ApiToken]:
    """Those that are still good, oldest first."""
    return repository.load_valid_tokens(db, account.id, utc_now())


def revoke_token(db: Session, account: Account, token_id: UUID) -> None:
    """Raises NotFound."""
    if not repository.delete_token(db, account.id, token_id):
        raise NotFound("Ce jeton n’existe pas, ou a déjà été révoqué.")


def find_token_owner(database: Database, secret: str) -> Account | None:
    """Whose token it is; the time of its use is noted, now and then."""
    digest, now = secrets.digest(secret), utc_now()
    with database.read() as db:
        found = repository.find_account_by_token(db, digest, now)
    if found is None:
        return None
    account, last_used_at = found
    if _worth_noting(last_used_at, now):
        with database.write() as db:
            repository.update_last_use(db, digest, now)
    return account


def _worth_noting(last_used_at: datetime | None, now: datetime) -> bool:
    return last_used_at is None or now - last_used_at > LAST_USE_INTERVAL
