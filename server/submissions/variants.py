"""What was dealt to whom: an account keeps the numbers and the letters of an exercise, whatever it sends."""

import secrets
from uuid import UUID

from sqlalchemy.orm import Session

from server.course.models import SEED_BITS
from server.database import Database
from server.identity.models import Account
from server.submissions import repository


def get_or_create_seed(db: Session, account: Account, exercise_id: str) -> int:
    """The seed of this account's deal, which is made now, in this writing transaction, where there is none yet."""
    repository.insert_seed(db, account.id, exercise_id, secrets.randbits(SEED_BITS))
    return repository.load_seed(db, account.id, exercise_id)


def find_seed(db: Session, account: Account, exercise_id: str) -> int | None:
    """The seed of this account's deal, if there is one."""
    return repository.find_seed(db, account.id, exercise_id)


def seed_while_reading(db: Session, database: Database, account: Account, exercise_id: str) -> int:
    """The same for who only reads, through `db`: the first time alone is anything written, in a transaction of its own,
    of which what `db` reads later may know nothing yet."""
    seed = find_seed(db, account, exercise_id)
    if seed is not None:
        return seed
    with database.write() as writing:
        return get_or_create_seed(writing, account, exercise_id)


def ensure_seed(database: Database, account: Account, exercise_id: str) -> int:
    """The same where nothing else is read."""
    with database.read() as db:
        return seed_while_reading(db, database, account, exercise_id)


def adopt_guest_variants(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Gives an account the deals of a guest; where both have one, the account keeps its own."""
    repository.move_variants(db, guest_id, account_id)
